"""The linear equations that small changes of a grasp obey while its contacts keep their states, and their solutions."""
