"""How the suite ``harbour`` is shown."""

from __future__ import annotations

from benchmarks.show.harbour.drawing import HarbourDrawing
from benchmarks.show.harbour.figures import figures
from benchmarks.show.harbour.picture import show_visit
from benchmarks.show.showing import Showing

SHOWING = Showing(
    heading="Who comes into the harbour?",
    figures=figures,
    picture=show_visit,
    drawings={"harbour": HarbourDrawing},
)
