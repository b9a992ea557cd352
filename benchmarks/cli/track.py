"""``frameout track``: a tracker on a user's own footage."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro
from numpy.typing import NDArray

from benchmarks.cli.arguments import COUNT, FILE, ONE_NAME, RATE, Processes, WithModules
from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.contract.text import counted
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.data.footage.answers import Answers
from benchmarks.data.footage.detection import first_moving
from benchmarks.data.footage.episode import FootageSpec
from benchmarks.data.footage.screen import Screen
from benchmarks.data.footage.sources import Footage, Picture, open_footage
from benchmarks.data.footage.tracking import Made, Wanted, suite_of, track
from benchmarks.run.jobs import Job
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.result_folder import check_file
from benchmarks.run.selection import Registered, tracker_named
from benchmarks.run.time_limit import check_limit
from benchmarks.show.progress import progress_bar
from sim.checks import check

_LARGEST_SCALE = 4.0
_UNFAIR = ("blind", "oracle")
_WAYS = "one of --box X,Y,W,H, --pick and --detect"
_BOX = tyro.conf.arg(metavar="X,Y,W,H", help_behavior_hint="")


@dataclass(frozen=True)
class Track(WithModules):
    """Run a tracker on your own video, and write an overlay of what it answers.

    The video's picture has a margin around it, with what the camera saw there before. A path is where estimates of the
    last seconds are now, in the picture or outside it, by the motion of the camera, which is measured in the pictures.
    A tracker of one target starts on a box in the first picture: give it (--box), drag it (--pick), or take the largest
    thing that moves (--detect; then it starts where that is sure). A tracker of many finds its targets itself. Ctrl-C
    ends at the present picture; video and estimates are kept. The footage has no scale, so there are no metres, and no
    pose of the camera is given to the tracker.

    Attributes:
        video: a video file, a folder of pictures, the number of a camera (0 is the first), or an address (rtsp://…).
        tracker: name of the tracker, see `frameout list`.
        process: a tracker in a process of its own, NAME=COMMAND, see CONTRIBUTING.md; --tracker need not name it.
        box: left, top, width and height of the target in the first picture, in pixels from its top left corner, as a
            player shows it.
        pick: drag the box in a window; needs a screen and pygame (pip install 'frameout[play]').
        detect: start on the largest thing that moves before the background, which may move as a whole.
        estimates: file for the estimates too: MOT text (.txt), CSV (.csv) or Parquet (.parquet).
        show: show the overlay in a window while it is made; Escape ends.
        frames: most pictures (default: all).
        rate_hz: pictures a second of a folder of pictures (default: 30); videos tell it.
        scale: size of the view over that of the picture, 1 to 4; 1 = no margin.
        limit_s: most CPU time in seconds for one picture; waiting may take ten times as long.
        out: the file (default: results/VIDEO-TRACKER.mp4).
    """

    video: tyro.conf.Positional[str]
    tracker: Annotated[str, ONE_NAME] = ""
    process: Processes = ()
    box: Annotated[str | None, _BOX] = None
    pick: bool = False
    detect: bool = False
    estimates: Annotated[Path | None, FILE] = None
    show: bool = False
    frames: Annotated[int | None, COUNT] = None
    rate_hz: Annotated[float | None, RATE] = None
    scale: float = 1.5
    limit_s: float = 60.0
    out: Annotated[Path | None, FILE] = None
    resumes = False

    def run(self) -> int:
        """Track; return the exit status."""
        check("scale", 1 <= self.scale <= _LARGEST_SCALE, f"a number from 1 to {_LARGEST_SCALE:g}", f"{self.scale:g}")
        check("frames", self.frames is None or self.frames >= 1, "a whole number >= 1", self.frames)
        check_limit(self.limit_s)
        tracker = self._tracker()
        many = not self._ways()
        check("box", not many or _follows_many(tracker), f"{_WAYS}, as {tracker.name} follows one target", "none")
        screen = Screen("show" if self.show else "pick") if self.show or self.pick else None
        footage = open_footage(self.video, self.rate_hz)
        try:
            return self._run(tracker, many, footage, screen)
        finally:
            footage.close()
            if screen is not None:
                screen.close()

    def _ways(self) -> int:
        """Return in how many ways the box is given; 0 = none, for a tracker of many."""
        ways = (self.box is not None) + self.pick + self.detect
        check("box", ways <= 1, _WAYS, f"{ways} of them")
        return ways

    def _tracker(self) -> TrackerSpec:
        added = process_trackers(self.process, self.limit_s)
        name = self.tracker or next(iter(added), "")
        check("tracker", bool(name), "a name, by --tracker or --process", "none")
        tracker = added.get(name) or tracker_named(name)
        check("tracker", tracker.role not in _UNFAIR, "one that sees pictures", f"{name!r}, which sees none")
        needs = tracker.missing()
        check("tracker", not needs, "one of which all that it needs is installed", f"{name}: {needs}")
        return tracker

    def _run(self, tracker: TrackerSpec, many: bool, footage: Footage, screen: Screen | None) -> int:
        out = self.out or Path("results") / f"{Path(footage.name).stem}-{tracker.name}.mp4"
        check("out", out.suffix == ".mp4", "a file that ends in .mp4", repr(str(out)))
        check_file(out, "out")
        check("out", out.resolve() != Path(self.video).resolve(), "another file than the video", repr(str(out)))
        # Before a box is dragged.
        answers = None if self.estimates is None else Answers(self.estimates)
        pictures = footage.pictures()
        first, box_xyxy = self._start(pictures, screen)
        spec = FootageSpec(footage.name, first, pictures, box_xyxy, footage.rate_hz, footage.expected)
        show = screen.show if screen is not None and self.show else Wanted.show
        wanted = Wanted(out, answers, self.scale, self.frames, show)
        suite = suite_of(tracker, many)
        job = Job(suite, spec, {tracker.name: tracker}, self.modules, repeats=1, limit_s=self.limit_s)
        with progress_bar(f"{footage.name}, pictures") as progress, trackers_print_to_stderr():
            made = track(job, wanted, progress)
        return self._report(made, footage, out)

    def _start(self, pictures: Iterator[Picture], screen: Screen | None) -> tuple[Picture, NDArray[np.float64] | None]:
        """Return the first picture to track in, and the box (4,) of the target in it; None without one."""
        if self.detect:
            first, box = first_moving(pictures)
            words = ",".join(f"{number:.0f}" for number in (*box[:2], *(box[2:] - box[:2])))
            print(f"note: starts at {first.time_s:.2f} s on what moves there, --box {words}", file=sys.stderr)
            return first, box
        first = next(pictures)
        if screen is not None and self.pick:
            box_or_none = screen.box_on(first.image_rgb)
            check("pick", box_or_none is not None, "a box, dragged in the window", "none")
            return first, box_or_none
        return first, None if self.box is None else _box(self.box, first.image_rgb.shape)

    def _report(self, made: Made, footage: Footage, out: Path) -> int:
        for note in footage.notes:
            print(f"note: {note}", file=sys.stderr)
        if made.frames:
            print(f"{out} ({counted(made.frames, 'picture')})")
            if self.estimates is not None:
                print(self.estimates)
        if made.failure:
            kept = "what was made before is kept" if made.frames else "nothing was made"
            print(f"error: {made.failure}; {kept}", file=sys.stderr)
            return 1
        if made.stopped and not footage.is_live:
            raise KeyboardInterrupt
        return 0


def _follows_many(tracker: TrackerSpec) -> bool:
    """Return whether a tracker may follow many targets; one in a process says so only when it starts."""
    return not isinstance(tracker, Registered) or tracker.entry.follows_many


def _box(text: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Return the box (4,) x_min, y_min, x_max, y_max of left, top, width and height in a picture of a shape."""
    try:
        left, top, width, height = (float(word) for word in text.split(","))
    except ValueError:
        left = top = width = height = np.nan
    box = np.array([left, top, left + width, top + height])
    good = np.isfinite(box).all() and width > 0 and height > 0
    check("box", bool(good), "left,top,width,height in pixels, with a width and height above 0", repr(text))
    size = f"the picture of {shape[1]} x {shape[0]} pixels"
    meets = bool((box[:2] < (shape[1], shape[0])).all() and (box[2:] > 0).all())
    check("box", meets, f"one that meets {size}", repr(text))
    beyond_px = max(*-box[:2], *(box[2:] - (shape[1], shape[0])))
    if beyond_px >= 1:
        reach = f"the box reaches {beyond_px:.0f} px beyond the picture"
        print(f"note: {reach}; it is left,top,width,height", file=sys.stderr)
    return box
