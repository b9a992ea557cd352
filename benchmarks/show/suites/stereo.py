"""How the suite ``stereo`` is shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.judges.stereo.disparity import ALL_PIXELS, DISPARITY, TARGET_PIXELS
from benchmarks.judges.stereo.judge import OCCLUSION_WINDOW_FRAMES
from benchmarks.judges.stereo.metrics.people_events import LIGHT_KINDS, NEAR, NOBODY_NEAR
from benchmarks.judges.stereo.suite import event_f1
from benchmarks.show.charts import Chart, curves_of, lines_of, recovery
from benchmarks.show.pictures import EventPicture, ShownEvent
from benchmarks.show.showing import Showing
from benchmarks.show.tables import Facts
from benchmarks.show.video.stereo import StereoDrawing
from scenarios.stereo_follow.floor_plan import PLACES

_GROUPS = {**{f"after {kind}": kind for kind in LIGHT_KINDS}, NEAR: NEAR, NOBODY_NEAR: NOBODY_NEAR}
"""Words of the chart → kind of event."""
_LONG_FRAMES = 3
"""Least length of an occlusion to show."""
_AFTERWARDS_FRAMES = 10
_CAPTION = (
    "Left the camera's picture, right all people from above. Blue: the target. Orange: the estimate; none "
    "without an answer. Grey: the others."
)
_OCCLUSION_WORDS = "the first occlusion of 3 frames or more; before it, in its middle, seen again, ten frames later."
_LIGHT_WORDS = "the first change of light ({kind}); before it, and in the two seconds after it."


def charts(drawn: Mapping[str, Sequence[Row]]) -> list[Chart]:
    """Return F1 by kind of event, and the time to recover."""
    return [
        Chart(
            title="When is the person lost?",
            words="F1, in which a wrong answer is a miss too, over the frames of the 2 s after a change of light, and "
            "of those with and without another person within 1.5 m.",
            lines=lines_of({words: event_f1("f1", "", kind).statistic for words, kind in _GROUPS.items()}, drawn),
            x_label="F1 of right, wrong and missing answers",
            x_scale="share",
        ),
        Chart(
            title="How soon is the person found again?",
            words="Kaplan–Meier: a person who is never found again counts as lost to the next occlusion or the end.",
            curves=curves_of(drawn, recovery),
            x_label="frames since half of the person is seen again",
            x_scale="frames",
            y_label="found again",
            steps=True,
            shaded=(OCCLUSION_WINDOW_FRAMES, "← counts as recovered"),
        ),
    ]


def first_event(rows: Sequence[Row]) -> ShownEvent | None:
    """Return the first occlusion by seed that lasts 3 frames and can be judged, else the first change of light."""
    events = [(row["seed"], row["event"], row["metric"]) for row in rows if row["event"] is not None]
    hidden = [
        (seed, event)
        for seed, event, metric in events
        if metric == "recovered" and event["length_frames"] >= _LONG_FRAMES and event["back_frame"] is not None
    ]
    shown = hidden or [(seed, event) for seed, event, _ in events if event["light"]]
    if not shown:
        return None
    seed, event = min(shown, key=lambda pair: (pair[0], pair[1]["index"]))
    first, last = event["first_frame"], event["first_frame"] + event["length_frames"] - 1
    if hidden:
        frames = [first - 1, (first + last) // 2, event["back_frame"], event["back_frame"] + _AFTERWARDS_FRAMES]
        return ShownEvent(seed, frames, "One occlusion", f"{_OCCLUSION_WORDS} {_CAPTION}")
    frames = [first - 1, *np.linspace(first, last, 4).round().astype(int).tolist()[1:]]
    return ShownEvent(seed, frames, "One change of light", f"{_LIGHT_WORDS.format(kind=event['kind'])} {_CAPTION}")


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
    charts=charts,
    event_picture=EventPicture(first_event, StereoDrawing.of, cell_width_px=640),
    facts=MATCHES,
    drawings={"stereo-follow": StereoDrawing.of, "paper-sheet": StereoDrawing.of},
)
