"""The command line: exit statuses, what goes where, and that machines can read it."""
