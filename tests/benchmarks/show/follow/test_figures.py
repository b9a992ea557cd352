"""The figures of the suite ``follow``: where marks stand, and whose they are."""

from __future__ import annotations

import re

from benchmarks.show.follow.figures import figures, marks, plot_shares

from benchmarks.show.palette import line_styles


def test_variants_alone_have_no_figures() -> None:
    assert figures({}, {}) == []


def test_marks_stand_where_their_shares_are() -> None:
    styles = line_styles([("reentry", "ours"), ("policy:a", "policy"), ("hold", "baseline")])
    shares = {"one": {"reentry": (0.9, 0.8, 0.95), "hold": (0.2, 0.1, 0.3)}, "two": {"policy:a": (0.5, 0.4, 0.6)}}
    svg = plot_shares(shares, marks({"one": "ours", "two": "as-written"}), styles, "time in view")
    places = {
        colour: [float(x) for x in re.findall(rf'<use [^>]*x="([\d.]+)"[^>]*fill: var\(--{colour}\)', svg)]
        for colour in ("ours", "plain", "ground")
    }
    # The first tracker's marks are full, those of others hollow.
    assert [len(places[colour]) for colour in ("ours", "plain")] == [1, 1]
    assert places["plain"][0] < places["ground"][0] < places["ours"][0]
    ticks = [svg.index(f">{name}<") for name in ("reentry", "policy:a", "hold")]
    assert len(set(ticks)) == 3
    assert ">by two<" in svg
    # A user's own tracker: a mark in the plot and one in the legend, in a colour that no controller has.
    own = plot_shares(shares, marks({"one": "ours", "two": "external"}), styles, "time in view")
    assert [picture.count("fill: var(--own)") for picture in (svg, own)] == [0, 2]
