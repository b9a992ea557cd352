"""The closed loop can be won by who flies well, and failed by who does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.road_town.plan import STARTS_BEFORE_TURN_M, Plan, make_plan
from scenarios.road_town.presets import OUT_FROM_SHARE, PRESETS, RoadTown
from scenarios.road_town.swing_geometry import smooth_step
from tests.scenarios.road_town.steered import AtRandom, shares_in_view
from trackers.controllers.catalogue import controller_entry
from trackers.protocols import Controller


def _plans(preset: RoadTown, count: int) -> list[Plan]:
    return [make_plan(preset, seed, closed_loop=True) for seed in range(count)]


def _mean(plans: list[Plan], controller: str) -> float:
    def create(number: int) -> Controller:
        return controller_entry(controller, "helicopter").create()

    return float(shares_in_view(plans, create).mean())


@pytest.mark.heavy
def test_quick_random_commands_lose_the_car_more_than_rest_and_rest_more_than_centring() -> None:
    plans = _plans(PRESETS["quick"], 16)
    randoms = [shares_in_view(plans, lambda number, draw=draw: AtRandom(100 * draw + number)) for draw in range(3)]
    rest = _mean(plans, "hold")
    assert np.mean(randoms) < rest - 0.04
    assert rest < _mean(plans, "centre") - 0.15


@pytest.mark.heavy
def test_quick_the_car_drives_on_and_is_swung_out_of_view_while_it_turns() -> None:
    ways_m, over_turns = [], []
    for plan in _plans(PRESETS["quick"], 12):
        arc_m, (gust,) = plan.motion.arc_m[:, 0], plan.pulses
        ways_m.append(arc_m[-1] - arc_m[0])
        out = gust.share(plan.preset.frame_count) > smooth_step(np.array([OUT_FROM_SHARE]))
        over_turns.append(any(plan.turning(frame) for frame in np.flatnonzero(out)))
    assert np.median(ways_m) > 40.0
    assert np.mean(over_turns) > 0.7


@pytest.mark.heavy
def test_standard_gusts_that_build_up_are_flown_against_and_sudden_ones_are_not() -> None:
    standard = PRESETS["standard"]
    sudden = replace(standard, frame_outs=replace(standard.frame_outs, build_up_s=None))
    plans = _plans(standard, 5)
    leant = _mean(plans, "reentry")
    assert _mean(plans, "hold") < 0.4
    assert 0.4 < _mean(plans, "centre_as_written") < leant - 0.1
    assert _mean(_plans(sudden, 5), "reentry") < leant - 0.02
    assert leant < 0.99, "frame-outs remain to recover from"


@pytest.mark.heavy
def test_oblique_a_helicopter_that_centres_does_not_fly_over_the_car() -> None:
    plans = _plans(PRESETS["oblique"], 4)
    centred = _mean(plans, "centre")
    assert centred > 0.75
    assert _mean(plans, "hold") < centred - 0.2


def test_the_car_starts_at_a_turn_in_closed_loop_alone() -> None:
    preset = PRESETS["quick"]
    for closed_loop in (True, False):
        plan = make_plan(preset, 7, closed_loop=closed_loop)
        to_turns_m = [each.enter_m - plan.motion.arc_m[0, 0] for each in plan.routes[0].passages if each.is_turn]
        starts_there = bool(np.isclose(to_turns_m, STARTS_BEFORE_TURN_M).any())
        assert starts_there == (plan.motion.speed_mps[0, 0] == 0.0) == closed_loop
