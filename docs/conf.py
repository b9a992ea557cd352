"""Settings of the site. `make docs` builds it; the sources are the Markdown files of the repository and of this folder.

Sphinx reads them where they are, so a text has one home, and a link in it leads to the same thing as in the repository:
to a page if the file is one, else to the file itself, which comes with the site. Nothing is fetched from elsewhere.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
from pathlib import Path

from sphinx.application import Sphinx

from benchmarks.gallery.page import gallery_page
from benchmarks.gallery.pictures import write_pictures
from benchmarks.run.cores import cores

_ROOT = Path(__file__).resolve().parents[1]
_GALLERY = "docs/gallery"

project = "Frameout"
copyright = "the Frameout authors. Licence: MIT"
release = importlib.metadata.version("frameout")
language = "en"

extensions = ["myst_nb"]
root_doc = "docs/index"
# Every Markdown file at the top is a page, but README.md, whose parts are in the pages of this folder.
include_patterns = ["*.md", "docs/*.md", "examples/*.ipynb"]
exclude_patterns = ["README.md", ".*", "build", "results", "tests", "benchmarks", "scenarios", "sim"]
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


def _add_gallery(app: Sphinx, page: str, content: list[str]) -> None:
    """Append the scenes to the gallery's page; pictures are kept beside the parsed pages."""
    if page == _GALLERY:
        pictures = Path(app.doctreedir).parent / "gallery"
        write_pictures(pictures, cores(None))
        content[0] += gallery_page(os.path.relpath(pictures, _ROOT / "docs"))


def setup(app: Sphinx) -> None:
    """Connect what the pages of this folder need."""
    app.connect("include-read", _lead_from_the_root)
    app.connect("source-read", _add_gallery)
    # It follows the catalogue, whose changes Sphinx does not see.
    app.connect("env-get-outdated", lambda *_: [_GALLERY])
