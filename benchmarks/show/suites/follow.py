"""How the suite ``follow`` is shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from benchmarks.contract.rows import Row
from benchmarks.judges.view_time import TIME_SEEN
from benchmarks.show.charts import Chart, DotChart
from benchmarks.show.showing import Showing
from benchmarks.statistics.bootstrap import Interval, interval_of


def charts(drawn: Mapping[str, Sequence[Row]]) -> Iterator[Chart]:
    """Yield the time seen: a line for each controller, a dot for each tracker."""
    lines: dict[str, dict[str, Interval]] = {}
    roles: dict[str, str] = {}
    for rows in drawn.values():
        share = interval_of(TIME_SEEN.statistic, rows)
        if share is not None:
            lines.setdefault(rows[0]["controller"], {})[rows[0]["tracker"]] = share
            roles[rows[0]["tracker"]] = rows[0]["tracker_role"]
    if lines:
        yield DotChart(
            title="How long is the target seen?",
            words="Seen: the target's centre is in the picture, its box at least 12 pixels long, and at least half of "
            "it visible. A line for each controller, a dot for each tracker that it steers by, over all episodes; "
            "bars: 95 % bootstrap over seeds.",
            lines=lines,
            x_label="time seen",
            roles=roles,
        )


SHOWING = Showing(
    heading="Is it kept in view?",
    charts=charts,
    oracles="An oracle's controller steers by the true position: what it misses is due to carrier, gusts, controller.",
)
