"""The gallery: found grasps of every hand at hand, their margins, and a page of them."""

from handlcp.study.gallery.models import GALLERY_HANDS, Model, model
from handlcp.study.gallery.page import page
from handlcp.study.gallery.run import Drawing, run
from handlcp.study.gallery.shelf import Shelf, shelf
from handlcp.study.gallery.things import things

__all__ = ["GALLERY_HANDS", "Drawing", "Model", "Shelf", "model", "page", "run", "shelf", "things"]
