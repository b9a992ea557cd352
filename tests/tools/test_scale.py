"""What large sets cost follows from a few frames, and sets of many episodes are handled."""

from __future__ import annotations

import pytest

from tests.tools.command import tools
from tools.scale import Cost


def test_costs_are_those_of_frames_and_episodes() -> None:
    """A thousand episodes of 100 frames: 100 × 0.036 s and 3.6 s each, 100 × 1 KiB and 1 MiB, five files."""
    cost = Cost(100, 0.036, 3.6, 2.0**10, 2.0**20, 5)
    cells = cost.of(100_000, 100)
    assert cells[:5] == ["1.0", "1.0", "36.0", "3.60", "100"]
    assert cells[5] == "2", "core hours"
    assert float(cells[6]) == pytest.approx(1000 * (2**20 + 100 * 2**10) / 2**40, abs=0.005)
    assert cells[10] == "694", "1,000 workers make an episode in 7.2 s"
    assert float(Cost(100, 0.036, 3.6, 2.0**20, 0.0, 5).of(10**8, 100)[8]) == pytest.approx(5 + 2 + 2), "sent in parts"


@pytest.mark.heavy
def test_a_set_of_many_episodes_is_handled(capsys: pytest.CaptureFixture[str]) -> None:
    assert tools(["scale", "--scenes", "none", "--episodes", "300"]) == 0
    told = capsys.readouterr().out
    assert all(f"\n| {step} |" in told for step in ("resume", "merge", "open", "verify")), told
