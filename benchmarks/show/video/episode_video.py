"""MP4 files of episodes with the drawing of their scenario, under each picture a caption with a time line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import cast

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.run.experiment import Progress
from benchmarks.run.failures import Failure
from benchmarks.run.jobs import Job, opened
from benchmarks.run.result_folder import make_folder
from benchmarks.show.replay import replay
from benchmarks.show.showing import drawing_of
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Drawing, InLargerView, Instant
from benchmarks.show.video.surroundings import surrounded
from sim.checks import check

LARGEST_SCALE = 8
"""Limit of a larger view, whose buffers and encoder then take 2 GB."""
HEIGHT_PX = 116
_TRACK_TOP, _TRACK_BOTTOM = 78, 106
_WIDE_PX, _SHOWN_PX = 1600, 1280
_USUAL_COUNT = 256
"""Length of a time line to begin with, if the number of frames is not known."""
_TICKS_HZ = 90_000
"""Resolution of times of pictures that do not come at an even rate, that of MPEG."""


def render_episode(
    job: Job,
    out: Path,
    *,
    frames: int | None = None,
    scale: float = 2.0,
    progress: Progress = lambda done, of: None,
) -> list[Failure]:
    """Write the episode of a job as an MP4; return the failures in it.

    Args:
        job: gives the pictures and, with trackers, the estimates of the first.
        out: file (H.264 in MP4), written atomically.
        frames: number of frames; None = the whole episode.
        scale: size of the larger view relative to the observed frame, 1 to 8; for scenarios shown in one, and for what
            is real, with earlier pictures around the present one.
        progress: called with the number of frames written, and of all.

    Raises:
        ValueError: names the parameter, what was expected and what came.
    """
    check("scale", 1 <= scale <= LARGEST_SCALE, f"a number from 1 to {LARGEST_SCALE}", scale)
    check("frames", frames is None or frames >= 1, "a whole number >= 1", frames)
    check("out", out.suffix == ".mp4" and not out.is_dir(), "a file that ends in .mp4", repr(str(out)))
    make_folder(out.parent)
    spec = job.episode
    is_real = spec.scenario is None
    with opened(job) as live:
        episode = live.loop.episode
        count = episode.frame_count if frames is None else min(frames, episode.frame_count)
        by = spec.steering
        steered = [] if by is None else [by.name, *([f"{by.link} link"] if by.link else [])]
        which = [spec.preset, spec.sequence] if is_real else [spec.scenario_id, spec.preset, f"seed {spec.seed}"]
        title = " · ".join(dict.fromkeys([*which, *job.trackers, *steered]))
        drawing = InLargerView() if is_real else drawing_of(spec.scenario_id, episode)
        # What surrounds a real picture is known from earlier ones alone.
        rendered_scale = scale if drawing.uses_larger_view and not is_real else 1.0

        def instants() -> Iterator[Instant]:
            # A frame is reported when the next one is requested, since it is then written.
            progress(0, count)
            shown = replay(live, scale=rendered_scale, wanted=range(count), frame_count=count)
            if drawing.uses_larger_view:
                shown = surrounded(shown, episode.rate_hz, scale if is_real else None)
            for done, instant in enumerate(shown, 1):
                yield instant
                progress(done, count)

        write_video(out, instants(), drawing, rate_hz=episode.rate_hz, title=title, frame_count=count)
        return live.failures()


def write_video(
    out: Path, instants: Iterable[Instant], drawing: Drawing, *, rate_hz: float, title: str, frame_count: int
) -> None:
    """Write instants as an MP4, under each a caption with ``title`` and a time line of ``frame_count``."""
    caption = Caption(drawing, title, frame_count)
    drawn = (caption.below(drawing.picture(each), each) for each in instants)
    write_mp4(out, ((picture, index / rate_hz) for index, picture in enumerate(drawn)), rate_hz)


class Caption:
    """Draws a strip below the pictures, frame by frame, with a time line of all frames so far."""

    def __init__(self, drawing: Drawing, title: str, frame_count: int | None) -> None:
        """``frame_count``: of the time line, which becomes twice as long where it does not suffice; None = unknown."""
        self._drawing = drawing
        self._title = title
        self._frame_count = frame_count or _USUAL_COUNT
        self._occasional: dict[str, marks.Rgb] = {}
        self._shades: list[tuple[marks.Rgb, ...]] = []
        self._probabilities: list[float] = []
        self._bands: NDArray[np.uint8] | None = None

    def below(self, picture: NDArray[np.uint8], instant: Instant) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) of the next instant with the strip below it: (H + HEIGHT_PX, W, 3).

        In a wide picture, which is seen smaller, the strip is as much larger as the picture is wider than 1280.
        """
        width = picture.shape[1]
        strip = self._strip(width if width < _WIDE_PX else _SHOWN_PX, instant)
        if width >= _WIDE_PX:
            size = width, round(HEIGHT_PX * width / _SHOWN_PX)
            strip = np.asarray(cv2.resize(strip, size, interpolation=cv2.INTER_CUBIC), np.uint8)
        return np.concatenate([picture, strip])

    def _strip(self, width_px: int, instant: Instant) -> NDArray[np.uint8]:
        truth, estimate = instant.frame.truth, instant.estimate
        probability = None if estimate is None else estimate.in_view_probability
        self._shades.append(self._drawing.shades(instant))
        self._probabilities.append(np.nan if probability is None else probability)
        strip = np.full((HEIGHT_PX, width_px, 3), marks.GROUND, dtype=np.uint8)
        marks.draw_text(strip, (16, 28), f"frame {truth.frame}", marks.INK, size=19, weight=600)
        marks.draw_text(strip, (130, 28), f"{truth.time_s:.1f} s", marks.QUIET)
        end = marks.draw_text(strip, (200, 28), self._drawing.describe(instant), marks.INK)
        if estimate is not None and np.isnan(estimate.position_px).any():
            end = marks.draw_text(strip, (end + 28, 28), "tracker: no answer", marks.ESTIMATE)
        elif probability is not None:
            end = marks.draw_text(strip, (end + 28, 28), f"tracker: {probability:.0%} in view", marks.ESTIMATE)
        title = marks.shortened(self._title, strip.shape[1] - 48 - end, size=14)
        left = width_px - 16 - marks.text_width_px(title, size=14)
        marks.draw_text(strip, (left, 27), title, marks.QUIET, size=14)
        self._draw_legend(strip, instant)
        self._draw_time_line(strip)
        return strip

    def _draw_legend(self, strip: NDArray[np.uint8], instant: Instant) -> None:
        signs = dict(self._drawing.signs)
        signs |= {} if instant.frame.steered is None else {"2nd camera": marks.OBSERVED}
        signs |= {} if instant.answer is None else self._drawing.answers
        # New entries come last and stay, so that no entry moves.
        self._occasional |= self._drawing.occasional(instant)
        signs |= self._occasional
        x = 16
        for words, colour in signs.items():
            strip[46:60, x : x + 20] = colour
            x = marks.draw_text(strip, (x + 28, 58), words, marks.QUIET, size=14) + 24

    def _draw_time_line(self, strip: NDArray[np.uint8]) -> None:
        left, right = 16, strip.shape[1] - 16
        drawn = len(self._shades) - 1
        if self._bands is None or len(self._shades) > self._frame_count:
            self._frame_count *= 1 if len(self._shades) <= self._frame_count else 2
            self._bands = np.full((_TRACK_BOTTOM - _TRACK_TOP, strip.shape[1], 3), (36, 39, 45), np.uint8)
            drawn = 0
        edges = np.linspace(left, right, self._frame_count + 1)
        for k, shades in enumerate(self._shades[drawn:], start=drawn):
            rows = np.linspace(0, len(self._bands), len(shades) + 1).round().astype(int)
            for top, bottom, shade in zip(rows[:-1], rows[1:], shades, strict=True):
                self._bands[top:bottom, round(edges[k]) : round(edges[k + 1])] = shade
        strip[_TRACK_TOP:_TRACK_BOTTOM, left:right] = self._bands[:, left:right]
        # More points than this are not told apart.
        step = max(1, self._frame_count // (4 * strip.shape[1]))
        known = np.flatnonzero(np.isfinite(self._probabilities))[::step]
        if len(known) > 1:
            share = np.array(self._probabilities)[known]
            y = _TRACK_BOTTOM - 3 - share * (_TRACK_BOTTOM - _TRACK_TOP - 6)
            x = 0.5 * (edges[known] + edges[known + 1])
            marks.draw_lines(strip, [np.stack([x, y], axis=1)], marks.ESTIMATE)
        now = edges[len(self._shades)]
        marks.draw_lines(strip, [[(now, _TRACK_TOP - 4.0), (now, _TRACK_BOTTOM + 4.0)]], marks.INK, 1)


def write_mp4(
    path: Path,
    pictures: Iterable[tuple[NDArray[np.uint8], float]],
    rate_hz: float,
    *,
    is_even: bool = True,
    options: Mapping[str, str] = MappingProxyType({"crf": "20", "preset": "veryfast", "tune": "animation"}),
) -> None:
    """Write pictures, at least one, as H.264 in MP4.

    The file is written as ``.part`` and renamed at the end; after an error nothing is left. One encoding thread and no
    time stamps: the same pictures make the same bytes. An odd last row or column is left out: yuv420p has even sizes
    only.

    Args:
        pictures: (H, W, 3), all of one size, with their times in seconds, which increase.
        rate_hz: frames a second, > 0.
        is_even: whether they come at this rate; else each is shown at its own time, the first one at once.
        options: of the encoder, libx264.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    try:
        with av.open(str(part), "w", format="mp4", options={"movflags": "+faststart"}) as file:
            file.flags |= cast(int, av.container.Flags.bitexact.value)
            rate = max(Fraction(rate_hz).limit_denominator(1001), Fraction(1, 1001))
            stream = file.add_stream("libx264", rate=rate, options={**options, "threads": "1"})
            stream.pix_fmt = "yuv420p"
            ticks_hz = rate if is_even else Fraction(_TICKS_HZ)
            stream.codec_context.time_base = 1 / ticks_hz
            last = -1
            for index, (image_rgb, time_s) in enumerate(pictures):
                height, width = (side & ~1 for side in image_rgb.shape[:2])
                if index == 0:
                    stream.height, stream.width = height, width
                even = np.ascontiguousarray(image_rgb[:height, :width])
                frame = av.VideoFrame.from_ndarray(even, format="rgb24")
                frame.pts = last = max(round(time_s * float(ticks_hz)), last + 1)
                frame.time_base = 1 / ticks_hz
                file.mux(stream.encode(frame))
            file.mux(stream.encode())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
