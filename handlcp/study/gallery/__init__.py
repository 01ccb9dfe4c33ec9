"""The gallery: found grasps of every hand at hand, their margins, and a page of them."""

from handlcp.study.gallery.run import Drawing, page, run
from handlcp.study.gallery.shelf import GALLERY_HANDS, Model, Shelf, model, shelf, things

__all__ = ["GALLERY_HANDS", "Drawing", "Model", "Shelf", "model", "page", "run", "shelf", "things"]
