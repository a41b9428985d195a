"""Sphinx configuration; the site is built offline and asks for nothing from the network."""

from importlib.resources import files
from pathlib import Path
from re import findall
from shutil import rmtree

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

import cca_core

project = "cca_core"
author = "cca_core contributors"
copyright = author
version = release = cca_core.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "numpydoc",
    "myst_nb",
]
exclude_patterns = ["_build"]

# MathJax is copied from the installed package that carries it, never loaded from a CDN.
mathjax = files("mathjax") / "static" / "mathjax"
mathjax_path = "tex-svg.js"

# Sphinx takes only what is beside it: the notebooks are copied, and link to the pages of the site.
notebooks = Path(__file__).parent / "generated" / "notebooks"
rmtree(notebooks, ignore_errors=True)
notebooks.mkdir(parents=True)
for notebook in (Path(__file__).parents[1] / "examples" / "notebooks").glob("*.ipynb"):
    text = notebook.read_text(encoding="utf-8").replace("](../../docs/", "](../../")
    (notebooks / notebook.name).write_text(text, encoding="utf-8")

html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = [str(mathjax / "es5" / "tex-svg.js"), str(mathjax / "LICENSE")]
html_copy_source = False

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "auto"
nb_execution_raise_on_error = True
nb_execution_timeout = 180
nb_ipywidgets_js: dict[str, dict[str, str]] = {}

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc says it, with shape and unit
numpydoc_show_class_members = False


def check_offline(app: Sphinx, failure: Exception | None) -> None:
    """Refuse a site of which any page loads anything from the network."""
    for page in [] if failure else sorted(Path(app.outdir).rglob("*.html")):
        text = page.read_text(encoding="utf-8")
        tags = findall(
            r"<(?:script|link|img|iframe|source)\b[^>]*?(?:src|href)=\"((?:https?:)?//[^\"]*)", text
        )
        if tags:
            raise ExtensionError(f"{page.name} loads {', '.join(sorted(set(tags)))}")


def setup(app: Sphinx) -> None:
    """Look at the pages when they are written."""
    app.connect("build-finished", check_offline)
