"""Colours of figures, and line styles of trackers: colour and dash by role, the same in every figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

INK, QUIET, GRID, GROUND = "#14171c", "#5b6370", "#dfe3e8", "#ffffff"
_OURS, _PLAIN, _OWN = "#c44a00", "#8a919c", "#5b2ecc"
_WRITTEN = ("#0064a8", "#00795a", "#a8487f")

Dashes = tuple[float, ...]
"""Matplotlib's on-off pattern in points, () = solid."""
_DASHES: tuple[Dashes, ...] = ((5, 2), (1.5, 1.5), (6, 1.5, 1.5, 1.5), (3, 1, 1, 1, 1, 1))
_LOOKS: dict[str, tuple[str, tuple[Dashes, ...], float]] = {
    "ours": (_OURS, ((),), 2.6),
    "external": (_OWN, ((), (7, 2), (7, 2, 2, 2)), 2.4),
    "variant": (_OURS, _DASHES, 1.2),
    "oracle": (INK, ((1.2, 1.6), (4, 1.6, 1.2, 1.6)), 2.2),
    "blind": (INK, ((8, 2), (8, 2, 1, 2), (8, 2, 1, 2, 1, 2), (8, 2, 3, 2)), 1.4),
    "baseline": (_PLAIN, _DASHES, 1.5),
}
"""Role → colour, dashes by place among those of the role, width."""


@dataclass(frozen=True, slots=True)
class LineStyle:
    """Look of one tracker's line: ``#rrggbb``, dashes, width in points."""

    colour: str
    dashes: Dashes
    width: float

    @property
    def in_front(self) -> bool:
        """Whether it is drawn over others: ours and users' own."""
        return self.width > 2.2

    @property
    def banded(self) -> bool:
        """Whether its band is drawn: of ours, users' own and references."""
        return self.in_front or self.colour == INK


def line_styles(trackers: Sequence[tuple[str, str]]) -> dict[str, LineStyle]:
    """Return a style for each of the (name, role); the same list gives the same styles.

    A user's own method (role ``external``) has a colour that no other role has. A tuned method has the colour of the
    same method as written, if that is in the list.
    """
    placed: dict[str, int] = {}
    places = {}
    for name, role in trackers:
        placed[role] = placed.get(role, -1) + 1
        places[name] = placed[role]
    return {name: _style(role, places.get(name.removesuffix("_tuned"), places[name])) for name, role in trackers}


def _style(role: str, place: int) -> LineStyle:
    if role in ("as-written", "policy", "tuned"):
        solid = role != "tuned" and place < len(_WRITTEN)
        dashes = () if solid else _DASHES[place % len(_DASHES)]
        return LineStyle(_WRITTEN[place % len(_WRITTEN)], dashes, 1.2 if role == "tuned" else 1.8)
    colour, dashes_by_place, width = _LOOKS.get(role, _LOOKS["baseline"])
    return LineStyle(colour, dashes_by_place[place % len(dashes_by_place)], width)
