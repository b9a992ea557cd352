"""The closed loop of edition 2 can be won by who flies well, and failed by who does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenarios.road_town.plan import Plan, make_plan
from scenarios.road_town.presets import PRESETS, RoadTown
from tests.scenarios.road_town.steered import AtRandom, shares_in_view
from trackers.controllers.catalogue import controller_entry
from trackers.protocols import Controller


def _plans(preset: RoadTown, count: int) -> list[Plan]:
    return [make_plan(preset, seed, closed_loop=True) for seed in range(count)]


def _mean(plans: list[Plan], controller: str) -> float:
    def create(number: int) -> Controller:
        return controller_entry(controller, "helicopter").create()

    return float(shares_in_view(plans, create).mean())


def test_quick_random_commands_lose_the_car_more_than_rest_and_rest_more_than_centring() -> None:
    plans = _plans(PRESETS["quick"], 16)
    random = float(shares_in_view(plans, AtRandom).mean())
    rest = _mean(plans, "hold")
    assert random < rest - 0.04
    assert rest < _mean(plans, "centre") - 0.1


def test_standard_gusts_that_build_up_are_flown_against_and_sudden_ones_are_not() -> None:
    standard = PRESETS["standard"]
    sudden = replace(standard, frame_outs=replace(standard.frame_outs, build_up_s=None))
    plans = _plans(standard, 5)
    leant = _mean(plans, "reentry")
    assert _mean(plans, "hold") < 0.4
    assert 0.4 < _mean(plans, "centre_as_written") < leant - 0.1
    assert _mean(_plans(sudden, 5), "reentry") < leant - 0.02
    assert leant < 0.99, "frame-outs remain to recover from"


def test_oblique_a_helicopter_that_centres_does_not_fly_over_the_car() -> None:
    plans = _plans(PRESETS["oblique"], 4)
    centred = _mean(plans, "centre")
    assert centred > 0.75
    assert _mean(plans, "hold") < centred - 0.2


def test_the_car_waits_in_closed_loop_alone() -> None:
    preset = PRESETS["quick"]
    for closed_loop in (True, False):
        speed_mps = make_plan(preset, 7, closed_loop=closed_loop).motion.speed_mps[:, 0]
        waits = np.count_nonzero(speed_mps < 0.3) >= preset.wait_s[0] * preset.rate_hz
        assert waits == closed_loop
