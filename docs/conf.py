"""Sphinx: the documentation site, built offline by ``make docs``; warnings are errors."""

import re
from collections.abc import Callable

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

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
# Formulas are MathML, which browsers draw themselves: the site fetches nothing, neither built nor read.
html_math_renderer = "mathml"
myst_update_mathjax = False


def mathml(display: str) -> tuple[Callable[[HTML5Translator, nodes.Element], None], None]:
    """How a formula is written: the functions that Sphinx calls."""

    def visit(writer: HTML5Translator, node: nodes.Element) -> None:
        formula = re.sub(r"\\vec\s*(\w)", r"\\boldsymbol{\1}", node.astext())
        writer.body.append(convert(formula, display=display))
        raise nodes.SkipNode

    return visit, None


def setup(app: Sphinx) -> None:
    """Tell Sphinx of them."""
    app.add_html_math_renderer("mathml", inline_renderers=mathml("inline"), block_renderers=mathml("block"))
