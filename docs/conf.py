"""Sphinx configuration; the site is built offline and asks for nothing from the network."""

from importlib import import_module
from importlib.resources import files
from pathlib import Path
from pkgutil import iter_modules, walk_packages
from re import findall
from shutil import rmtree
from types import ModuleType

from numpydoc.xref import DEFAULT_LINKS
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.pycode import ModuleAnalyzer

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

# Sphinx takes only what is next to it: the notebooks are copied, and link to the pages of the site.
notebooks = Path(__file__).parent / "generated" / "notebooks"
rmtree(notebooks, ignore_errors=True)
notebooks.mkdir(parents=True)
for source in (Path(__file__).parents[1] / "examples" / "notebooks").iterdir():
    if source.suffix in {".ipynb", ".gpx"}:
        text = source.read_text(encoding="utf-8").replace("](../../docs/", "](../../")
        (notebooks / source.name).write_text(text, encoding="utf-8")

html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = [str(mathjax / "es5" / "tex-svg.js"), str(mathjax / "LICENSE")]
html_copy_source = False

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "auto"
nb_execution_raise_on_error = True
nb_execution_timeout = 180
nb_merge_streams = True
nb_ipywidgets_js: dict[str, dict[str, str]] = {}

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc says it, with shape and unit
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"


def check_offline(app: Sphinx, failure: Exception | None) -> None:
    """Refuse a site of which any page loads anything from the network."""
    for page in [] if failure else sorted(Path(app.outdir).rglob("*.html")):
        text = page.read_text(encoding="utf-8")
        tags = findall(
            r"<(?:script|link|img|iframe|source)\b[^>]*?(?:src|href)=\"((?:https?:)?//[^\"]*)", text
        )
        if tags:
            raise ExtensionError(f"{page.name} loads {', '.join(sorted(set(tags)))}")


public = {
    package: getattr(package, "__all__", [])
    for package in (import_module(f"cca_core.{m.name}") for m in iter_modules(cca_core.__path__) if m.ispkg)
}

# Types of arguments and results link to their class; those of Python and NumPy have no page here.
numpydoc_xref_aliases = {word: word for word in DEFAULT_LINKS} | {
    name: f"{module.__name__}.{name}"
    for module in (import_module(f"cca_core.{m.name}") for m in iter_modules(cca_core.__path__))
    for name in getattr(module, "__all__", [])
    if isinstance(getattr(module, name), type)
}


def document_constants(package: ModuleType) -> None:
    """Give a package the texts of the constants that it lists: autodoc looks for them there alone."""
    face = ModuleAnalyzer.for_module(package.__name__)
    face.analyze()
    for module in walk_packages(package.__path__, f"{package.__name__}."):
        if module.name == "cca_core.kernel._compiled":  # C has no docstrings
            continue
        for (scope, name), text in ModuleAnalyzer.for_module(module.name).find_attr_docs().items():
            if not scope and name in public[package]:
                face.attr_docs[scope, name] = text


def check_names(app: Sphinx, failure: Exception | None) -> None:
    """Refuse a reference that lacks a public name."""
    if failure:
        return
    text = "".join(page.read_text(encoding="utf-8") for page in Path(app.outdir, "api").glob("*.html"))
    names = [f"{package.__name__}.{name}" for package in public for name in public[package]]
    if missing := [name for name in names if f'id="{name}"' not in text]:
        raise ExtensionError(f"the reference lacks {', '.join(missing)}")


def setup(app: Sphinx) -> None:
    """Prepare the reference, and look at the pages when they are written."""
    for package in public:
        document_constants(package)
    app.connect("build-finished", check_offline)
    app.connect("build-finished", check_names)
