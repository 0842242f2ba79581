"""Sphinx: the documentation site; ``make docs`` builds it into build/docs/html, offline.

Sphinx with MyST and not MkDocs: autodoc resolves references into the API and makes a broken one an
error; sphinx-click reads the commands from click; myst-nb runs the tutorials while they are built.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import sys
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path.insert(0, str(HERE / "_ext"))
# so that `tt-precise` in a tutorial is the one of this environment
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

# the tutorials' kernels: a profile of their own, whatever the reader's is
PROFILE = ROOT / "build/docs/ipython/profile_default/startup"
PROFILE.mkdir(parents=True, exist_ok=True)
shutil.copy(HERE / "_ext/bash_magic.py", PROFILE / "bash_magic.py")
os.environ["IPYTHONDIR"] = str(PROFILE.parents[1])

from tt_precise import __version__  # noqa: E402

project = "tt_precise"
author = "The tt_precise developers"
copyright = f"2026, {author}"
release = version = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_click",
    "generated",
]
exclude_patterns = ["README.md", "_ext"]
nitpicky = True
# objects of other projects, whose inventories are not on this machine
nitpick_ignore_regex = [
    (
        r"py:.*",
        r"(click|collections|contextlib|flint|fractions|matplotlib|mpmath|numpy|pandas|pathlib)\..*",
    ),
    (
        r"py:.*",
        r"(Any|Array|Scalar|Callable|Fraction|Iterable|Mapping|Path|Sequence|optional|array_like)",
    ),
    # arithmetics of arrays, which no page describes
    (r"py:class", r"tt_precise\.(integration\.precision\.Hardware|runtime\.mpfr\.Mpfr)"),
]

html_theme = "furo"
html_title = f"tt_precise {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
templates_path: list[str] = []

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# MathJax comes from a package and is copied into the site: no formula needs a network.
_mathjax = importlib.util.find_spec("sphinx-mathjax-offline")
if _mathjax is None or _mathjax.origin is None:
    raise RuntimeError("sphinx-mathjax-offline is missing; expected the extra `docs` (make docs)")
html_static_path.append(str(Path(_mathjax.origin).parent / "static/mathjax/tex-svg-full.js"))
mathjax_path = "tex-svg-full.js"
mathjax3_config = {"svg": {"fontCache": "global"}}

autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False


def _package_hash() -> str:
    """Of everything a tutorial runs: an example is run again when the package changes."""
    found = hashlib.sha256()
    for path in sorted((ROOT / "tt_precise").rglob("*")):
        if path.suffix in (".py", ".toml", ".csv", ".j2"):
            found.update(path.read_bytes())
    for path in sorted((ROOT / "reference_data").rglob("manifest.json")):
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


nb_execution_mode = "cache"
nb_execution_cache_path = str(ROOT / "build/docs/executed" / _package_hash())
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 1500
nb_merge_streams = True


def setup(app: Sphinx) -> None:
    """Help texts are plain text: bars in them are absolute values, not substitutions."""

    def plain(app: Sphinx, context: object, lines: list[str]) -> None:
        # a bar at the beginning keeps a line as it stands
        heads = ["| " if line.startswith("| ") else "" for line in lines]
        rest = [line.removeprefix(head) for head, line in zip(heads, lines, strict=True)]
        lines[:] = [h + r.replace("|", r"\|") for h, r in zip(heads, rest, strict=True)]

    for part in ("description", "options", "epilog"):
        app.connect(f"sphinx-click-process-{part}", plain)
