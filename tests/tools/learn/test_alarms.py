"""What is learnt from episodes of the harbour."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tools.learn.alarms import (
    CONFIDENCE_PATHS,
    LEARNERS,
    PLACES_PATH,
    fit_weights,
    learn_confidences,
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


def stays(*episodes: tuple[list[tuple[float, float]], int]) -> pd.DataFrame:
    """Return episodes in each of which one intruder stays at each place, for so many frames."""
    tables = []
    for places_m, frames in episodes:
        rows = [[x, y, 0.5, 0.4, 0.5, 1.7, k, frame] for k, (x, y) in enumerate(places_m) for frame in range(frames)]
        tables.append(pd.DataFrame(rows, columns=[*PLACE_COLUMNS[:-1], "intruder", "frame"]))
    return pd.concat(tables, keys=[("quick", seed) for seed in range(len(episodes))], names=["preset", "seed"])


def test_places_are_ranked_by_the_intruders_who_stayed_there() -> None:
    passed_by = ([(20.0, 10.0)], 3)
    places = often_visited(stays(([(1.0, 1.0), (1.4, 1.2), (-8.0, 4.0)], 6), ([(1.0, 1.0)], 9), passed_by))
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


def test_each_tracker_has_weights_of_its_own_answers() -> None:
    rng, names = np.random.default_rng(1), LEARNERS["baselines"]
    answers = pd.DataFrame(rng.normal(size=(60, len(EVIDENCE))), columns=list(EVIDENCE))
    answers = answers.assign(tracker=[names[k % 3] for k in range(60)], found=np.arange(60) % 2 == 0, weight=1.0)
    weights = learn_confidences(answers, names)["weights"]
    assert list(weights) == [*names]
    for name, learnt in weights.items():
        own = answers[answers["tracker"] == name]
        fitted = fit_weights(own[list(EVIDENCE)].to_numpy(), own["found"].to_numpy(), np.ones(20))
        assert learnt == dict(zip(EVIDENCE, fitted.round(4), strict=True))
