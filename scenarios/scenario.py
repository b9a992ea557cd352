"""The contract of a scenario: what it offers by name, and how an episode of it is lived through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.truth import Truth, TruthExtent
from sim.optics import PinholeCamera
from trackers.types import CameraCommand, CameraModel, Carrier, Observation, Start

RendererName = Literal["raster", "pybullet"]


@dataclass(frozen=True, slots=True)
class Frame:
    """One instant: what trackers are told, and what is so.

    Attributes:
        observation, truth: of the camera that the tracker watches.
        steered: truth of the steered camera, if that is another one, whose model ``observation.steered`` tells.
    """

    observation: Observation
    truth: Truth
    steered: Truth | None = None

    @property
    def camera(self) -> PinholeCamera:
        """The camera that the tracker watches."""
        return _pinhole(self.observation.camera)

    @property
    def judged(self) -> tuple[Truth, PinholeCamera]:
        """Truth and camera that following is judged by: those of the steered camera, if the episode has two."""
        told = self.observation.steered
        if self.steered is None or told is None:
            return self.truth, self.camera
        return self.steered, _pinhole(told.camera)


class Episode(Protocol):
    """One run through a scenario. Byte-identical for the same scenario, preset, seed and renderer.

    Attributes:
        frame_count: number of frames.
        rate_hz: frames a second.
        closed_loop: True if ``step`` needs a command, False if the camera flies a set path or is at rest.
    """

    frame_count: int
    rate_hz: float
    closed_loop: bool

    @property
    def start(self) -> Start:
        """What a tracker is told before the first picture."""
        ...

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
    def target(self) -> str:
        """Name of the object that a tracker of one target is started on, see ``Truth.names``."""
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
        """Name -> the frozen dataclass that configures an episode.

        It has at least ``summary``, ``closed_loop`` (whether a controller steers), ``width_px`` and ``height_px``.
        """
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


class Survey(Protocol):
    """Measures what a scenario's presets hold, without drawing a picture.

    Attributes:
        columns: headings of what a table tells of a preset.
    """

    columns: tuple[str, ...]

    def measure(self, preset: Any, seeds: range) -> dict[str, Any]:
        """Return what the episodes of a configuration hold, by name, as JSON knows it."""
        ...

    def cells(self, held: dict[str, Any]) -> tuple[str, ...]:
        """Return what ``measure`` returned in words, one for each of the columns."""
        ...


def preset_of(scenario: Scenario, preset: Any) -> Any:
    """Return a scenario's preset by name, or a configuration as it is.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    if not isinstance(preset, str):
        return preset
    if preset not in scenario.presets:
        raise ValueError(f"preset: expected one of {', '.join(scenario.presets)}; got {preset!r}")
    return scenario.presets[preset]


def _pinhole(model: CameraModel) -> PinholeCamera:
    return PinholeCamera(model.width_px, model.height_px, model.focal_px)
