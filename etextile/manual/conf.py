"""Sphinx configuration of the manual (built from a copy of this folder: etextile/manual/build.py)."""

from importlib.metadata import version as version_of


project = "etextile"
author = "the etextile developers"
project_copyright = author
version = release = version_of("etextile")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_gallery.gen_gallery",
    "etextile.manual.extensions.commands",
    "etextile.manual.extensions.effects",
    "etextile.manual.extensions.formats",
    "etextile.manual.extensions.mathml",
]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist", "fieldlist"]
myst_heading_anchors = 3
exclude_patterns = ["html", "scripts", "**/__pycache__"]
html_math_renderer = "mathml"
math_numfig = False
default_role = "literal"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True

sphinx_gallery_conf = {
    "examples_dirs": "scripts",  # the folder gallery of the sources, see build.py
    "gallery_dirs": "gallery",
    "filename_pattern": "",
    "image_scrapers": ("etextile.manual.extensions.pictures.scrape",),
    "reset_modules": ("etextile.manual.extensions.pictures.prepare",),
    "capture_repr": (),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "write_computation_times": False,
    "within_subsection_order": "FileNameSortKey",
}

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
