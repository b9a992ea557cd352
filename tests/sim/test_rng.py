"""Seeds and streams are reproducible, independent, and refuse negative numbers."""

from __future__ import annotations

import numpy as np
import pytest

from sim.rng import episode_seed, generator


def test_same_arguments_same_numbers():
    assert episode_seed(0, "road-town-v2", 3) == episode_seed(0, "road-town-v2", 3)
    np.testing.assert_array_equal(generator(5, "air").random(8), generator(5, "air").random(8))


def test_seed_zero_is_a_seed():
    assert episode_seed(0, "road-town-v2", 0) != episode_seed(1, "road-town-v2", 0)


def test_every_argument_matters():
    seeds = {episode_seed(m, s, i) for m in range(20) for s in ("a-v1", "b-v1") for i in range(20)}
    assert len(seeds) == 800
    assert all(0 <= seed < 2**63 for seed in seeds)


def test_streams_are_independent():
    a, b = generator(7, "traffic").normal(size=4000), generator(7, "air").normal(size=4000)
    assert abs(np.corrcoef(a, b)[0, 1]) < 0.06


@pytest.mark.parametrize(("arguments", "name"), [((-1, "a", 0), "master_seed"), ((0, "a", -2), "episode_index")])
def test_negative_numbers_are_refused_by_name(arguments, name):
    with pytest.raises(ValueError, match=f"{name}: expected a whole number >= 0, got -"):
        episode_seed(*arguments)
