"""The page of a table of hands and objects."""
