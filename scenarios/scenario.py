"""The contracts of a scenario: its names and presets, its episodes, its surveys."""

from __future__ import annotations

from collections.abc import Mapping
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
    """One instant: the observation that trackers get, and the truth.

    Attributes:
        observation, truth: of the camera that the tracker watches.
        steered: truth of the steered camera, if that is another one; ``observation.steered`` holds its model.
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
        view = self.observation.steered
        if self.steered is None or view is None:
            return self.truth, self.camera
        return self.steered, _pinhole(view.camera)


class Episode(Protocol):
    """One run through a scenario. Byte-identical for the same scenario, preset, seed and renderer.

    Attributes:
        frame_count: number of frames.
        rate_hz: frames a second.
        closed_loop: True if ``step`` needs a command, False if the camera follows a set path or is at rest.
    """

    frame_count: int
    rate_hz: float
    closed_loop: bool

    @property
    def start(self) -> Start:
        """What a tracker gets before the first picture."""
        ...

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame, starting with frame 0. ``command`` moves the camera in closed loop."""
        ...

    def map_of(self) -> Any:
        """Return the scenario's map (road network …), for reference trackers with unfair knowledge."""
        ...

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant from the same camera in a picture ``scale`` times as wide and high.

        Its middle equals the observed picture, up to noise; the papers' figures also draw the surroundings.
        """
        ...

    def normals(self) -> NDArray[np.float32]:
        """Return the unit normals (H, W, 3) of the surfaces seen in the current frame, world frame; 0 where none is."""
        ...

    def close(self) -> None:
        """Free what Python does not free by itself, e.g. files or another simulator."""
        ...


@dataclass(frozen=True)
class TrackerRuns:
    """The rendered runs that a tracker's error model is fitted to.

    Attributes:
        controllers: steer in turn; together they produce targets in view, cut, hidden, briefly lost and lost for good.
        wrong_from_m: error from which a tracker is off its target.
        jump_m: a larger change of the error between frames means that the tracker has moved its estimate elsewhere.
    """

    controllers: tuple[str, ...]
    wrong_from_m: float
    jump_m: float


class World(Protocol):
    """Simulates B episodes at a time without pictures; their states (B,) are records of ``state_dtype``.

    Attributes:
        state_dtype: ``scenarios.envs.pictureless.episode_state.EPISODE_STATE`` and the carrier's own fields.
        camera: focal length, half width, half height (3,), pixels.
        interval_s: between frames.
    """

    state_dtype: np.dtype[Any]
    camera: NDArray[np.float64]
    interval_s: float

    def begin(
        self,
        states: NDArray[np.void],
        which: NDArray[np.int64],
        episodes: NDArray[np.int64],
        at_frame_outs: bool,
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Begin ``episodes`` (K,) of the bank in the rows ``which`` (K,) of ``states``; write their first sightings."""
        ...

    def move(
        self,
        states: NDArray[np.void],
        wanted: NDArray[np.float64],
        waiting: NDArray[np.float64],
        sightings: NDArray[np.void],
        rng: np.random.Generator,
    ) -> None:
        """Advance all episodes by a frame under the commands ``wanted`` (B, 4); ``waiting`` (B, D, 4) are delayed."""
        ...


class Pictureless(Protocol):
    """A scenario's simulation without pictures, see ``scenarios.envs.pictureless``.

    Attributes:
        version: of the contents of ``arrays``; increment it with every change of them.
        runs: the runs that error models of trackers are fitted to.
    """

    @property
    def version(self) -> int: ...

    @property
    def runs(self) -> TrackerRuns: ...

    def is_playable(self, preset: Any) -> bool:
        """Return whether a configuration measures the camera's pose, which no picture can replace here."""
        ...

    def arrays(self, preset: Any, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return an episode's plan as arrays by name, of the same shapes for every seed."""
        ...

    def world(
        self, preset: Any, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> World:
        """Return the world of E episodes: ``arrays`` have E first; ``errors`` are as ``error_kernel`` reads them.

        Imports kernels, which takes seconds.
        """
        ...


class Scenario(Protocol):
    """A kind of world."""

    @property
    def id(self) -> str:
        """Catalogue id with its version, e.g. ``road-town-v2``."""
        ...

    @property
    def summary(self) -> str:
        """What it is, in one line."""
        ...

    @property
    def start(self) -> str:
        """What a tracker gets before the first picture, in one line."""
        ...

    @property
    def target(self) -> str:
        """Name of the object that a single-target tracker is started on, see ``Truth.names``."""
        ...

    @property
    def truth(self) -> type[Truth]:
        """The kind of truth of its frames."""
        ...

    @property
    def classes(self) -> Mapping[str, str]:
        """Every kind that its objects may have (``Truth.kinds``) -> class, e.g. ``sedan`` -> ``car``.

        The order gives classes and kinds the numbers that they have in exports: a new one stands last.
        """
        ...

    @property
    def carrier(self) -> Carrier:
        """The camera's carrier: all that a controller or an env needs for steering it."""
        ...

    @property
    def pictureless(self) -> Pictureless | None:
        """Its simulation without pictures; None if it has none."""
        ...

    @property
    def presets(self) -> dict[str, Any]:
        """Name -> a frozen dataclass that configures an episode.

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
        """Build one episode of a preset, given by name or as a configuration.

        ``closed_loop`` None means as in the preset; for ``truth`` see ``Truth``.
        """
        ...


class Survey(Protocol):
    """Measures the contents of a scenario's presets without rendering.

    Attributes:
        columns: headings of the table of presets.
    """

    columns: tuple[str, ...]

    def measure(self, preset: Any, seeds: range) -> dict[str, Any]:
        """Return what the episodes of a configuration contain, by name, as JSON values."""
        ...

    def cells(self, held: dict[str, Any]) -> tuple[str, ...]:
        """Return the result of ``measure`` as text, one cell per column."""
        ...


def preset_of(scenario: Scenario, preset: Any) -> Any:
    """Return a scenario's preset by name, or a configuration unchanged.

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
