from __future__ import annotations

import os
import signal

import pytest

from benchmarks.learning.training import StopSignals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_interrupts_at_once_or_upon_release(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with StopSignals() as signals, pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), number)
    with StopSignals() as signals:
        signals.hold()
        os.kill(os.getpid(), number)
        with pytest.raises(KeyboardInterrupt):
            signals.release()
    assert signal.getsignal(number) == before


def test_nothing_is_raised_without_a_signal() -> None:
    with StopSignals() as signals:
        signals.hold()
        signals.release()
