"""Work that takes a known time, and a world that TinyRenderer's stand-in draws slowly."""

from __future__ import annotations

import time
from typing import Any

import pytest

BARE_S = 0.02


def work(seconds: float) -> None:
    """Keep the processor busy."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


class FakeWorld:
    """Counts the bare calls; those without shadows are half the work. Taking changes is slow, and is not timed."""

    calls = 0

    def hand_over(self) -> None:
        work(2 * BARE_S)

    def camera_image(self, *arguments: Any, shadows: bool, **options: Any) -> None:
        FakeWorld.calls += 1
        work(BARE_S if shadows else BARE_S / 2)


@pytest.fixture(autouse=True)
def _stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("envs", "rendering"):
        monkeypatch.setattr(f"tools.speed.{module}.TinyRenderer", lambda world: world)
    FakeWorld.calls = 0
