"""Splits of a set, and sets of earlier formats."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.data.sets.request import SPLITS, Request, request_of
from tests.benchmarks.data.sets.small import tiny

SHARES = {"train": 0.7, "val": 0.2, "test": 0.1}


def test_without_shares_only_the_test_split_of_the_benchmark_is_for_tests() -> None:
    seeds = {0: "train", 9_999: "train", 10_000: "test", 19_999: "test", 20_000: "train"}
    assert {seed: tiny().split_of(seed) for seed in seeds} == seeds


@given(st.integers(0, 10**9), st.integers(1, 2000), st.lists(st.integers(0, 20), min_size=3, max_size=3).filter(sum))
def test_of_any_successive_seeds_each_split_has_its_share(first: int, count: int, weights: list[int]) -> None:
    """The bound is far below what independent draws reach, whose deviation grows with the root of the count."""
    splits = {name: weight / sum(weights) for name, weight in zip(SPLITS, weights, strict=True)}
    request = tiny(splits=splits)
    seeds = [seed for seed in range(first, first + count) if seed not in TEST_SPLIT]
    found = [request.split_of(seed) for seed in seeds]
    for name, share in splits.items():
        assert abs(found.count(name) - share * len(seeds)) <= 6
        assert share > 0 or name not in found


def test_an_episode_stays_in_its_split_when_a_set_grows_and_test_seeds_are_never_trained_on() -> None:
    small, large = (tiny(splits=SHARES, seeds=seeds) for seeds in ((0, 10), (0, 40_000)))
    assert [small.split_of(seed) for seed in range(10)] == [large.split_of(seed) for seed in range(10)]
    assert {large.split_of(seed) for seed in TEST_SPLIT} == {"test"}


def test_episodes_of_a_day_are_in_one_split_even_if_other_values_are_drawn_for_them() -> None:
    """The place and the weather of a validation episode were never trained on."""
    preset = "quick[background=0,episodes_a_day=8,people=3:9]"
    request = Request("harbour-v1", preset, (0, 400), ("counts",), splits={"train": 0.7, "val": 0.3})
    days = [{request.split_of(seed) for seed in range(first, first + 8)} for first in range(0, 400, 8)]
    assert {len(each) for each in days} == {1}
    assert abs(days.count({"val"}) - 0.3 * len(days)) <= 3


def test_splits_have_nothing_to_do_with_what_is_drawn_for_an_episode() -> None:
    request = tiny(splits=SHARES, preset="tiny[rate_hz=uniform(5,20)]")
    rates: dict[str, list[float]] = {name: [] for name in SPLITS}
    for seed in range(3000):
        rates[request.split_of(seed)].append(request.configuration(seed).rate_hz)
    for name in SPLITS:
        assert np.mean(rates[name]) == pytest.approx(12.5, abs=4 * 15 / np.sqrt(12 * len(rates[name])))


def test_a_request_of_an_earlier_format_has_its_changes_in_the_preset_s_name() -> None:
    values = json.loads(tiny(preset="tiny").as_json()) | {"format": 3, "size_px": [64, 48], "rate_hz": 7.5}
    for name in ("splits", "classes", "negatives"):
        del values[name]
    request = request_of(json.dumps(values | {"frame_count": None}), "dataset.json")
    assert request.preset == "tiny[height_px=48,rate_hz=7.5,width_px=64]"
    assert request.format == 3
    again = request_of(tiny(splits=SHARES, classes=("car",), negatives=0.1).as_json(), "dataset.json")
    assert again == tiny(splits=SHARES, classes=("car",), negatives=0.1)
