"""What a hand holds: shapes, the contacts that geometry finds on them, and closing the fingers. Imports robot."""
