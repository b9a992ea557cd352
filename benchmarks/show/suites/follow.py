"""How the suite ``follow`` is shown."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from benchmarks.contract.rows import Row
from benchmarks.judges.view_time import TIME_SEEN
from benchmarks.show.charts import Chart
from benchmarks.show.showing import Showing
from benchmarks.statistics.bootstrap import Interval, intervals_of


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return the time seen: a line for each tracker, a dot for each controller that steers by it."""
    lines: dict[str, dict[str, Interval]] = defaultdict(dict)
    for pair, share in intervals_of(TIME_SEEN.statistic, drawn).items():
        lines[drawn[pair][0]["tracker"]][drawn[pair][0]["controller"]] = share
    return [
        Chart(
            title="How long is the target seen?",
            words="Seen: the target's centre is in the picture, large enough for its scene (at least 12 pixels long), "
            "and at least half of it visible. A line for each tracker, a dot for each controller that steers by it.",
            lines=lines,
            x_label="time seen",
            x_scale="share",
        )
    ]


SHOWING = Showing(
    heading="Is it kept in view?",
    charts=charts,
    oracles="An oracle's controller steers by the true position: what it misses is due to carrier, gusts, controller.",
)
