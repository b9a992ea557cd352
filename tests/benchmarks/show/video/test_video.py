"""Videos: what is drawn lies where it should, files are whole, equal for equal input, and have even sizes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.show.replay import replay
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Canvas, InLargerView, Instant, OfFootage, draw_mask
from benchmarks.show.video.episode_video import Caption, write_mp4, write_video
from tests.benchmarks.fake_episode import HEIGHT, WIDTH, FakeEpisode, FakeTracker, live
from trackers.types import CameraCommand, Estimate, Observation


def decode(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as video:
        return [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def write_fake(out: Path, frame_count: int) -> None:
    episode = FakeEpisode()
    instants = replay(live(episode, FakeTracker()), scale=2.0, wanted=range(frame_count), frame_count=frame_count)
    write_video(out, instants, InLargerView(), rate_hz=episode.rate_hz, title="fake", frame_count=frame_count)


def instant_at(frame: int, estimate: Estimate | None = None) -> Instant:
    episode = FakeEpisode()
    for _ in range(frame + 1):
        last = episode.step()
    return Instant(last, (0,), estimate, episode.larger_view(2.0))


def test_a_video_shows_every_frame_and_its_caption(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "x.mp4"
    write_fake(out, 12)
    pictures = decode(out)
    assert len(pictures) == 12
    assert pictures[0].shape[1] >= 960
    assert list(out.parent.iterdir()) == [out]


def words_of(monkeypatch: pytest.MonkeyPatch, *instants: Instant) -> list[str]:
    """Return all words of the captions of instants."""
    told: list[str] = []
    monkeypatch.setattr(marks, "draw_text", lambda image, place, text, *rest, **style: told.append(text) or 0)
    for instant in instants:
        Caption(InLargerView(), "fake", 3).below(np.zeros((1, 960, 3), np.uint8), instant)
    return told


def test_a_caption_says_that_there_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = ((np.full(2, np.nan), None), (np.full(2, np.nan), 0.0), (np.array([9.0, 9.0]), 0.25))
    instants = (instant_at(1, Estimate(position_px=place, in_view_probability=share)) for place, share in answers)
    told = words_of(monkeypatch, *instants)
    assert [text for text in told if "tracker:" in text] == ["tracker: no answer"] * 2 + ["tracker: 25% in view"]


def test_a_legend_has_the_view_of_a_steered_camera_where_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    instant = instant_at(1)
    frame = instant.frame
    steered = replace(frame, steered=frame.truth)
    for each, told in ((frame, 0), (steered, 1)):
        assert words_of(monkeypatch, replace(instant, frame=each)).count("2nd camera") == told


def test_a_legend_has_what_a_tracker_has_given_so_far_and_no_entry_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    inside, outside = np.array([9.0, 9.0]), np.array([-9.0, 9.0])
    estimates = (
        Estimate(inside),
        Estimate(inside, covariance_px=np.full((2, 2), np.nan)),
        Estimate(outside),
        Estimate(inside, covariance_px=np.eye(2)),
        Estimate(inside),
    )
    told: list[tuple[str, float]] = []
    monkeypatch.setattr(
        marks, "draw_text", lambda image, at, text, *rest, **style: told.append((text, at)) or at[0] + 9 * len(text)
    )
    caption = Caption(OfFootage(), "fake", 5)
    legends = []
    for estimate in estimates:
        told.clear()
        caption.below(np.zeros((1, 960, 3), np.uint8), instant_at(1, estimate))
        legends.append([entry for entry in told if entry[1][1] == 58])
    for before, now in pairwise(legends):
        assert now[: len(before)] == before
    first = ["the picture", "estimate, its path, probability of being in view"]
    later = ["estimate outside it", "particles or 95 % ellipse"]
    assert [[text for text, _ in legend] for legend in legends] == [
        first,
        first,
        first + later[:1],
        first + later,
        first + later,
    ]


def test_the_same_pictures_make_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.mp4", "b.mp4"):
        write_fake(tmp_path / name, 5)
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_a_rate_of_hours_makes_a_video_too(tmp_path: Path) -> None:
    pictures = [(np.full((16, 16, 3), 90, np.uint8), 2500.0 * k) for k in range(2)]
    write_mp4(tmp_path / "slow.mp4", pictures, 0.0004)
    with av.open(str(tmp_path / "slow.mp4")) as video:
        assert len(list(video.decode(video=0))) == 2


@settings(max_examples=8, deadline=None)
@given(height=st.integers(16, 51), width=st.integers(16, 51))
def test_odd_sizes_are_cut_to_even_ones(tmp_path_factory: pytest.TempPathFactory, height: int, width: int) -> None:
    out = tmp_path_factory.mktemp("odd") / "x.mp4"
    write_mp4(out, [(np.full((height, width, 3), (10, 200, 90), dtype=np.uint8), 0.0)], 15.0)
    (picture,) = decode(out)
    assert picture.shape == (height // 2 * 2, width // 2 * 2, 3)
    assert np.abs(picture.astype(int) - (10, 200, 90)).max() < 8


def test_a_video_cut_short_leaves_nothing(tmp_path: Path) -> None:
    def one_and_stop() -> Iterator[tuple[np.ndarray, float]]:
        yield np.zeros((32, 32, 3), dtype=np.uint8), 0.0
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_mp4(tmp_path / "x.mp4", one_and_stop(), 15.0)
    assert list(tmp_path.iterdir()) == []


@settings(max_examples=25, deadline=None)
@given(x=st.floats(-70, WIDTH + 70), y=st.floats(-50, HEIGHT + 50))
def test_the_estimate_is_drawn_where_it_is_said_to_be(x: float, y: float) -> None:
    """The mean position of the pixels that the cross changes is the estimate, inside the picture or not."""
    silent = instant_at(3, Estimate(np.array([np.nan, np.nan])))
    said = replace(silent, answer=Estimate(np.array([x, y])))
    with_cross, without = InLargerView().picture(said).astype(float), InLargerView().picture(silent).astype(float)
    changed = np.argwhere(np.abs(with_cross - without).sum(axis=2) > 0)
    middle = 0.5 * (changed.min(axis=0) + changed.max(axis=0)) + 0.5
    zoom = with_cross.shape[1] / (2 * WIDTH)
    expected = zoom * np.array([y + 0.5 * HEIGHT, x + 0.5 * WIDTH])
    np.testing.assert_allclose(middle, expected, atol=1.6)


@pytest.mark.parametrize("zoom", [1, 3])
def test_a_mask_is_tinted_where_it_is(zoom: int) -> None:
    canvas = Canvas.of(np.full((20, 30, 3), 200, np.uint8), 30 * zoom)
    mask = np.zeros((20, 30), bool)
    mask[4:9, 11:17] = True
    draw_mask(canvas, mask, (0, 100, 200))
    changed = (canvas.image != 200).any(axis=2)
    np.testing.assert_array_equal(changed, np.kron(mask, np.ones((zoom, zoom), bool)))
    assert canvas.image[5 * zoom, 12 * zoom].tolist() == [110, 155, 200]


def test_truth_is_outlined_outside_the_picture_too() -> None:
    instant = instant_at(19)
    truth = instant.frame.truth
    assert truth.state.tolist() == ["out"]
    image = InLargerView().picture(instant)
    zoom = image.shape[1] // (2 * WIDTH)
    x0, y0, x1, y1 = ((truth.box_xyxy[0] + np.tile([WIDTH / 2, HEIGHT / 2], 2)) * zoom).astype(int)
    for row, column in ((y0, (x0 + x1) // 2), ((y0 + y1) // 2, x1)):
        nearby = image[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3).astype(int)
        assert np.abs(nearby - marks.TRUTH).sum(axis=1).min() < 12


def test_what_lies_beyond_the_larger_view_is_pointed_at() -> None:
    far = Estimate(np.array([5000.0, 60.0]))
    with_arrow = InLargerView().picture(instant_at(3, far)).astype(int)
    without = InLargerView().picture(instant_at(3)).astype(int)
    rows, columns = np.nonzero(np.abs(with_arrow - without).sum(axis=2))
    assert columns.min() > 0.95 * with_arrow.shape[1]
    assert abs(rows.mean() - 0.5 * with_arrow.shape[0]) < 3


def test_a_silent_tracker_and_odd_posteriors_are_drawn_without_error() -> None:
    position = np.array([40.0, 50.0])
    estimates = [
        Estimate(np.array([np.nan, np.nan]), box_xyxy=np.full(4, np.nan)),
        Estimate(np.array([np.nan, np.nan]), covariance_px=np.eye(2)),
        Estimate(position, particles_px=np.full((3, 2), np.nan), weights=np.array([1.0, 0, 0])),
        Estimate(position, particles_px=position[None]),
        Estimate(position, covariance_px=np.zeros((2, 2))),
        Estimate(position, covariance_px=np.full((2, 2), np.inf)),
        Estimate(np.array([1e9, -1e12]), particles_px=np.full((2, 2), 1e12)),
    ]
    for estimate in estimates:
        assert InLargerView().picture(instant_at(2, estimate)).dtype == np.uint8


def test_the_state_is_put_in_words() -> None:
    assert InLargerView().describe(instant_at(0)) == "in view"
    assert InLargerView().describe(instant_at(13)) == "cut by the border"
    assert InLargerView().describe(instant_at(16)) == "out of view for 2 frames, over the right edge"


def test_replay_steers_by_the_estimate_and_shows_only_what_is_wanted() -> None:
    class Pilot:
        def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
            return CameraCommand(right_mps=float(estimate.position_px[0]))

    episode = FakeEpisode()
    shown = list(replay(live(episode, FakeTracker(), Pilot()), scale=2.0, wanted=(0, 4), frame_count=6))
    assert [instant.frame.truth.frame for instant in shown] == [0, 4]
    assert episode.commands[0] is None
    steered = [command.right_mps for command in episode.commands[1:] if command is not None]
    np.testing.assert_allclose(steered, 50.0 + 7.7 * np.arange(5))


@pytest.mark.parametrize("ground", [(253, 231, 37), (255, 255, 255), (0, 0, 0)])
def test_a_label_is_readable_on_any_ground(ground: marks.Rgb) -> None:
    """WCAG 2's contrast ratio of letters and the patch behind them is at least 4.5."""

    def luminance(rgb: np.ndarray) -> float:
        level = rgb / 255.0
        linear = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055) ** 2.4)
        return float(linear @ (0.2126, 0.7152, 0.0722))

    image = np.full((40, 200, 3), ground, dtype=np.uint8)
    marks.draw_label(image, (10, 25), "disparity", (236, 238, 242))
    patch = image[25 - 16, 8]
    assert (luminance(np.array([236, 238, 242])) + 0.05) / (luminance(patch) + 0.05) >= 4.5
    assert (image[:, 150:] == ground).all()
    untouched = image.copy()
    marks.draw_label(image, (-500, -500), "far outside", (236, 238, 242))
    assert (image == untouched).all()
