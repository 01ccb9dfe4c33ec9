"""The figure of a grasp followed through its loading, and the picture of the hand where it ends."""

from handlcp.show.loading.draw import figure
from handlcp.show.loading.report import picture, save_picture

__all__ = ["figure", "picture", "save_picture"]
