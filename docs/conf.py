"""Sphinx: the documentation site, built offline by ``make docs``; warnings are errors."""

import inspect
import re
import sys
from collections.abc import Callable
from importlib import import_module
from types import FunctionType

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

import blockstruct

# Sphinx finds a name in the module it is read from: that of ties is another room's.
sys.modules["blockstruct.ties"] = blockstruct.ties

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
exclude_patterns = ["_build", "templates", "**/.ipynb_checkpoints"]
html_theme = "furo"
html_title = "blockstruct"
html_static_path = ["pictures", "static"]
html_css_files = ["site.css"]
templates_path = ["templates"]

# The numbers of a page are those of the version that builds it.
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_show_tb = True
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
# The context below holds a function, which Sphinx cannot keep for the next build.
suppress_warnings = ["mystnb.unknown_mime_type", "config.cache"]


def documented(module: str, name: str, members: list[str]) -> list[str]:
    """Methods and properties of a class that say something; its fields are in its docstring."""
    owner = getattr(import_module(module), name)
    found = {member: inspect.getattr_static(owner, member, None) for member in members}
    kinds = (property, classmethod, staticmethod, FunctionType)
    return [n for n, member in found.items() if n[0] != "_" and isinstance(member, kinds) and inspect.getdoc(member)]


autosummary_generate = True
autosummary_context = {"documented": documented}
autodoc_typehints = "none"
numpydoc_show_class_members = False
# Formulas are MathML, which browsers draw themselves: the site fetches nothing, neither built nor read.
html_math_renderer = "mathml"
myst_update_mathjax = False
#: What browsers draw otherwise than meant: vectors are bold, units upright, functions stand apart and bars do not.
SPELT = (
    (r"\\vec\s*([a-z])", lambda found: chr(ord("𝒂") + ord(found[1]) - ord("a"))),
    (r"\\mathrm\{([A-Za-z]+)\}", r"\\text{\1}"),
    (r"\\tan\s*(?=\\)", r"\\tan\\,"),
    (r"\\[lr]vert(?![A-Za-z])\s*", r"\\text{|}"),
    (r"\\[lr]Vert(?![A-Za-z])\s*", r"\\text{‖}"),
)


def mathml(display: str) -> tuple[Callable[[HTML5Translator, nodes.Element], None], None]:
    """How a formula is written: the functions that Sphinx calls."""
    block = display == "block"

    def visit(writer: HTML5Translator, node: nodes.Element) -> None:
        formula, _, number = node.astext().partition(r"\tag")
        for pattern, instead in SPELT:
            formula = re.sub(pattern, instead, formula)
        shown = convert(formula, display=display)
        label = f'<span class="number">({number.strip(" {}")})</span>' if number else ""
        writer.body.append(f'<div class="math">{shown}{label}</div>' if block else shown)
        raise nodes.SkipNode

    return visit, None


#: A hidden cell and the last line of each page of the gallery.
SAME = """
```{{code-cell}} ipython3
:tags: [remove-cell]
from pathlib import Path
Path("{name}.yaml").unlink(missing_ok=True)
cases = [r.case for r in around.analysis.values()] if "around" in globals() else [result.case]
bs.documents.write_document("{name}.yaml", model, cases)
assert bs.read_document("{name}.yaml").model.hash == model.hash
```

The same as a {{nb-download}}`notebook <{name}.ipynb>`
and as a {{download}}`model document <{name}.yaml>`, for `blockstruct run`.
"""


def offer(app: Sphinx, page: str, source: list[str]) -> None:
    """Offer a page of the gallery as a notebook and as a model document, which its run writes."""
    folder, _, name = page.partition("/")
    if folder == "gallery" and name:
        source[0] += SAME.format(name=name)


def setup(app: Sphinx) -> None:
    """Register the formulas and the downloads."""
    app.connect("source-read", offer)
    app.add_html_math_renderer("mathml", inline_renderers=mathml("inline"), block_renderers=mathml("block"))
