"""The table: what every hand at hand holds of every common object, how sure that is, and what MuJoCo says of it."""
