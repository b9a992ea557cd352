"""The reward's terms by hand, and in their ranges whatever happens."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios.envs.reward import TERMS, Reward, Rewarder, reward_of
from trackers.types import CameraModel

CAMERA = CameraModel(200, 100, 100.0)
RATE_HZ = 10.0
TARGET = 0


def frame(x: float, y: float = 50.0, length: float = 24.0) -> Any:
    box = np.array([[x - length / 2, y - 2, x + length / 2, y + 2]])
    truth = SimpleNamespace(position_px=np.array([[x, y]]), box_xyxy=box)
    return SimpleNamespace(judged=(truth, CAMERA))


def test_terms_by_hand() -> None:
    reward = Reward(in_view=2.0, centred=3.0, size=5.0, effort=7.0, loss=11.0, length_share=0.12, loss_after_s=0.2)
    rewarder = Rewarder(reward, RATE_HZ)
    terms = rewarder.terms(frame(150.0), TARGET, effort=0.25)
    assert tuple(terms) == TERMS
    # Half way to the border, with the wanted length.
    assert terms == pytest.approx(
        {"in_view": 2.0, "centred": 3 * np.tanh(0.5), "size": 5.0, "effort": -1.75, "loss": 0.0}
    )
    assert rewarder.terms(frame(150.0, length=24 * np.e), TARGET, 0.0)["size"] == pytest.approx(5 * np.exp(-0.5))
    losses = [rewarder.terms(frame(250.0), TARGET, 0.0)["loss"] for _ in range(4)]
    assert losses == [0.0, -11.0, 0.0, 0.0], "a loss costs once"
    assert rewarder.frames_out == 4
    assert rewarder.terms(frame(250.0), TARGET, 0.0)["size"] == 0.0
    rewarder.terms(frame(100.0), TARGET, 0.0)
    assert rewarder.frames_out == 0
    assert [rewarder.terms(frame(250.0), TARGET, 0.0)["loss"] for _ in range(2)] == [0.0, -11.0]


@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(0.1, 500), st.floats(0, 1)), min_size=1, max_size=8))
def test_terms_keep_to_their_ranges(steps: list[tuple[float, float, float]]) -> None:
    rewarder = Rewarder(Reward(1.0, 1.0, 1.0, 1.0, 1.0), RATE_HZ)
    for x, length, effort in steps:
        terms = rewarder.terms(frame(x, length=length), TARGET, effort)
        assert terms["in_view"] in (0.0, 1.0)
        assert 0.0 <= terms["centred"] < 1.0
        assert 0.0 <= terms["size"] <= terms["in_view"]
        assert terms["effort"] == -effort
        assert terms["loss"] in (0.0, -1.0)


def test_a_mapping_changes_the_fields_that_it_names() -> None:
    assert reward_of({"effort": 0, "size": np.float32(0.5)}) == Reward(effort=0.0, size=0.5)
