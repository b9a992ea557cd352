"""A plot of the report as a picture of its own, with title and legend, e.g. in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

from benchmarks.show.palette import LineStyle, light_colours

_WIDTH_PX, _PLOT_HEIGHT_PX = 560, 384
_TITLE_PX, _ENTRY_HEIGHT_PX, _ENTRY_WIDTH_PX, _STROKE_PX = 30, 18, 184, 26
_ENTRIES_A_LINE = _WIDTH_PX // _ENTRY_WIDTH_PX
_FONT = "font-family:sans-serif;fill:var(--ink)"


@dataclass(frozen=True, slots=True)
class ReportFigure:
    """A plot of the report; a notebook shows it.

    Attributes:
        title, words: of the report.
        plot_svg: as ``plots.svg`` returns it. legend: name and style of each line.
    """

    title: str
    words: str
    plot_svg: str = field(repr=False)
    legend: Sequence[tuple[str, LineStyle]] = field(repr=False)

    def svg(self) -> str:
        """Return the picture, in the page's colours on a light ground."""
        lines = -(-len(self.legend) // _ENTRIES_A_LINE)
        top = _TITLE_PX + lines * _ENTRY_HEIGHT_PX
        colours = ";".join(f"--{name}:{colour}" for name, colour in light_colours().items())
        place = f'y="{top}" width="{_WIDTH_PX}" height="{_PLOT_HEIGHT_PX}"'
        parts = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH_PX}" height="{top + _PLOT_HEIGHT_PX}"'
            f' style="{colours};background:var(--ground)">',
            f'<text x="8" y="20" style="{_FONT};font-size:15px;font-weight:600">{escape(self.title)}</text>',
            *(_entry(place, name, style) for place, (name, style) in enumerate(self.legend)),
            self.plot_svg.replace("<svg", f"<svg {place}", 1),
            "</svg>",
        )
        return "\n".join(parts)

    def _repr_svg_(self) -> str:
        return self.svg()


def _entry(place: int, name: str, style: LineStyle) -> str:
    line, column = divmod(place, _ENTRIES_A_LINE)
    x, y = 8 + column * _ENTRY_WIDTH_PX, _TITLE_PX + 8 + line * _ENTRY_HEIGHT_PX
    look = f"stroke:var(--{style.variable});stroke-width:{style.width};stroke-dasharray:{_dashes(style)}"
    return (
        f'<line x1="{x}" y1="{y}" x2="{x + _STROKE_PX}" y2="{y}" style="{look}"/>'
        f'<text x="{x + _STROKE_PX + 6}" y="{y + 4}" style="{_FONT};font-size:12px">{escape(name)}</text>'
    )


def _dashes(style: LineStyle) -> str:
    return " ".join(map(str, style.dashes)) or "none"
