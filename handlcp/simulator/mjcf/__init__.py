"""Parts of a grasp as MJCF: links, springs, fingertips, object, supports; and the settings that they share."""
