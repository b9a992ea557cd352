"""Page templates, loaded with the same settings."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def page_environment(folder: str, *, autoescape: bool = True) -> Environment:
    """Return the environment of the templates in ``benchmarks/FOLDER``; a missing variable is an error."""
    return Environment(
        loader=PackageLoader("benchmarks", folder),
        autoescape=autoescape,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
