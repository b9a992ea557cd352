"""Worker processes: how many, and what joblib tells about them in vain."""

from __future__ import annotations

import os
import warnings

from sim.checks import check

# joblib replaces a worker that has grown by 300 MB, for which a kept town is enough, and tells it like a fault.
warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)


def cores(workers: int | None) -> int:
    """Return the number of workers, by default one for each core of this process. Raises ValueError for no number."""
    good = workers is None or (isinstance(workers, int) and workers >= 0)
    check("workers", good, "a whole number >= 0", repr(workers))
    return len(os.sched_getaffinity(0)) if workers is None else workers
