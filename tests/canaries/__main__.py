"""Keep the digests of new things and of raised editions: ``python -m tests.canaries``. All others stay."""

from __future__ import annotations

import os

from benchmarks.run.arithmetic import missing_settings

# Before NumPy is imported, as commands do it.
os.environ.update(missing_settings(os.environ))

from tests.canaries.canaries import canaries, keep

keep(canaries())
