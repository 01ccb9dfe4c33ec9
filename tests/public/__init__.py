"""What callers rely on, held while everything behind it may move: public names, keys of answers, commands.

These tests know of the package what every user knows: `import handlcp as hl`, and the command line. What they compare
with is kept in `surface.json`:

    python -m tests.public          says what differs from it
    python -m tests.public write    writes it anew

A line of that file that goes or changes is a change that breaks somebody's program: it belongs in the changelog.
"""
