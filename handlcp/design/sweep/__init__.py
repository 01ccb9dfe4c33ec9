"""A sweep: many designs through one brief, on cores or a cluster, in a table that survives whatever stops it."""
