"""Videos and the report's picture of a person followed: what is shown, in which words, without a larger view."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest

from benchmarks.run.selection import job_on
from benchmarks.show import pictures
from benchmarks.show.replay import replay
from benchmarks.show.showing import drawing_of
from benchmarks.show.suites.stereo import SHOWING, first_event
from benchmarks.show.video.drawing import InLargerView, Instant
from benchmarks.show.video.episode_video import render_episode, write_video
from benchmarks.show.video.stereo import StereoDrawing
from tests.benchmarks.fake_episode import FakeEpisode, live
from tests.benchmarks.judges.follow import fake_follow
from tests.benchmarks.judges.follow.fake_follow import HIDDEN, FakeFollow, FakeFollowEpisode, FollowKnowing
from tests.fakes_trackers import NoParameters
from trackers.types import Estimate


def episode() -> FakeFollowEpisode:
    return FakeFollowEpisode(FakeFollow("a fixed camera"), closed_loop=False)


def instant_at(frame: int, estimate: Estimate | None = None) -> Instant:
    fake = episode()
    for _ in range(frame + 1):
        last = fake.step()
    return Instant(last, (0,), estimate, last.observation.image_rgb)


def test_each_scenario_is_drawn_in_its_own_way():
    assert isinstance(drawing_of("stereo-follow-v2", episode()), StereoDrawing)
    assert isinstance(drawing_of("stereo-follow-v22", episode()), StereoDrawing)
    assert isinstance(drawing_of("road-town-v2", FakeEpisode()), InLargerView)
    assert isinstance(drawing_of("another-scenario-v1", FakeEpisode()), InLargerView)


def test_a_video_makes_no_larger_view(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def refuse(self: FakeFollowEpisode, scale: float) -> None:
        raise AssertionError("a larger view costs as much as a frame")

    monkeypatch.setattr(FakeFollowEpisode, "larger_view", refuse)
    fake = episode()
    drawing = StereoDrawing.of(fake)
    job = job_on("stereo", fake_follow.FAKE_FOLLOW.id, "tiny", 0)
    run = live(fake, FollowKnowing(NoParameters(), np.random.default_rng(0)), job=job)
    instants = replay(run, scale=1.0, wanted=range(4), frame_count=4)
    write_video(tmp_path / "x.mp4", instants, drawing, rate_hz=15.0, title="fake", frame_count=4)
    with av.open(str(tmp_path / "x.mp4")) as video:
        shapes = [frame.to_ndarray(format="rgb24").shape for frame in video.decode(video=0)]
    assert shapes == [(596, 1280, 3)] * 4


@pytest.mark.heavy
def test_what_is_rendered_is_what_the_command_asks_for(tmp_path: Path):
    job = job_on("stereo", "stereo-follow-v2", "quick", 0, ("stereo_wb",))
    shown: list[tuple[int, ...]] = []
    assert render_episode(job, tmp_path / "x.mp4", frames=2, progress=lambda *counts: shown.append(counts)) == []
    assert shown == [(0, 2), (1, 2), (2, 2)]
    with av.open(str(tmp_path / "x.mp4")) as video:
        assert len(list(video.decode(video=0))) == 2


def test_words_and_shades_tell_of_hiding_and_of_light():
    drawing = StereoDrawing.of(episode())
    calm, hidden, dark = (instant_at(frame) for frame in (5, HIDDEN[2], 30))
    assert drawing.describe(calm) == "100% seen"
    assert drawing.describe(hidden) == "0% seen, behind crosser"
    assert drawing.describe(dark) == "100% seen, lamp off"
    outside = replace(calm, frame=replace(calm.frame, truth=replace(calm.frame.truth, state=np.full(3, "out"))))
    assert drawing.describe(outside) == "out of view"
    plain = drawing.shades(calm)
    assert plain[0] == plain[1]
    assert drawing.shades(hidden)[0] == plain[0] != drawing.shades(hidden)[1]
    assert drawing.shades(dark)[1] == plain[1] != drawing.shades(dark)[0]


def test_truth_and_estimate_are_drawn_in_the_left_picture_and_from_above():
    drawing = StereoDrawing.of(episode())
    alone = instant_at(5)
    target_px = alone.frame.truth.position_px[0]
    answer = Estimate(target_px + np.array([12.0, 0.0]), in_view_probability=1.0, depth_m=5.0)
    without, drawn = (drawing.picture(replace(alone, answer=each)) for each in (None, answer))
    changed = np.argwhere(np.abs(drawn.astype(int) - without).sum(axis=2) > 0)
    left = changed[changed[:, 1] < 640]
    np.testing.assert_allclose(left.mean(axis=0)[::-1], 4 * answer.position_px, atol=4)
    assert (changed[:, 1] >= 640).any()
    silent = replace(alone, answer=Estimate(np.full(2, np.nan)))
    assert np.array_equal(drawing.picture(silent), without)


def event(kind: str, first: int, length: int, back: int | None, index: int = 0) -> dict[str, object]:
    return {
        "index": index,
        "kind": kind,
        "first_frame": first,
        "length_frames": length,
        "back_frame": back,
        "place": "hall",
        "light": kind == "lamp off",
    }


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ([], None),
        ([(3, "near person", 1, 9, None)], None),
        ([(3, "lamp off", 20, 30, None), (2, "lamp off", 30, 30, None)], (2, [29, 40, 49, 59])),
        ([(1, "lamp off", 30, 30, None), (2, "occlusion", 20, 6, 28)], (2, [19, 22, 28, 38])),
        ([(1, "occlusion", 2, 2, 9), (2, "occlusion", 9, 6, None), (5, "occlusion", 44, 3, 47)], (5, [43, 45, 47, 57])),
    ],
)
def test_the_event_to_look_at_is_found_by_a_rule(rows, found):
    made = [
        {
            "seed": seed,
            "metric": "recovered" if kind == "occlusion" else "event_right_frames",
            "event": event(kind, *at),
        }
        for seed, kind, *at in rows
    ]
    chosen = first_event(made)
    assert (None if chosen is None else chosen[:2]) == found


def test_the_picture_is_made_once_for_the_rows_that_this_code_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    drawn = []
    monkeypatch.setattr(pictures, "is_of_present_editions", lambda row, episode: row["editions"] == "now")
    cell = ("words", np.zeros((24, 64, 3), np.uint8))
    monkeypatch.setattr(pictures, "drawn_cells", lambda *about, **how: drawn.append(about) or [[cell]])
    assert SHOWING.event_picture is not None
    condition = ("stereo", "stereo-follow-v2", "quick", "raster", "")
    heading = dict(zip(("suite", "scenario", "preset", "renderer"), condition, strict=False)) | {"controller": None}
    told = {"seed": 4, "metric": "recovered", "event": event("occlusion", 20, 6, 28), "editions": "now"}
    rows = {name: [{**heading, "tracker": name, **told}] for name in ("stereo_people", "stereo_wb")}
    for _ in range(2):
        pictures.keep_event_picture(tmp_path, condition, rows, tuple(rows), SHOWING.event_picture)
    ((job, _, frames, *_),) = drawn
    assert (job.episode.preset, job.episode.seed, list(job.trackers)) == ("quick", 4, list(rows))
    assert frames == [19, 22, 28, 38]
    (words,) = (tmp_path / "pictures").glob("*.json")
    assert json.loads(words.read_text())["title"] == "One occlusion"
    rows["stereo_wb"][0]["editions"] = "of old"
    pictures.keep_event_picture(tmp_path, condition, rows, tuple(rows), SHOWING.event_picture)
    assert list((tmp_path / "pictures").iterdir()) == []
