"""The values that ``shoal_chain`` is shipped with find the fish of pictures that they were not tuned on."""

from __future__ import annotations

from contextlib import closing
from itertools import islice

import numpy as np
import pytest

from scenarios import catalog
from scenarios.loop import Loop
from trackers.fish_chain.detection import Detector
from trackers.registry import entry


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [1, 3])
def test_small_fish_are_found_beside_lamps(seed: int) -> None:
    """Seed 3 has lamps in the water, seed 1 has none; tuning saw pictures of twice the size."""
    with closing(catalog.scenario("fish-tank-v1").episode("quick", seed)) as episode:
        detector = Detector(entry("shoal_chain").parameters())
        detector.start(episode.start.background)
        found = []
        for frame in islice(Loop(episode).frames(), 60):
            found.append(len(detector.detect(frame.observation)))
        fish = sum(kind == "fish" for kind in frame.truth.kinds)
    assert fish == 5
    # Two that touch are one blob.
    assert 0.8 * fish <= np.mean(found[30:]) <= fish
