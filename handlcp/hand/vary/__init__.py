"""The same hand with other numbers, by name. Imports robot and parts."""
