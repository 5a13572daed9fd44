"""Sphinx: the documentation site, built offline by ``make docs``; warnings are errors."""

import blockstruct

project = "blockstruct"
author = "The blockstruct developers"
copyright = "The blockstruct developers, MIT license"  # noqa: A001 - Sphinx reads this name
release = blockstruct.__version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
]
exclude_patterns = ["_build", "**/.ipynb_checkpoints"]
html_theme = "furo"
html_title = "blockstruct"
html_static_path = ["pictures"]

# The numbers of a page are those of the version that builds it.
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_show_tb = True
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["mystnb.unknown_mime_type"]

autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False
# Formulas are drawn where the reader is: the site itself fetches nothing when it is built.
mathjax3_config = {"tex": {"macros": {"vec": ["\\boldsymbol{#1}", 1]}}}
