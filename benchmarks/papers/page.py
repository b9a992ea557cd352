"""The page that a repeated experiment leaves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.report.page import page_style
from trackers.atomic_file import write_atomic

_FILE_NAME = "paper.html"


def write_page(out: Path, template: str, **values: Any) -> None:
    """Fill a template of this folder, with the style of our pages, write it to ``out/paper.html`` and say so."""
    environment = Environment(
        loader=PackageLoader("benchmarks", "papers"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    path = out / _FILE_NAME
    write_atomic(path, environment.get_template(template).render(style=Markup(page_style()), **values))
    print(f"page: {path}")
