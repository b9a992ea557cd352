"""How the suite ``follow`` is shown."""

from __future__ import annotations

from benchmarks.show.follow.figures import figures
from benchmarks.show.showing import Showing

SHOWING = Showing(
    heading="Is it kept in view?",
    figures=figures,
    oracles="An oracle's controller steers by the true position: what it misses is due to carrier, gusts, controller.",
)
