"""What is learnt from episodes of the harbour."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tools.learn.alarms import (
    CONFIDENCE_PATHS,
    LEARNERS,
    PLACES_PATH,
    EpisodeSamples,
    fit_weights,
    learn_confidences,
    learn_places,
    often_visited,
)
from trackers.baselines.ground_linker import EVIDENCE
from trackers.blind.harbour_blind import PLACE_COLUMNS


def test_the_regression_finds_the_weights_of_its_own_model() -> None:
    rng = np.random.default_rng(0)
    evidence = np.column_stack([np.ones(60_000), rng.normal(2.0, 1.5, 60_000), rng.normal(0.0, 0.5, 60_000)])
    true = np.array([-1.0, 0.8, -1.5])
    found = rng.random(60_000) < 1.0 / (1.0 + np.exp(-evidence @ true))
    # As many found as not.
    kept = np.concatenate([np.flatnonzero(found)[:20_000], np.flatnonzero(~found)[:20_000]])
    fitted = fit_weights(evidence[kept], found[kept], np.ones(len(kept)))
    np.testing.assert_allclose(fitted[1:], true[1:], atol=0.15)
    # Rows of the rarer kind weigh more, so that both weigh the same.
    np.testing.assert_allclose(fit_weights(evidence, found, np.ones(60_000)), fitted, atol=0.1)
    # A row of weight 2 counts as two rows.
    twice = np.concatenate([kept, kept[:5000]])
    weight = np.where(np.arange(len(kept)) < 5000, 2.0, 1.0)
    expected = fit_weights(evidence[twice], found[twice], np.ones(len(twice)))
    np.testing.assert_allclose(fit_weights(evidence[kept], found[kept], weight), expected, atol=0.02)


def episode(places_m: list[tuple[float, float]], frames: int) -> EpisodeSamples:
    """Return an episode in which one intruder stays at each place."""
    stays = [[x, y, 0.5, 0.4, 0.5, 1.7] for x, y in places_m for _ in range(frames)]
    intruder = np.repeat(np.arange(len(places_m)), frames)
    empty = np.empty((0, len(EVIDENCE)))
    frame = np.tile(np.arange(frames), len(places_m))
    return EpisodeSamples(np.empty(0, int), empty, np.empty(0, bool), np.empty(0), np.array(stays), intruder, frame)


def test_places_are_ranked_by_the_intruders_who_stayed_there() -> None:
    passed_by = episode([(20.0, 10.0)], 3)
    places = often_visited([episode([(1.0, 1.0), (1.4, 1.2), (-8.0, 4.0)], 6), episode([(1.0, 1.0)], 9), passed_by])
    assert places.shape == (2, len(PLACE_COLUMNS))
    np.testing.assert_array_equal(places[:, -1], [3, 1])
    np.testing.assert_allclose(places[0, :3], [1.114, 1.057, 0.5], atol=1e-3)
    np.testing.assert_allclose(places[1, :6], [-8.0, 4.0, 0.5, 0.4, 0.5, 1.7])


@pytest.mark.parametrize(
    ("path", "key"), [*((path, "weights") for path in CONFIDENCE_PATHS.values()), (PLACES_PATH, "places")]
)
def test_what_is_shipped_was_learnt_by_the_command_on_development_seeds(path: Path, key: str) -> None:
    shipped = json.loads(path.read_text())
    assert set(shipped) == {key, "command"}
    assert shipped["command"].startswith("python -m tools learn-alarms --of ")
    low, _, high = shipped["command"].rpartition(" ")[2].partition(":")
    assert 0 <= int(low) < int(high) <= 10_000


def test_contents_are_numbers_that_the_trackers_load() -> None:
    rng = np.random.default_rng(1)
    one = episode([(1.0, 1.0)], 6)._replace(
        tracker=np.arange(60) % 3,
        evidence=rng.normal(size=(60, len(EVIDENCE))),
        found=np.arange(60) % 2 == 0,
        weight=np.ones(60),
    )
    weights, places = learn_confidences([one], LEARNERS["baselines"]), learn_places([one])
    assert list(weights["weights"]) == [*LEARNERS["baselines"]]
    assert {frozenset(each) for each in weights["weights"].values()} == {frozenset(EVIDENCE)}
    assert np.array(json.loads(json.dumps(places))["places"]).shape == (1, len(PLACE_COLUMNS))
