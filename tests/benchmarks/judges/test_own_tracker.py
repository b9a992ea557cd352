"""A user's own tracker: compared with the others where none is ours, and drawn like no other."""

from __future__ import annotations

import pytest

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suite
from benchmarks.show.page import worth_showing
from benchmarks.show.palette import line_styles
from benchmarks.statistics.summary import compare_ours, grouped, summarise
from tests.benchmarks.fake_rows import rows_of


def _rows(roles: dict[str, str]) -> list[Row]:
    """Return rows of ``hold`` under several names and roles."""
    of_hold = [row for seed in (1, 2, 3) for row in rows_of("hold", seed)]
    return [{**row, "tracker": name, "role": role} for name, role in roles.items() for row in of_hold]


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("roles", "compared"),
    [
        ({"hold": "baseline", "mine": "external"}, {"mine"}),
        ({"hold": "baseline", "b": "external", "a": "external"}, {"a"}),
        ({"hold": "baseline", "mine": "external", "graph": "ours"}, {"graph"}),
        ({"hold": "baseline", "colour": "as-written"}, set()),
    ],
)
def test_own_takes_the_place_of_ours(roles: dict[str, str], compared: set[str]) -> None:
    entries = compare_ours(grouped(_rows(roles)))
    assert {entry["tracker"] for entry in entries} == compared
    assert all({e["other"] for e in entries if e["tracker"] == name} == set(roles) - {name} for name in compared)


def test_a_film_strip_shows_ours_own_and_the_best_as_written() -> None:
    roles = {"hold": "baseline", "mine": "external", "mine too": "external", "colour": "as-written", "graph": "ours"}
    groups = grouped(_rows(roles))
    (condition,) = groups
    assert worth_showing(suite(condition[0]), summarise(groups)) == ["graph", "mine", "mine too", "colour"]


def test_own_trackers_have_a_colour_of_their_own_and_different_lines() -> None:
    roles = ("ours", "variant", "as-written", "as-written", "tuned", "baseline", "policy", "oracle", "blind")
    others = [(f"other {k}", role) for k, role in enumerate(roles)]
    styles = line_styles([*others, ("mine", "external"), ("mine too", "external")])
    assert styles["mine"]["color"] not in {styles[name]["color"] for name, _ in others}
    assert styles["mine"]["zorder"] == max(style["zorder"] for style in styles.values())
    assert styles["mine"] != styles["mine too"] == styles["mine"] | {"linestyle": styles["mine too"]["linestyle"]}
