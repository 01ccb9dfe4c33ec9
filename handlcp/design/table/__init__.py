"""The table: what every hand at hand holds of every common object, how sure that is, and what MuJoCo says of it."""

SECONDS = 9.0  # of computing that finding a grasp may take: with it the whole table takes three hours on two cores
