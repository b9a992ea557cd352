"""The controller ``omniscient`` of the suite ``follow``: it knows the target's path and all that moves the camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios import catalog
from scenarios.command_link import CommandLink, Link, episode_link
from sim.checks import check
from trackers.types import CameraCommand, Estimate, Observation

if TYPE_CHECKING:
    from benchmarks.judges.follow.planning import Planner
    from scenarios.stage import Stage


@dataclass(frozen=True)
class OmniscientParameters:
    """Settings of the search for the best commands.

    Attributes:
        horizon_frames: number of frames that are planned.
        plans: number of plans that are tried in each round. rounds: number of rounds.
        best: share of the plans whose mean the next round begins with.
        spread: standard deviation of the first round's plans, as a share of a command's limit.
    """

    horizon_frames: int = 30
    plans: int = 96
    rounds: int = 2
    best: float = 0.125
    spread: float = 0.3


class OmniscientController:
    """Plans with the episode's own dynamics by the cross-entropy method, and replans on every picture.

    It moves a twin of the carrier in the world without pictures, whose paths are those of the rendered one, and never
    looks at an estimate. A plan is worth the env's reward without ``loss``, and the time for which the target is seen,
    so that it looks round those who hide it; less a cost of a target outside the picture, and of one far ahead, that
    grows with its distance. The best plan of a picture is the first guess on the next one (Kobilarov, Cross-entropy
    motion planning, 2012).
    """

    Parameters = OmniscientParameters

    def __init__(self, parameters: OmniscientParameters) -> None:
        self.parameters = parameters
        self._planner: Planner | None = None

    def foresee(self, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """Take the episode that is to be steered. Raises ValueError for a scenario without such a world."""
        # It imports kernels, which takes seconds.
        from benchmarks.judges.follow.planning import Planner

        self._planner = Planner(self.parameters, scenario, configuration, seed, link)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the first command of the best plan."""
        check("controller", self._planner is not None, "an episode that it knows, in suite follow", "none")
        assert self._planner is not None
        return CameraCommand(**dict(zip(self._planner.commands, self._planner.command().tolist(), strict=True)))


@dataclass(frozen=True)
class OmniscientHeadParameters:
    """Settings.

    Attributes:
        view: wanted width of the view at the target's place, as a share of the widest one that counts as in view.
    """

    view: float = 0.8


class OmniscientHead:
    """Points a pan-tilt-zoom head at where the target will be on the next picture, as closely as the head can.

    A head is so much faster than what it follows that no plan is needed. It moves a twin of the episode that takes no
    pictures, and never looks at an estimate; a target that is hidden it waits for where it will appear.
    """

    Parameters = OmniscientHeadParameters

    def __init__(self, parameters: OmniscientHeadParameters) -> None:
        self.parameters = parameters
        self._twin: Stage | None = None

    def foresee(self, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """Take the episode that is to be steered. Raises ValueError for a scenario in which any view counts."""
        followed = catalog.scenario(scenario)
        wide = followed.widest_view_m
        check("scenario", np.isfinite(wide), "one whose tracker looks through a head that is steered", scenario)
        self._twin = followed.episode(configuration, seed, closed_loop=True, truth="target")
        rate_hz = self._twin.rate_hz
        # The twin is ahead by the link's delay.
        self._link: CommandLink = episode_link(followed.carrier, rate_hz, replace(link, delay_frames=0), seed)
        self._frame, self._view_m = 1 + link.delay_frames, self.parameters.view * wide
        for _ in range(link.delay_frames):
            # Noise turns the head before the first command arrives.
            self._twin.turn(self._link.send(CameraCommand()))

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command after which the target is in the middle."""
        check("controller", self._twin is not None, "an episode that it knows, in suite follow", "none")
        twin = self._twin
        assert twin is not None
        camera, rate_hz = twin.camera, twin.rate_hz
        place_px, distance_m = twin.target_ahead(self._frame)
        self._frame += 1
        command = CameraCommand()
        if np.isfinite(place_px).all() and distance_m > 0.0:
            right, down = np.arctan((place_px - camera.centre_px) / camera.focal_px)
            closer = np.log(distance_m * camera.width_px / (self._view_m * camera.focal_px))
            command = CameraCommand(
                pan_rad_s=-float(right) * rate_hz, tilt_rad_s=-float(down) * rate_hz, zoom_per_s=float(closer) * rate_hz
            )
        twin.turn(self._link.send(command))
        return command
