from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.contract.suite import suite
from benchmarks.run.selection import choices
from tests.fakes import DrawnTown, drive, look_down, straight_road
from trackers.baselines import opencv_contrib
from trackers.baselines.single_target import visible_part
from trackers.clients.environments import environment_of, needs
from trackers.clients.portable import frameout_client
from trackers.registry import entry
from trackers.types import CameraModel, Observation


def picture(k: int = 0, width: int = 64, height: int = 48) -> Observation:
    image = np.random.default_rng(k).integers(0, 256, (height, width, 3)).astype(np.uint8)
    return Observation(image, k / 15, CameraModel(width, height, 50.0))


@pytest.fixture
def adapter(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the adapter's class with a tracker that moves by 3 pixels, except on the second picture."""
    seen: list[Any] = []

    class Fake:
        def init(self, bgr: Any, box: tuple[int, ...]) -> None:
            seen[:] = [(bgr, box)]

        def update(self, bgr: Any) -> tuple[bool, tuple[float, ...]]:
            x, y, width, height = seen[0][1]
            seen.append((bgr, None))
            return len(seen) != 3, (x + 3 * (len(seen) - 1), y, width, height)

    fake = SimpleNamespace(TrackerFAKE_create=Fake, setNumThreads=lambda count: None, __version__="5.0")
    monkeypatch.setitem(sys.modules, "cv2", fake)
    monkeypatch.setitem(sys.modules, "frameout_client", frameout_client)
    program = runpy.run_path(str(opencv_contrib.ADAPTER))
    program["OpenCvTracker"].update.__globals__["new_tracker"] = program["_of"]("FAKE")
    return SimpleNamespace(**program, seen=seen)


def test_boxes_come_back_and_a_failure_keeps_the_last(adapter: Any) -> None:
    tracker = adapter.OpenCvTracker(None, None)
    tracker.initialise(picture(), np.array([10.0, 8.0, 22.0, 20.0]))
    first, second, third = (tracker.update(picture(k)) for k in (1, 2, 3))
    np.testing.assert_array_equal(first.box_xyxy, [13.0, 8.0, 25.0, 20.0])
    np.testing.assert_array_equal(second.box_xyxy, first.box_xyxy)
    np.testing.assert_array_equal(third.position_px, [25.0, 14.0])
    assert [each.in_view_probability for each in (first, second, third)] == [1.0, 0.0, 1.0]
    np.testing.assert_array_equal(adapter.seen[1][0], picture(1).image_rgb[..., ::-1])


@pytest.mark.parametrize("box", [[-4.0, -3.0, 9.2, 8.7], [60.1, 40.0, 90.0, 90.0], [70.0, -9.0, 80.0, -2.0]])
def test_it_starts_on_the_visible_part_of_a_box(box: list[float], adapter: Any) -> None:
    adapter.OpenCvTracker(None, None).initialise(picture(), np.array(box))
    x0, y0, x1, y1 = visible_part(np.array(box), picture().camera)
    assert adapter.seen[0][1] == (x0, y0, x1 - x0, y1 - y0)


def test_a_tiny_picture_has_no_answer(adapter: Any) -> None:
    tracker = adapter.OpenCvTracker(None, None)
    tracker.initialise(picture(0, 9, 7), np.array([1.0, 1.0, 5.0, 5.0]))
    assert np.isnan(tracker.update(picture(1, 9, 7)).position_px).all()


def test_an_unknown_tracker_is_one_line(adapter: Any) -> None:
    with pytest.raises(SystemExit, match=r"expected the name of a tracker of OpenCV 5\.0, .* got 'NIX'"):
        adapter._of("NIX")


def test_the_wheels_that_are_asked_for_are_the_tested_versions() -> None:
    tested = (Path(__file__).parents[3] / "constraints.txt").read_text().split()
    opencv, numpy = needs(opencv_contrib.ADAPTER)
    assert opencv.replace("-contrib", "") in tested
    assert numpy in tested
    assert len(opencv_contrib.ADAPTER.read_text().splitlines()) < 80


def test_default_runs_take_it_where_its_environment_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    frame_out = suite("frame-out")
    [choice] = choices(frame_out, variants=False)
    assert "opencv_csrt" not in choice.trackers
    wanted = r"opencv_csrt: expected its environment; make it by: python -m trackers\.clients opencv_contrib\.py"
    with pytest.raises(RuntimeError, match=wanted):
        entry("opencv_csrt").create(np.random.default_rng(0))
    python = environment_of(opencv_contrib.ADAPTER)
    python.parent.mkdir(parents=True)
    python.touch()
    [choice] = choices(frame_out, variants=False)
    assert "opencv_csrt" in choice.trackers


@pytest.mark.skipif(opencv_contrib.missing_contrib() != "", reason="no environment of opencv-contrib-python-headless")
def test_opencv_csrt_follows_a_drawn_car_and_answers_alike_twice() -> None:
    road = straight_road()
    town = DrawnTown(road, 160.0, np.random.default_rng(0))
    frames = list(drive(town, road, 110.0, 0.4, [look_down(0, 0, 60.0, 0.0)] * 15))
    runs = []
    for _ in range(2):
        tracker = entry("opencv_csrt").create(np.random.default_rng(0))
        tracker.initialise(frames[0].observation, frames[0].box_xyxy)
        runs.append([tracker.update(frame.observation).position_px for frame in frames[1:]])
    np.testing.assert_array_equal(*runs)
    assert np.hypot(*(runs[0][-1] - frames[-1].position_px)) < 24
    assert tracker.elsewhere_cpu_s > 0.0
