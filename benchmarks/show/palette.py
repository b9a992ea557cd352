"""Colours of figures, and how lines of trackers look: colour and dash by role, the same in every figure."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.contract.varied import base_of, varied

INK, QUIET, GRID, GROUND = "#14171c", "#5b6370", "#dfe3e8", "#ffffff"
_OURS, _PLAIN, _OWN = ["#c44a00"], ["#8a919c"], ["#5b2ecc"]
_WRITTEN = ["#0064a8", "#00795a", "#a8487f"]
_DASHES: list[Any] = [(0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (3, 1, 1, 1, 1, 1))]
BANDED = 3.0
"""Order from which on a line has a band: of ours, users' own and references."""
_LOOKS: dict[str, tuple[list[str], list[Any], float, float]] = {
    "ours": (_OURS, ["-"], 2.6, 4.0),
    "external": (_OWN, ["-", (0, (7, 2)), (0, (7, 2, 2, 2))], 2.4, 4.0),
    "variant": (_OURS, _DASHES, 1.2, 2.5),
    "as-written": (_WRITTEN, ["-"] * 3 + _DASHES, 1.8, 2.5),
    "policy": (_WRITTEN, ["-"] * 3 + _DASHES, 1.8, 2.5),
    "tuned": (_WRITTEN, _DASHES, 1.2, 2.5),
    "oracle": ([INK], [(0, (1.2, 1.6)), (0, (4, 1.6, 1.2, 1.6))], 2.2, BANDED),
    "blind": ([INK], [(0, (8, 2)), (0, (8, 2, 1, 2)), (0, (8, 2, 1, 2, 1, 2)), (0, (8, 2, 3, 2))], 1.4, BANDED),
    "baseline": (_PLAIN, _DASHES, 1.5, 2.5),
}
"""Role → colours and dashes, by place among those of the role; width; order, the largest in front."""

LineStyles = dict[str, dict[str, Any]]
"""Name → keywords of matplotlib's lines."""


def line_styles(trackers: Sequence[tuple[str, str]]) -> LineStyles:
    """Return a style for each of the (name, role); the same list gives the same styles.

    A user's own method (role ``external``) has a colour that no other role has. A tuned method has the colour of the
    same method as written, if that is in the list. One with several values of a parameter has one colour, and their
    curve (``contract.varied``) the style of the first of them.
    """
    bases = {base_of(name): role for name, role in reversed(trackers)}
    counts: dict[str, Iterator[int]] = defaultdict(itertools.count)
    places = {name: next(counts[bases[name]]) for name in dict.fromkeys(base_of(name) for name, _ in trackers)}
    values: dict[str, Iterator[int]] = defaultdict(itertools.count)
    styles: LineStyles = {}
    for name, role in trackers:
        base = base_of(name)
        place = places.get(base.removesuffix("_tuned"), places[base])
        colours, dashes, width, order = _LOOKS.get(role, _LOOKS["baseline"])
        colour, dash = colours[place % len(colours)], dashes[place % len(dashes)]
        if (other := next(values[base])) > 0:
            dash = _DASHES[(other - 1) % len(_DASHES)]
        styles[name] = {"color": colour, "linestyle": dash, "linewidth": width, "zorder": order}
        if (found := varied(name)) is not None:
            styles.setdefault(found.curve, styles[name])
    return styles
