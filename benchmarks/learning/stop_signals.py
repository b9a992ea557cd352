"""SIGINT and SIGTERM, deferred while an update is under way."""

from __future__ import annotations

import signal
from typing import Any


class StopSignals:
    """A context in which SIGINT and SIGTERM raise KeyboardInterrupt; held signals raise it upon release."""

    def __init__(self) -> None:
        self._held = self._came = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> StopSignals:
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._take)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def hold(self) -> None:
        """Hold signals from now on."""
        self._held = True

    def release(self) -> None:
        """Raise KeyboardInterrupt for a held signal; later signals raise it at once."""
        self._held = False
        if self._came:
            raise KeyboardInterrupt

    def _take(self, *_: object) -> None:
        self._came = True
        if not self._held:
            raise KeyboardInterrupt
