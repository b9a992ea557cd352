"""How the suite ``stereo`` is shown."""

from __future__ import annotations

from benchmarks.judges.stereo.disparity import ALL_PIXELS, DISPARITY, TARGET_PIXELS
from benchmarks.show.facts import Facts
from benchmarks.show.showing import Showing
from benchmarks.show.stereo.drawing import StereoDrawing
from benchmarks.show.stereo.figures import figures
from benchmarks.show.stereo.picture import show_event
from scenarios.stereo_follow.floor_plan import PLACES

MATCHES = Facts(
    title="Disparity matched from the pair",
    words="The disparity that stereo trackers match from the two noisy pictures, against the true one, f b / z, over "
    "pixels whose point both cameras see by their true depths, in every tenth pair without a lost picture. Pixels at "
    "full size; the pair's small misalignment counts as an error. Error: median of a picture; bad 1 and bad 3: off by "
    "more than 1 or 3 pixels, of pixels with a disparity; density: pixels with one. Intervals: 95 % bootstrap "
    "over seeds.",
    lines={
        "all pixels": ALL_PIXELS,
        "pixels of the target": TARGET_PIXELS,
        **{f"all, the target in: {place}": place for place in PLACES},
    },
    columns=DISPARITY,
)
SHOWING = Showing(
    heading="Is it still the same person?",
    figures=figures,
    picture=show_event,
    facts=MATCHES,
    drawings={"stereo-follow": StereoDrawing.of, "paper-sheet": StereoDrawing.of},
)
