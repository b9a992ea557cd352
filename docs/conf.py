"""Settings of the site. `make docs` builds it; the sources are the Markdown files of the repository and of this folder.

Sphinx reads them where they are, so a text has one home, and a link in it leads to the same thing as in the repository:
to a page if the file is one, else to the file itself, which comes with the site. Nothing is fetched from elsewhere.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
from collections.abc import Callable
from pathlib import Path

from sphinx.application import Sphinx

from benchmarks.run.workers import cores
from benchmarks.show.reference import envs_page, reference_page
from tools.gallery.page import gallery_page, write_pictures

_ROOT = Path(__file__).resolve().parents[1]

project = "Frameout"
copyright = "the Frameout authors. Licence: MIT"
release = importlib.metadata.version("frameout")
language = "en"

extensions = ["myst_nb"]
root_doc = "docs/index"
# Every Markdown file at the top is a page, but README.md, whose parts are in the pages of this folder; so is the card
# of every policy.
include_patterns = ["*.md", "docs/*.md", "docs/results/*.md", "examples/*.ipynb", "trackers/policies/*.md"]
exclude_patterns = [
    "README.md",
    "**/*.template.md",
    ".*",
    "build",
    "results",
    "tests",
    "benchmarks",
    "scenarios",
    "sim",
]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
nb_execution_mode = "off"

html_theme = "furo"
html_title = "Frameout"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["redirect"]
html_copy_source = False
html_use_index = False


def _lead_from_the_root(app: Sphinx, path: Path, page: str, content: list[str]) -> None:
    """Make links of an included text, which are relative to its own folder, lead from the root of the repository."""
    content[0] = re.sub(
        r"\]\(([\w./-]+)", lambda link: f"](/{link[1]}" if (_ROOT / link[1]).exists() else link[0], content[0]
    )


def _with_scenes(app: Sphinx, text: str) -> str:
    """Return the gallery's page with the scenes at its end; pictures are kept beside the parsed pages."""
    pictures = Path(app.doctreedir).parent / "gallery"
    write_pictures(pictures, cores(None))
    return text + gallery_page(os.path.relpath(pictures, _ROOT / "docs"))


_MADE: dict[str, Callable[[Sphinx, str], str]] = {
    "docs/gallery": _with_scenes,
    "docs/reference": lambda *_: reference_page(),
    "docs/envs": lambda *_: envs_page(),
}
"""Pages that are made from the code, in the place of their file's text or behind it."""


def _make(app: Sphinx, page: str, content: list[str]) -> None:
    if page in _MADE:
        content[0] = _MADE[page](app, content[0])


def setup(app: Sphinx) -> None:
    """Connect what the pages of this folder need."""
    app.connect("include-read", _lead_from_the_root)
    app.connect("source-read", _make)
    # They follow the code, whose changes Sphinx does not see.
    app.connect("env-get-outdated", lambda *_: [*_MADE])
