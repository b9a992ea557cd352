"""One episode frame by frame: a strip of coloured frames for each tracker, with visibility and changes of light."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.judges.runs import runs
from benchmarks.judges.stereo.metrics.people import Outcome
from benchmarks.show.palette import BETTER, GRID, INK, QUIET, WORSE
from benchmarks.show.plots import count_frames, drawn_as, new_figure, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOOKS: dict[str, tuple[str, tuple[Outcome, ...]]] = {
    "right": (BETTER, (Outcome.RIGHT,)),
    "another person": (INK, (Outcome.WRONG_PERSON, Outcome.UNCOUNTED_WRONG_PERSON)),
    "wrong place": (WORSE, (Outcome.WRONG,)),
    "missed": (GRID, (Outcome.MISSED,)),
}
"""Words → colour and the outcomes drawn in it."""
_HEIGHT = 0.7


@dataclass(frozen=True, eq=False)
class Strip:
    """One tracker's rows of each frame of one episode.

    Attributes:
        outcome: (F,) int, see ``Outcome``. visible_fraction: (F,) of the target.
        lights: (frame, kind) of each change of light.
    """

    outcome: NDArray[np.int64]
    visible_fraction: NDArray[np.float64]
    lights: tuple[tuple[int, str], ...]


def strip_of(rows: Sequence[Row]) -> Strip:
    """Return the strip of one tracker in one episode."""
    series = {row["metric"]: row["value"] for row in rows if row["metric"].endswith("_by_frame")}
    events = [event for row in rows if (event := row["event"]) is not None and event["light"]]
    return Strip(
        outcome=np.array(series["outcome_by_frame"], dtype=np.int64),
        visible_fraction=np.array(series["visible_fraction_by_frame"], dtype=float),
        lights=tuple(sorted({(event["first_frame"], event["kind"]) for event in events})),
    )


def plot_strips(strips: Mapping[str, Strip]) -> str:
    """Draw the strips below each other, above them the target's visible share and the changes of light."""
    from matplotlib.patches import Patch

    with drawn_as("strips"):
        figure, axes = new_figure("frame", "")
        first = next(iter(strips.values()))
        places = np.arange(len(strips))[::-1]
        for place, strip in zip(places, strips.values(), strict=True):
            _draw(axes, strip, float(place))
        top = float(len(strips))
        frames = np.arange(len(first.visible_fraction))
        seen = top - 0.5 * _HEIGHT + _HEIGHT * np.clip(first.visible_fraction, 0, 1)
        axes.fill_between(frames, top - 0.5 * _HEIGHT, seen, color=QUIET, alpha=0.5, linewidth=0)
        for frame, kind in first.lights:
            axes.axvline(frame, color=INK, linewidth=0.8, dashes=(2, 2), zorder=4)
            axes.annotate(kind, (frame, top + 0.5), rotation=35, fontsize=8, color=QUIET, annotation_clip=False)
        axes.set_yticks([*places, top], [*strips, "seen"])
        axes.set_ylim(-0.5, top + 0.5)
        count_frames(axes, len(frames))
        axes.grid(False)
        patches = [Patch(color=colour, label=words) for words, (colour, _) in _LOOKS.items()]
        figure.legend(handles=patches, loc="outside lower center", ncols=len(patches), frameon=False, fontsize=8)
        return svg(figure)


def _draw(axes: Axes, strip: Strip, place: float) -> None:
    for colour, outcomes in _LOOKS.values():
        spans = [(first, end - first) for first, end in runs(np.isin(strip.outcome, outcomes))]
        axes.broken_barh(spans, (place - 0.5 * _HEIGHT, _HEIGHT), color=colour, linewidth=0)
