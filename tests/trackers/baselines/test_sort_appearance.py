"""SORT with looks against small cases in which looks alone tell who is who."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.fish_chain.swum import seen
from trackers.baselines.sort import Sort, SortParameters
from trackers.baselines.sort_appearance import SortAppearance, SortAppearanceParameters, Spread
from trackers.fish_chain.detection import Detection

RNG = np.random.default_rng(0)
DARK, PALE = 0.3, 0.6


def met(tracker: Sort, shades: tuple[float, float]) -> dict[str, list[int]]:
    """Let two fish swim towards each other, hide in one blob for five frames, and turn back; return their names.

    ``shades``: of the fish from the left and of that from the right.
    """
    names: dict[str, list[int]] = {"left": [], "right": []}
    noise = np.random.default_rng(1)
    for k in range(60):
        away = max(60.0 - 2.5 * k, 0.0) if k < 30 else 2.5 * (k - 30)
        if 25 <= k < 30:
            tracker.follow([seen((100.0, 100.0), 0.0, merged=True)])
            continue
        places = {"left": 100.0 - away, "right": 100.0 + away + 1.0}
        found = [
            seen((x, 100.0), 0.0, shade=shade + 0.01 * noise.normal())
            for x, shade in zip(places.values(), shades, strict=True)
        ]
        answers = tracker.follow(found)
        for side, x in places.items():
            names[side] += [each.identity for each in answers if abs(each.estimate.position_px[0] - x) < 0.4]
    return names


def test_two_that_meet_and_turn_back_keep_their_names_by_their_looks_where_sort_swaps_them() -> None:
    swapped = met(Sort(SortParameters(), RNG), (DARK, PALE))
    assert (swapped["left"][0], swapped["right"][0]) == (swapped["right"][-1], swapped["left"][-1])
    kept = met(SortAppearance(SortAppearanceParameters(), RNG), (DARK, PALE))
    assert (kept["left"][0], kept["right"][0]) == (kept["left"][-1], kept["right"][-1])
    assert kept["left"][0] != kept["right"][0]


def test_of_fish_that_look_alike_it_knows_no_more_than_sort() -> None:
    alike = met(SortAppearance(SortAppearanceParameters(), RNG), (DARK, DARK))
    assert (alike["left"][0], alike["right"][0]) != (alike["left"][-1], alike["right"][-1])


def turned_round(detection: Detection) -> Detection:
    return replace(detection, widths_px=detection.widths_px[::-1], shades=detection.shades[::-1])


def test_which_end_is_taken_for_the_head_does_not_matter() -> None:
    tracker, names = SortAppearance(SortAppearanceParameters(least_overlap=0.5), RNG), []
    for k in range(30):
        fish = [seen((50.0 + 2 * k, y), 0.0, shade=shade) for y, shade in ((50.0, DARK), (90.0, PALE))]
        found = [turned_round(each) if k % 2 else each for each in fish]
        names.append([each.identity for each in tracker.follow(found)])
    assert names == [names[0]] * 30


@pytest.mark.parametrize(("lost_frames", "kept"), [(10, True), (30, False)])
def test_a_lost_fish_is_known_by_its_look_until_its_age(lost_frames: int, kept: bool) -> None:
    tracker = SortAppearance(SortAppearanceParameters(max_age=20), RNG)
    still = [seen((50.0, 50.0), 0.0, shade=DARK), seen((200.0, 50.0), 0.0, shade=PALE)]
    name = [tracker.follow(still) for _ in range(10)][-1][0].identity
    for _ in range(lost_frames):
        tracker.follow(still[1:])
    # Its box overlaps with nothing that is expected.
    moved = seen((50.0, 75.0), 0.0, shade=DARK)
    assert (name in [each.identity for each in tracker.follow([moved, still[1]])]) == kept


def test_the_spread_of_a_look_goes_from_that_of_all_fish_to_that_of_one() -> None:
    spread, rng = Spread(), np.random.default_rng(0)
    looks = rng.normal(0.0, 1.0, (100, 3))
    spread.see(looks)
    np.testing.assert_allclose(spread.variance(), looks.var(axis=0), rtol=1e-3)
    for _ in range(5000):
        spread.learn(0.1 * rng.normal(size=3))
    np.testing.assert_allclose(spread.variance(), 0.02, rtol=0.3)
