"""What docstrings say: in Markdown, of each attribute, and where they stand."""

from __future__ import annotations

import dataclasses
import inspect
import re
from pathlib import Path
from typing import Any

_ROOT = Path(__file__).resolve().parents[2]
_SECTION = re.compile(r"^(Args|Attributes|Raises|Returns|Yields):$", re.MULTILINE)


def words_of(thing: Any) -> str:
    """Return a docstring without its indentation, code in Markdown's marks."""
    return (inspect.getdoc(thing) or "").replace("``", "`")


def place_of(thing: Any) -> str:
    """Return the place of a definition, as ``benchmarks/judges/stereo/metrics/people.py: on_other``."""
    code = getattr(thing, "fget", thing)
    file = Path(inspect.getfile(code)).resolve()
    path = file.relative_to(_ROOT).as_posix() if file.is_relative_to(_ROOT) else file.name
    return path if inspect.ismodule(code) else f"{path}: {code.__qualname__}"


def attribute_meanings(kind: Any) -> dict[str, str]:
    """Return field -> its text in the docstrings of a dataclass or named tuple and its bases; "" for one without.

    Several may share a line, ``first: text. second: text.``, and a text, ``low, high: ends``, which then begins with
    their names.
    """
    names = [field.name for field in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else list(kind._fields)
    meanings = dict.fromkeys(names, "")
    for each in reversed(kind.__mro__[:-1]):
        meanings |= _in_docstring(each, names)
    return meanings


def _in_docstring(kind: type, names: list[str]) -> dict[str, str]:
    _, _, section = (kind.__doc__ or "").partition("Attributes:")
    text = " ".join(_SECTION.split(inspect.cleandoc(section), maxsplit=1)[0].split()).replace("``", "`")
    name = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    heads = list(re.finditer(rf"(?:^|(?<=[.;,)] ))((?:{name})(?:, (?:{name}))*): ", text))
    ends = [*(head.start() for head in heads[1:]), len(text)]
    meanings: dict[str, str] = {}
    for head, end in zip(heads, ends, strict=False):
        mine, words = head[1].split(", "), text[head.end() : end].strip(" ;,").removesuffix(".")
        shared = f"{', '.join(f'`{name}`' for name in mine)}: " if len(mine) > 1 else ""
        meanings |= dict.fromkeys(mine, f"{shared}{words}")
    return meanings
