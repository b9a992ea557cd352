"""A tracker on footage: the overlay and the estimates of what was made, whatever ends it."""

from __future__ import annotations

import signal
import time
import weakref
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.data.footage.answers import Answers
from benchmarks.data.footage.episode import FootageSpec
from benchmarks.data.footage.sources import open_footage
from benchmarks.data.footage.tracking import Made, Wanted, suite_of, track
from benchmarks.data.mot_text import read_mot
from benchmarks.run.jobs import Job
from benchmarks.show.replay import replay
from benchmarks.show.video.drawing import InLargerView
from benchmarks.show.video.episode_video import HEIGHT_PX as CAPTION_PX
from benchmarks.show.video.surroundings import surrounded
from scenarios.loop import FromPictures, LoopTracker, ManyFromPictures
from scenarios.scenario import Episode
from tests.benchmarks.data.footage.written_footage import FIRST_BOX, FRAMES, corner_of, picture_of, write_video
from tests.benchmarks.fake_episode import FakeEpisode, FakeTracker, live
from tests.benchmarks.no_room import no_room
from trackers.types import Estimate, Observation, Track

BOX = np.array([20.0, 40.0, 36.0, 56.0])
assert FIRST_BOX == "20,40,16,16"


@dataclass(frozen=True, kw_only=True)
class Fake(TrackerSpec):
    """A tracker of this module."""

    make: Callable[[], Any]
    name: str = "fake"
    role: str = "external"
    summary: str = ""
    suites: tuple[str, ...] = ()
    parameters: Any = None
    module: str = __name__

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        return ManyFromPictures(self.make()) if many else FromPictures(self.make())


class Reddest:
    """Answers where the picture is red; on picture ``at`` it does something else."""

    def __init__(self, at: int = -1, otherwise: Callable[[], Any] = lambda: None) -> None:
        self._count, self._at, self._otherwise = 0, at, otherwise

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None: ...

    def update(self, observation: Observation) -> Any:
        self._count += 1
        if self._count == self._at and (answer := self._otherwise()) is not None:
            return answer
        rgb = observation.image_rgb.astype(int)
        rows, columns = np.nonzero(rgb[..., 0] - rgb[..., 1:].max(axis=2) > 90)
        box = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1], float)
        return Estimate(0.5 * (box[:2] + box[2:]), box_xyxy=box, in_view_probability=0.75)


class TwoOfThem:
    def start(self, background: Any, camera: Any) -> None: ...

    def update(self, observation: Observation) -> list[Track]:
        places = ((4, 30.0), (7, 90.0))
        return [Track(identity, Estimate(np.array([x, 50.0])), confidence=0.5) for identity, x in places]


def run(
    source: Path, out: Path, make: Callable[[], Any] = Reddest, *, box: NDArray[np.float64] | None = BOX, **wanted: Any
) -> Made:
    footage = open_footage(str(source))
    pictures = footage.pictures()
    spec = FootageSpec(footage.name, next(pictures), pictures, box, footage.rate_hz, footage.expected)
    limit_s = wanted.pop("limit_s", 60.0)
    estimates = wanted.pop("estimates", None)
    answers = None if estimates is None else Answers(estimates)
    tracker = Fake(make=make)
    try:
        job = Job(suite_of(tracker, box is None), spec, {"fake": tracker}, repeats=1, limit_s=limit_s)
        return track(job, Wanted(out, answers, **wanted))
    finally:
        footage.close()


def decode(path: Path) -> tuple[list[NDArray[np.uint8]], list[float]]:
    with av.open(str(path)) as video:
        frames = list(video.decode(video=0))
    return [frame.to_ndarray(format="rgb24") for frame in frames], [float(frame.time or 0.0) for frame in frames]


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    return write_video(tmp_path / "clip.mkv", codec="ffv1", pixels="bgr0")


def test_every_picture_is_in_the_overlay_and_in_the_estimates(clip: Path, tmp_path: Path) -> None:
    out, csv = tmp_path / "made" / "o.mp4", tmp_path / "made" / "e.csv"
    made = run(clip, out, estimates=csv)
    assert made == Made(FRAMES)
    pictures, _ = decode(out)
    assert len(pictures) == FRAMES
    assert pictures[0].shape[1] >= 960
    table = pd.read_csv(csv)
    assert table["frame"].tolist() == list(range(FRAMES))
    corners = table[["x_min_px", "y_min_px"]].to_numpy()
    np.testing.assert_allclose(corners, [corner_of(k) for k in range(FRAMES)], atol=1)
    assert table["in_view_probability"].tolist() == [1.0] + [0.75] * (FRAMES - 1)
    assert sorted(each.name for each in out.parent.iterdir()) == ["e.csv", "o.mp4"]


def test_the_overlay_keeps_the_time_of_a_variable_rate(tmp_path: Path) -> None:
    times_s = [0.0, 0.033, 0.1, 0.5, 0.55, 1.2]
    clip = write_video(tmp_path / "v.mp4", [picture_of(k) for k in range(6)], times_s=times_s)
    run(clip, tmp_path / "o.mp4")
    np.testing.assert_allclose(decode(tmp_path / "o.mp4")[1], times_s, atol=2e-3)


def test_estimates_are_the_same_in_every_format(clip: Path, tmp_path: Path) -> None:
    for ending in ("txt", "csv", "parquet"):
        run(clip, tmp_path / "o.mp4", estimates=tmp_path / f"e.{ending}")
    csv, parquet = pd.read_csv(tmp_path / "e.csv"), pd.read_parquet(tmp_path / "e.parquet")
    assert list(csv) == list(parquet)
    numbers = [name for name in csv if name != "kind"]
    np.testing.assert_allclose(csv[numbers], parquet[numbers].astype(float), atol=1e-3)
    mot = read_mot(tmp_path / "e.txt")
    assert mot.frame.tolist() == list(range(1, FRAMES + 1))
    assert set(mot.identity) == {1}
    boxes = ["x_min_px", "y_min_px", "x_max_px", "y_max_px"]
    np.testing.assert_allclose(mot.box_xyxy, csv[boxes], atol=1e-3)
    np.testing.assert_allclose(mot.confidence, csv["in_view_probability"])


@pytest.mark.parametrize("ending", ["txt", "csv"])
def test_of_answers_their_rows_alone_are_kept(tmp_path: Path, ending: str) -> None:
    """Masks of hours of footage fit in no memory."""
    answers, mask = Answers(tmp_path / f"e.{ending}"), np.ones((4, 4), bool)
    kept = weakref.ref(mask)
    answers.keep(0, 0.0, Estimate(np.zeros(2), mask=mask))
    del mask
    assert kept() is None


def test_of_a_place_alone_mot_text_has_a_box_of_the_first_size(clip: Path, tmp_path: Path) -> None:
    place = Estimate(np.array([300.0, -20.0]))
    silent = Estimate(np.full(2, np.nan))
    run(clip, tmp_path / "o.mp4", lambda: Reddest(2, lambda: place), estimates=tmp_path / "e.txt")
    np.testing.assert_allclose(read_mot(tmp_path / "e.txt").box_xyxy[2], [292, -28, 308, -12])
    run(clip, tmp_path / "o.mp4", lambda: Reddest(2, lambda: silent), estimates=tmp_path / "e.txt")
    assert 3 not in read_mot(tmp_path / "e.txt").frame


def test_all_tracks_of_a_tracker_of_many_are_kept_and_drawn(clip: Path, tmp_path: Path) -> None:
    shown: list[NDArray[np.uint8]] = []
    made = run(clip, tmp_path / "o.mp4", TwoOfThem, box=None, estimates=tmp_path / "e.csv", show=keep_in(shown))
    assert made == Made(FRAMES)
    table = pd.read_csv(tmp_path / "e.csv")
    assert table["identity"].tolist() == [4, 7] * FRAMES
    assert set(table["confidence"]) == {0.5}
    run(clip, tmp_path / "p.mp4", lambda: Silent(), box=None, show=keep_in(bare := []))
    differs = np.argwhere((shown[0] != bare[0])[:-CAPTION_PX].any(axis=2))
    zoom = shown[0].shape[1] / (160 * 1.5)
    for x in (30.0, 90.0):
        centre = zoom * np.array([50.0 + 30.0, x + 40.0])
        assert np.abs(differs - centre).max(axis=1).min() < 6


class Silent(TwoOfThem):
    def update(self, observation: Observation) -> list[Track]:
        return []


def keep_in(shown: list[NDArray[np.uint8]]) -> Callable[[NDArray[np.uint8]], bool]:
    return lambda image_rgb: not shown.append(image_rgb)


def sleep() -> None:
    time.sleep(30)


def fail() -> None:
    raise RuntimeError("no more")


@pytest.mark.parametrize(
    ("otherwise", "reason"),
    [
        (fail, "RuntimeError: no more"),
        (lambda: Estimate(np.zeros(3)), "ValueError: position_px"),
        (lambda: "nonsense", "ValueError: update: expected an Estimate"),
        (sleep, "took longer than 1 s"),
    ],
)
def test_a_tracker_that_fails_ends_it_and_what_was_made_stays(
    clip: Path, tmp_path: Path, otherwise: Callable[[], Any], reason: str
) -> None:
    made = run(clip, tmp_path / "o.mp4", lambda: Reddest(4, otherwise), estimates=tmp_path / "e.csv", limit_s=0.1)
    assert made.frames == 5
    assert not made.stopped
    assert made.failure.startswith(f"fake failed on frame 4 of clip.mkv: {reason}"), made.failure
    assert len(decode(tmp_path / "o.mp4")[0]) == 5
    assert np.isfinite(pd.read_csv(tmp_path / "e.csv")["x_px"]).tolist() == [True] * 4 + [False]


def test_ctrl_c_ends_it_and_what_was_made_stays(clip: Path, tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGINT)
    interrupt: Callable[[], None] = lambda: signal.raise_signal(signal.SIGINT)  # noqa: E731
    made = run(clip, tmp_path / "o.mp4", lambda: Reddest(4, interrupt), estimates=tmp_path / "e.csv")
    assert made == Made(4, stopped=True)
    assert len(decode(tmp_path / "o.mp4")[0]) == 4
    assert len(pd.read_csv(tmp_path / "e.csv")) == 4
    assert signal.getsignal(signal.SIGINT) is before


def test_a_tracker_that_cannot_be_made_leaves_no_video(clip: Path, tmp_path: Path) -> None:
    made = run(clip, tmp_path / "o.mp4", fail, estimates=tmp_path / "e.csv")
    assert (made.frames, made.stopped) == (0, False)
    assert made.failure.startswith("fake failed on frame 0 of clip.mkv: RuntimeError: no more")
    assert [each.name for each in tmp_path.iterdir()] == ["clip.mkv"]


def test_ctrl_c_before_the_first_answer_leaves_no_video(clip: Path, tmp_path: Path) -> None:
    class Interrupted(Reddest):
        def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
            signal.raise_signal(signal.SIGINT)

    assert run(clip, tmp_path / "o.mp4", Interrupted) == Made(0, stopped=True)
    assert [each.name for each in tmp_path.iterdir()] == ["clip.mkv"]


def test_ctrl_c_while_a_picture_is_drawn_lets_it_be_written(clip: Path, tmp_path: Path) -> None:
    def show(image_rgb: NDArray[np.uint8]) -> bool:
        signal.raise_signal(signal.SIGINT)
        return True

    assert run(clip, tmp_path / "o.mp4", show=show) == Made(1, stopped=True)
    assert len(decode(tmp_path / "o.mp4")[0]) == 1


def test_a_second_ctrl_c_leaves_nothing_half_written(clip: Path, tmp_path: Path) -> None:
    def show(image_rgb: NDArray[np.uint8]) -> bool:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        return True

    with pytest.raises(KeyboardInterrupt):
        run(clip, tmp_path / "o.mp4", show=show)
    assert [each.name for each in tmp_path.iterdir()] == ["clip.mkv"]


def test_a_window_that_is_closed_ends_it(clip: Path, tmp_path: Path) -> None:
    assert run(clip, tmp_path / "o.mp4", show=lambda image_rgb: False) == Made(1, stopped=True)


def test_a_full_disk_leaves_nothing_half_written(clip: Path, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="File too large"), no_room(2000):
        run(clip, tmp_path / "o.mp4")
    assert [each.name for each in tmp_path.iterdir()] == ["clip.mkv"]


def test_fewer_pictures_than_there_are(clip: Path, tmp_path: Path) -> None:
    assert run(clip, tmp_path / "o.mp4", frames=5) == Made(5)
    assert len(decode(tmp_path / "o.mp4")[0]) == 5


def test_an_episode_and_footage_of_its_pictures_have_the_same_overlay(tmp_path: Path) -> None:
    """Every pixel is equal, but for the truth, which footage does not have."""
    episode, count = FakeEpisode(), 20
    for k in range(count):
        cv2.imwrite(str(tmp_path / f"{k}.png"), episode.step().observation.image_rgb[..., ::-1])
    box, rate_hz = FakeEpisode().start.box_xyxy, episode.rate_hz
    instants = replay(live(FakeEpisode(), FakeTracker()), scale=1.0, wanted=range(count), frame_count=count)
    drawing = InLargerView()
    rendered = [drawing.picture(replace(each, targets=())) for each in surrounded(instants, rate_hz)]
    footage = open_footage(str(tmp_path), rate_hz)
    pictures = footage.pictures()
    spec = FootageSpec("fake", next(pictures), pictures, box, rate_hz, count)
    tracker = Fake(make=FakeTracker)
    shown: list[NDArray[np.uint8]] = []
    job = Job(suite_of(tracker, many=False), spec, {"fake": tracker}, repeats=1)
    track(job, Wanted(tmp_path / "o.mp4", scale=1.0, show=keep_in(shown)))
    assert len(shown) == len(rendered) == count
    for footage_picture, episode_picture in zip(shown, rendered, strict=True):
        np.testing.assert_array_equal(footage_picture[:-CAPTION_PX], episode_picture)
