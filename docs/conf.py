"""The site, for Sphinx; `docs/build` runs it."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from warmlink.fmus.packaging.release import COPYRIGHT
from warmlink.fmus.packaging.release import version as release_version

project = "warmlink"
copyright = COPYRIGHT.removeprefix("Copyright (c) ")
release = release_version()
html_title = f"warmlink {release}"
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["figures.js"]
html_show_sourcelink = False
html_copy_source = False
exclude_patterns = ["decisions", "compatibility.md"]
"""Read by themselves, and shown with links that hold here: see extension/texts.py."""

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "extension"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
html_math_renderer = "mathml"
default_role = "literal"
smartquotes = False
"""They make one dash of the two before an option."""

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
nitpicky = False
