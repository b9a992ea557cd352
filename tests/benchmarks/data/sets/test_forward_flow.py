"""Forward flow against the kernel of the backward flow, which is told the two instants the other way round."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.data.sets.forward_flow import forward_flow
from scenarios.scenario import Frame
from sim.labels import backward_flow
from tests.benchmarks.data.exports.painted_scene import IDS, truth_at
from tests.benchmarks.data.exports.painted_scene import PAINTED as SCENE
from trackers.types import CameraModel, Observation

CAMERA = CameraModel(40, 32, 50.0)


class Seen(NamedTuple):
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]


def pose(rng: np.random.Generator, far_m: float = 0.0) -> NDArray[np.float64]:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(rng.normal(0, 0.02, 3)).as_matrix()
    T[:3, 3] = rng.normal((0.0, 0.0, far_m), 0.1)
    return T


class Pair:
    """Two frames with their own poses, as an episode that is read."""

    def __init__(self, seed: int, **changes: Any) -> None:
        rng, self.frames = np.random.default_rng(seed), []
        for frame in (4, 5):
            truth = truth_at(SCENE.presets["quick"], frame, 7.5)
            depth_m = (truth.depth_m * rng.uniform(0.9, 1.1, truth.depth_m.shape)).astype(np.float32)
            poses = np.array([pose(rng, 6.0) for _ in IDS])
            moved = replace(truth, T_world_camera=pose(rng), T_world_object=poses, depth_m=depth_m, **changes)
            self.frames.append(Frame(Observation(np.empty((0, 0, 3), np.uint8), frame / 7.5, CAMERA), moved))

    def frame(self, index: int, channels: tuple[str, ...]) -> Frame:
        assert channels == ("depth_m", "instance_map")
        return self.frames[index]


@pytest.mark.parametrize("seed", range(4))
def test_it_is_the_flow_to_the_other_instant(seed: int) -> None:
    pair = Pair(seed)
    now, after = (frame.truth for frame in pair.frames)
    bodies, bodies_after = np.tile(np.eye(4), (2, IDS.max() + 1, 1, 1))
    bodies[IDS], bodies_after[IDS] = now.T_world_object, after.T_world_object
    expected = backward_flow(
        Seen(now.depth_m, now.instance_map),
        CAMERA,
        now.T_world_camera,
        after.T_world_camera,
        bodies,
        bodies_after,
    )
    found = forward_flow(pair, 0)  # type: ignore[arg-type]
    np.testing.assert_array_equal(np.isnan(found.flow_px[..., 0]), np.isinf(now.depth_m))
    np.testing.assert_allclose(found.flow_px, expected, atol=2e-3)


def test_who_passes_by_has_none_and_what_is_parked_has(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Pair(0)
    truth = truth_at(SCENE.presets["parked"], 4, 7.5)
    pair.frames = [replace(frame, truth=replace(truth, frame=4 + k)) for k, frame in enumerate(pair.frames)]
    van = truth.instance_map == truth.standing_id[0]
    flow_px, seen_next = forward_flow(pair, 0)  # type: ignore[arg-type]
    np.testing.assert_allclose(flow_px[van], 0.0, atol=1e-4)
    assert seen_next[van].all()
    assert van.any()
    monkeypatch.setattr(type(truth), "passing", ("van",))
    passing_px, seen_next = forward_flow(pair, 0)  # type: ignore[arg-type]
    assert np.isnan(passing_px[van]).all()
    assert not seen_next[van].any()
    np.testing.assert_array_equal(passing_px[~van], flow_px[~van])


@pytest.mark.parametrize("first", [0, 1, 5])
def test_what_is_hidden_outside_or_absent_next_is_not_seen_then(first: int) -> None:
    """The car moves 6 px to the right in the pictures, and the flow says so: before the ground, then partly behind a
    bus, then partly out of the picture.
    """
    pair = Pair(0)
    for k, frame in enumerate(pair.frames):
        truth = truth_at(SCENE.presets["quick"], first + k, 7.5)
        poses = np.tile(np.eye(4), (3, 1, 1))
        poses[1, 0, 3] = k * 6.0 * 8.0 / 50.0
        pair.frames[k] = replace(frame, truth=replace(truth, T_world_object=poses))
    now, after = (frame.truth for frame in pair.frames)
    flow_px, seen_next = forward_flow(pair, 0)  # type: ignore[arg-type]
    car = now.instance_map == IDS[1]
    assert car.any()
    np.testing.assert_allclose(flow_px[car], np.broadcast_to((6.0, 0.0), (car.sum(), 2)), atol=1e-4)
    np.testing.assert_allclose(flow_px[~car & np.isfinite(now.depth_m)], 0.0, atol=1e-4)
    for y, x in zip(*np.nonzero(car), strict=True):
        assert seen_next[y, x] == (x + 6 < 40 and after.instance_map[y, min(x + 6, 39)] == IDS[1])
    assert seen_next[car].all() == (first == 0)
    behind = ~car & (after.instance_map == IDS[1]) & (now.instance_map == -1)
    assert behind.any() == (first == 0)
    assert not seen_next[behind].any()
    gone = replace(pair.frames[1].truth, state=np.array(["in", "absent", "in"]))
    pair.frames[1] = replace(pair.frames[1], truth=gone)
    assert np.isnan(forward_flow(pair, 0).flow_px[car]).all()  # type: ignore[arg-type]
