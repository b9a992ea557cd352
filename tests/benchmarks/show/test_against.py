"""Points of one metric over another hold the numbers of the summary, those of one tracker joined in order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.show.against import against, points_of
from benchmarks.show.palette import line_styles
from benchmarks.show.plots import figure_of


def entry(tracker: str, metric: str, mean: float | None, low: float | None = None, high: float | None = None) -> Any:
    of = {"suite": "frame-out", "tracker": tracker, "metric": metric}
    return of | {"mean": mean, "ci_low": low, "ci_high": high}


ENTRIES = [
    entry("colour_pf[particles=1000]", "recovery_rate", 0.8, 0.7, 0.9),
    entry("colour_pf[particles=1000]", "ms_per_frame", 3.0, 2.5, 3.5),
    entry("colour_pf[particles=50]", "recovery_rate", 0.4, 0.3, 0.5),
    entry("colour_pf[particles=50]", "ms_per_frame", 4.0, 3.9, 4.1),
    entry("colour_pf[particles=200]", "recovery_rate", 0.6, 0.5, 0.7),
    entry("colour_pf[particles=200]", "ms_per_frame", 1.0, 0.9, 1.1),
    entry("colour_pf", "recovery_rate", 0.8, 0.7, 0.9),
    entry("colour_pf", "ms_per_frame", 3.0, 2.5, 3.5),
    entry("hold", "recovery_rate", 0.1),
    entry("hold", "ms_per_frame", 0.01),
    entry("untimed", "recovery_rate", 0.1),
    entry("undefined", "recovery_rate", None),
    entry("undefined", "ms_per_frame", 1.0),
]


def test_points_are_the_numbers_of_the_summary_in_the_order_of_the_values() -> None:
    points = points_of(ENTRIES, "recovery_rate", "ms_per_frame")
    assert set(points) == {"hold", "colour_pf", "colour_pf[particles]"}
    own = points["colour_pf[particles]"]
    assert own.texts == ["50", "200", "1000"]
    assert [tuple(each) for each in own.x] == [(4.0, 3.9, 4.1), (1.0, 0.9, 1.1), (3.0, 2.5, 3.5)]
    assert [tuple(each) for each in own.y] == [(0.4, 0.3, 0.5), (0.6, 0.5, 0.7), (0.8, 0.7, 0.9)]
    assert [tuple(each) for each in (*points["hold"].x, *points["hold"].y)] == [(0.01,) * 3, (0.1,) * 3]


def test_the_figure_has_a_line_a_tracker_with_bars_both_ways() -> None:
    points = points_of(ENTRIES, "recovery_rate", "ms_per_frame")
    chart = against(points, FRAME_OUT.metric("recovery_rate"), FRAME_OUT.metric("ms_per_frame"), "Cost")
    assert chart.x_label == "ms per frame, lower is better"
    styles = line_styles([("colour_pf[particles=1000]", "as-written"), ("hold", "baseline")])
    axes = figure_of(chart, styles).axes[0]
    lines = [np.asarray(line.get_xdata(), float).tolist() for line in axes.lines if line.get_linestyle() != "None"]
    assert [4.0, 1.0, 3.0] in lines
    bars = [path.get_segments() for path in axes.collections]
    assert any(np.allclose(some[0], [[3.9, 0.4], [4.1, 0.4]]) for some in bars if len(some))
    assert any(np.allclose(some[0], [[4.0, 0.3], [4.0, 0.5]]) for some in bars if len(some))
    assert {text.get_text() for text in axes.texts} >= {"50", "200", "1000"}


def test_values_of_one_tracker_share_a_colour_and_differ_in_dashes() -> None:
    names = [f"colour_pf[particles={count}]" for count in (20, 50, 200)]
    styles = line_styles([*((name, "as-written") for name in names), ("road_shape_pf", "as-written")])
    assert len({styles[name]["color"] for name in names}) == 1
    assert len({str(styles[name]["linestyle"]) for name in names}) == 3
    assert styles["colour_pf[particles]"] == styles[names[0]]
    assert styles["road_shape_pf"]["color"] != styles[names[0]]["color"]


@pytest.mark.parametrize(("metric", "scale"), [("recovery_rate", "share"), ("frames_per_s", "log"), ("nees", "linear")])
def test_axes_fit_their_units(metric: str, scale: str) -> None:
    chart = against({}, FRAME_OUT.metric(metric), FRAME_OUT.metric(metric), "t")
    assert (chart.x_scale, chart.y_scale) == (scale, scale)
