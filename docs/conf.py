"""How Sphinx builds the documentation: `sphinx-build -W -n docs build/docs`."""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [os.fspath(HERE / "tools"), os.fspath(HERE.parent)]

import handlcp  # noqa: E402  found in this checkout, one folder up

project = "handlcp"
author = "The handlcp authors"
project_copyright = "2026, the handlcp authors"
version = release = handlcp.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton", "mathml", "pages", "docstrings"]
exclude_patterns = ["tools"]
nitpicky = True

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}

html_theme = "furo"
html_title = f"handlcp {release}"
html_static_path = ["static"]
html_css_files = ["handlcp.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
copybutton_prompt_text = "$ "
pygments_style = "friendly"
