"""Recorded runs of the rendered envs: truth and the tracker's estimate, frame by frame."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import controllers_suite
from benchmarks.run.contestants import entrant
from benchmarks.run.editions import editions_of
from scenarios import catalog
from scenarios.envs.follow_env import followed_episode
from scenarios.envs.settings import FollowSettings
from scenarios.loop import Loop
from scenarios.visibility import is_in_view
from sim.checks import check
from sim.rng import generator
from trackers.atomic_file import atomic_file
from trackers.belief.kernel import SIGHTING
from trackers.belief.sighting import sighting_of
from trackers.controllers.catalogue import controller_entry
from trackers.protocols import Controller
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_LATER = ("depth_m", "axis_depth_m")
"""Fields of a sighting that no run holds, so that runs recorded before stay readable."""
RECORDED = [name for name in SIGHTING.names or () if name not in _LATER]
"""Fields of a sighting that a run holds."""
RUN = np.dtype(
    [
        ("T_world_camera", "f8", (3, 4)),
        ("place_m", "f8", (2,)),
        ("heading_rad", "f8"),
        ("size_m", "f8", (3,)),
        # Of the target's centre, and the estimate; NaN behind the camera, and without an estimate.
        ("position_px", "f8", (2,)),
        ("estimate_px", "f8", (2,)),
        ("visible_fraction", "f8"),
        ("in_view", "?"),
        ("out", "?"),
        ("sighting", np.dtype([(name, SIGHTING[name]) for name in RECORDED], align=True)),
        # As obeyed: forward, right, climb, yaw rate.
        ("command", "f8", (4,)),
    ],
    align=True,
)
"""One frame."""
DISTURBED = "disturbed:"
_CALM_S, _DISTURBED_S = (2.0, 5.0), (1.0, 3.0)


class Disturbed:
    """Another controller, interrupted by random commands for a while, so that the target is lost."""

    def __init__(self, carrier: Carrier, controller: Controller, rng: np.random.Generator) -> None:
        self._carrier, self._controller, self._rng = carrier, controller, rng
        self._until_s = 0.0
        self._away: CameraCommand | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the controller's command, or the random one."""
        own = self._controller.command(observation, estimate)
        if observation.time_s >= self._until_s:
            calm = self._away is not None or self._until_s == 0.0
            self._until_s = observation.time_s + self._rng.uniform(*(_CALM_S if calm else _DISTURBED_S))
            away = {axis.name: axis.limit * float(self._rng.uniform(-1.0, 1.0)) for axis in self._carrier.axes}
            self._away = None if calm else CameraCommand(**away)
        return own if self._away is None else self._away


def run_of(settings: FollowSettings, seed: int, controller: str) -> NDArray[np.void]:
    """Run one episode; return its frames (T,) of dtype ``RUN``.

    Args:
        controller: name, with prefix ``DISTURBED`` for random interruptions.
    """
    carrier = catalog.scenario(settings.scenario).carrier
    name = controller.removeprefix(DISTURBED)
    own: Controller = controller_entry(name, carrier.name).create()
    if name != controller:
        own = Disturbed(carrier, own, generator(seed, "disturbance"))
    loop = followed_episode(settings, seed)
    target = catalog.scenario(settings.scenario).target
    frames = [_frame(carrier, target, loop) for _ in loop.frames(own)]
    loop.episode.close()
    return np.concatenate(frames)


def write_runs(
    settings: FollowSettings,
    seeds: range,
    controllers: list[str],
    folder: Path,
    report: Callable[[int, int], None] = lambda done, of: None,
) -> list[Path]:
    """Write a run of every seed, the controllers in turn, to ``folder``; runs of the same editions are reused.

    ``report`` is called with (runs done, all).
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for k, seed in enumerate(seeds):
        report(k, len(seeds))
        controller = controllers[k % len(controllers)]
        path = folder / f"{settings.scenario}-{settings.preset_name}-{seed}-{_file_name(settings, controller)}.npy"
        if not path.exists():
            run = run_of(settings, seed, controller)
            with atomic_file(path) as file:
                np.save(file, run, allow_pickle=False)
        paths.append(path)
    report(len(seeds), len(seeds))
    return paths


def read_run(path: Path) -> NDArray[np.void]:
    """Return the frames (T,) that ``write_runs`` wrote. Raises ValueError for another file."""
    run: NDArray[np.void] = np.load(path, allow_pickle=False)
    check("path", run.dtype == RUN, "a run written by write_runs", path)
    return run


def _file_name(settings: FollowSettings, controller: str) -> str:
    """Return a run's name: the controller, and a digest of all settings and editions."""
    carrier = catalog.scenario(settings.scenario).carrier
    steering = controller_entry(controller.removeprefix(DISTURBED), carrier.name)
    tracker = entrant(str(settings.tracker))
    judged = (controllers_suite().name, settings.scenario, settings.preset_name)
    made = editions_of(*judged, tracker, steering)
    digest = hashlib.sha256(f"{settings!r}/{made!r}".encode()).hexdigest()[:10]
    return f"{controller.replace(':', '-')}-{digest}"


def _frame(carrier: Carrier, target_name: str, loop: Loop) -> NDArray[np.void]:
    (truth, camera), estimate = loop.frame.judged, loop.estimate
    target, obeyed = truth.index_of(target_name), loop.obeyed or CameraCommand()
    row = np.zeros(1, RUN)
    values: dict[str, Any] = {
        "T_world_camera": truth.T_world_camera[:3],
        "place_m": truth.T_world_object[target, :2, 3],
        "heading_rad": np.arctan2(truth.T_world_object[target, 1, 0], truth.T_world_object[target, 0, 0]),
        "size_m": truth.size_m[target],
        "position_px": truth.position_px[target],
        "estimate_px": estimate.position_px,
        "visible_fraction": truth.visible_fraction[target],
        "in_view": is_in_view(truth, target, camera),
        "out": truth.state[target] == "out",
        "sighting": sighting_of(carrier.looks, loop.frame.observation, estimate)[RECORDED],
        "command": [obeyed.forward_mps, obeyed.right_mps, obeyed.climb_mps, obeyed.yaw_rate_rad_s],
    }
    for name, value in values.items():
        row[name][0] = value
    return row
