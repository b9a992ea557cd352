"""Page templates, loaded with the same settings."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined


def page_environment(module_file: str, *, autoescape: bool = True) -> Environment:
    """Return the environment of the templates beside a module, ``__file__``; a missing variable is an error."""
    return Environment(
        loader=FileSystemLoader(Path(module_file).parent),
        autoescape=autoescape,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
