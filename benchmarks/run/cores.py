"""The number of worker processes."""

from __future__ import annotations

import os


def cores(workers: int | None) -> int:
    """Return the number of workers, by default one for each core of this process."""
    return len(os.sched_getaffinity(0)) if workers is None else workers
