"""Progress in a log file: few lines, as soon as there is something to say, and one at the end."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from benchmarks.show import progress
from benchmarks.show.progress import progress_bar


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Stand in for the time; ``clock.now`` is set by the test."""
    stands = SimpleNamespace(now=1000.0)
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: stands.now))
    return stands


def test_a_log_has_a_line_every_half_minute_and_one_at_the_end(
    clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]
) -> None:
    with progress_bar("town") as report:
        report(20, 120)
        for done in range(21, 121):
            clock.now += 1.0
            report(done, 120)
            if done == 50:
                # Said while the work goes on.
                assert capsys.readouterr().err == "town: 50 of 120, 0:00:30 passed\n"
    assert capsys.readouterr().err.splitlines() == [
        "town: 80 of 120, 0:01:00 passed",
        "town: 110 of 120, 0:01:30 passed",
        "town: 120 of 120, 0:01:40 passed",
    ]


def test_what_was_done_before_an_error_is_said(clock: SimpleNamespace, capsys: pytest.CaptureFixture[str]) -> None:
    def fail_after_one() -> None:
        with progress_bar("town") as report:
            report(0, 2)
            report(1, 2)
            clock.now += 5.0
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_after_one()
    assert capsys.readouterr().err == "town: 1 of 2, 0:00:00 passed\n"


def test_nothing_is_said_where_nothing_was_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("town"):
        pass
    assert capsys.readouterr().err == ""
