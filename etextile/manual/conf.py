"""Sphinx configuration of the manual (built from a copy of this folder: etextile/manual/build.py)."""

from importlib.metadata import version as version_of


project = "etextile"
author = "the etextile developers"
project_copyright = author
version = release = version_of("etextile")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "etextile.manual.extensions.effects",
    "etextile.manual.extensions.formats",
    "etextile.manual.extensions.mathml",
]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist", "fieldlist"]
myst_heading_anchors = 3
exclude_patterns = ["html", "**/__pycache__"]
html_math_renderer = "mathml"
math_numfig = False
default_role = "literal"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True

html_theme = "pydata_sphinx_theme"
html_title = f"etextile {release}"
html_static_path = ["static"]
html_css_files = ["manual.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
