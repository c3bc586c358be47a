"""How the site is built: `./run docs`, or `python tools/site`."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tools"))

from importlib.metadata import version as installed  # noqa: E402

project = "stickslip"
author = "The stickslip developers"
project_copyright = author
version = release = installed("stickslip")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "website.docstrings",
    "website.mathml",
]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["figures", "files"]  # copied, not read
suppress_warnings = ["ref.python"]  # a short name like `t` in a docstring may be of several classes
highlight_language = "none"
default_role = "code"
keep_warnings = False

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"stickslip {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = False  # a browser does not let a page from disk fetch another
html_theme_options = {"navigation_with_keys": True}
pygments_style = "default"
pygments_dark_style = "github-dark"
