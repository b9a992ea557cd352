"""Line styles of trackers: colour and dash by role, the same in every plot, in light and dark.

Plots are drawn with placeholder colours, ``#0a0bNN``; the page's style sheet defines them for light and dark.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

INK = "#0a0b01"
QUIET = "#0a0b02"
GRID = "#0a0b03"
GROUND = "#0a0b04"
BETTER = "#0a0b05"
WORSE = "#0a0b06"

PLACEHOLDERS = {INK: "ink", QUIET: "quiet", GRID: "rule", GROUND: "ground", BETTER: "better", WORSE: "worse"}
"""Placeholder colour → name of the style sheet's variable."""


@dataclass(frozen=True, slots=True)
class LineStyle:
    """Look of one tracker's line.

    Attributes:
        colour: placeholder. variable: its name in the style sheet.
        dashes: matplotlib's on-off pattern in points, () = solid.
        width: points.
        in_front: drawn over others.
    """

    colour: str
    variable: str
    dashes: tuple[float, ...]
    width: float
    in_front: bool = False


_DASHES: tuple[tuple[float, ...], ...] = ((5, 2), (1.5, 1.5), (6, 1.5, 1.5, 1.5), (3, 1, 1, 1, 1, 1))
_OWN_DASHES: tuple[tuple[float, ...], ...] = ((), (7, 2), (7, 2, 2, 2))
_ORACLE_DASHES: tuple[tuple[float, ...], ...] = ((1.2, 1.6), (4, 1.6, 1.2, 1.6))
_BLIND_DASHES: tuple[tuple[float, ...], ...] = ((8, 2), (8, 2, 1, 2), (8, 2, 1, 2, 1, 2), (8, 2, 3, 2))
_WRITTEN = ("written-1", "written-2", "written-3")
_VARIABLES = ("ours", *_WRITTEN, "plain", "ink", "own")
_COLOURS = {variable: f"#0a0b{16 + place:02x}" for place, variable in enumerate(_VARIABLES)}
PLACEHOLDERS |= {colour: variable for variable, colour in _COLOURS.items()}


def line_styles(trackers: Sequence[tuple[str, str]]) -> dict[str, LineStyle]:
    """Return a style for each of the (name, role); the same list gives the same styles.

    A user's own method (role ``external``) has a colour that no other role has.

    A tuned method has the colour of the same method as written, if that is in the list.
    """
    placed: dict[str, int] = {}
    places = {}
    for name, role in trackers:
        placed[role] = placed.get(role, -1) + 1
        places[name] = placed[role]
    return {name: _style(role, places.get(name.removesuffix("_tuned"), places[name])) for name, role in trackers}


def _style(role: str, place: int) -> LineStyle:
    dashes = _DASHES[place % len(_DASHES)]
    if role == "ours":
        return _line("ours", (), 2.6, in_front=True)
    if role == "external":
        return _line("own", _OWN_DASHES[place % len(_OWN_DASHES)], 2.4, in_front=True)
    if role == "variant":
        return _line("ours", dashes, 1.2)
    if role == "tuned":
        return _line(_WRITTEN[place % len(_WRITTEN)], dashes, 1.2)
    if role in ("as-written", "policy"):
        return _line(_WRITTEN[place % len(_WRITTEN)], () if place < len(_WRITTEN) else dashes, 1.8)
    if role == "oracle":
        return _line("ink", _ORACLE_DASHES[place % len(_ORACLE_DASHES)], 2.2)
    if role == "blind":
        return _line("ink", _BLIND_DASHES[place % len(_BLIND_DASHES)], 1.4)
    return _line("plain", dashes, 1.5)


def _line(variable: str, dashes: tuple[float, ...], width: float, *, in_front: bool = False) -> LineStyle:
    return LineStyle(_COLOURS[variable], variable, dashes, width, in_front)


@cache
def light_colours() -> dict[str, str]:
    """Return the colour ``#rrggbb`` of each variable of the page's style sheet on a light ground."""
    sheet = Path(__file__).with_name("page.css").read_text()
    light = sheet[sheet.index(":root {") : sheet.index("}")]
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", light))


def on_light(colour: str) -> str:
    """Return a placeholder's colour on a light ground; other values as they are."""
    return light_colours().get(PLACEHOLDERS.get(colour, ""), colour)
