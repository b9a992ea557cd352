"""The contract of a scenario: what it offers by name, and how an episode of it is lived through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.truth import Truth, TruthExtent
from sim.optics import PinholeCamera
from trackers.types import CameraCommand, Carrier, Observation

RendererName = Literal["raster", "pybullet"]


@dataclass(frozen=True, slots=True)
class Frame:
    """One instant: what trackers are told, and what is so."""

    observation: Observation
    truth: Truth

    @property
    def camera(self) -> PinholeCamera:
        """The camera as all truth has it: without the lens's distortion, which is in the picture alone."""
        model = self.observation.camera
        return PinholeCamera(model.width_px, model.height_px, model.focal_px)


class Episode(Protocol):
    """One run through a scenario. Byte-identical for the same scenario, preset, seed and renderer.

    Attributes:
        frame_count: number of frames.
        rate_hz: frames a second.
        closed_loop: True if ``step`` needs a command, False if the camera flies a set path.
        target_box_xyxy: (4,) the target's box in the first frame, which a tracker is given.
    """

    frame_count: int
    rate_hz: float
    closed_loop: bool
    target_box_xyxy: NDArray[np.float64]

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame, frame 0 at first. ``command`` moves the camera in closed loop."""
        ...

    def map_of(self) -> Any:
        """Return the scenario's own map (road network …), for references with unfair knowledge."""
        ...

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant by the same camera with a picture ``scale`` times as wide and high.

        Its middle shows what is observed, up to noise: the papers' figures draw what lies around, too.
        """
        ...

    def close(self) -> None:
        """Free the world."""
        ...


@dataclass(frozen=True)
class TrackerRuns:
    """Of runs with pictures that a tracker's error model is fitted to.

    Attributes:
        controllers: those that steer, in turn: between them the target is seen, cut, hidden, lost for moments and lost
            for good.
        wrong_from_m: error from which a tracker is not on its target.
        jump_m: the tracker looks elsewhere where its error changes by more from frame to frame.
    """

    controllers: tuple[str, ...]
    wrong_from_m: float
    jump_m: float


class World(Protocol):
    """Moves episodes without pictures, B at a time: records ``lives`` (B,) of dtype ``life``.

    Attributes:
        life: ``scenarios.envs.pictureless.life.LIFE`` with fields of the carrier's own.
        camera: focal length, half width, half height (3,), pixels.
        interval_s: between frames.
    """

    life: np.dtype[Any]
    camera: NDArray[np.float64]
    interval_s: float

    def begin(
        self,
        lives: NDArray[np.void],
        which: NDArray[np.int64],
        episodes: NDArray[np.int64],
        at_frame_outs: bool,
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Begin episodes (K,) of the bank in the lives ``which`` (K,); write their first sightings."""
        ...

    def move(
        self,
        lives: NDArray[np.void],
        wanted: NDArray[np.float64],
        waiting: NDArray[np.float64],
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Move all on by a frame, by commands wanted (B, 4); ``waiting`` (B, D, 4) are those on their way."""
        ...


class Pictureless(Protocol):
    """How a scenario's episodes are played without pictures, see ``scenarios.envs.pictureless``.

    Attributes:
        version: of what ``arrays`` returns, to be counted up with every change of it.
        runs: what error models of trackers are fitted to.
    """

    @property
    def version(self) -> int: ...

    @property
    def runs(self) -> TrackerRuns: ...

    def is_playable(self, preset: Any) -> bool:
        """Return whether a configuration measures where its camera is, which there is no picture to tell."""
        ...

    def arrays(self, preset: Any, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return what is decided of an episode before its first frame, by name, of the same shapes for every seed."""
        ...

    def world(
        self, preset: Any, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> World:
        """Return what moves episodes: ``arrays`` of E of them, E first; ``errors`` as ``error_kernel`` reads them.

        Imports kernels, which takes seconds.
        """
        ...


class Scenario(Protocol):
    """A kind of world."""

    @property
    def id(self) -> str:
        """Catalogue id with its version, e.g. ``road-town-v1``."""
        ...

    @property
    def summary(self) -> str:
        """What it is, in one line."""
        ...

    @property
    def start(self) -> str:
        """What a tracker is given, in one line."""
        ...

    @property
    def carrier(self) -> Carrier:
        """What carries the camera: all that is needed to steer it, by a controller or in an env."""
        ...

    @property
    def pictureless(self) -> Pictureless | None:
        """How its episodes are played without pictures; None if they cannot be."""
        ...

    @property
    def presets(self) -> dict[str, Any]:
        """Name -> the frozen dataclass that configures an episode."""
        ...

    def episode(
        self,
        preset: Any,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> Episode:
        """Build one episode of a preset, by its name or as a configuration.

        ``closed_loop`` None means as the preset says; ``truth`` see ``Truth``.
        """
        ...
