"""What a scenario is: its names and presets, its episodes and their worlds, its surveys."""

from __future__ import annotations

import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from scenarios.command_link import LinkLimits
from scenarios.field_values import changed, split_name
from scenarios.truth import Truth, TruthExtent
from sim.checks import check, check_choice
from sim.rng import episode_seed, generator
from sim.world import World
from trackers.types import CameraCommand, CameraModel, Carrier, Observation, Start

if TYPE_CHECKING:
    from scenarios.envs.pictureless.episode_state import KernelWorld

RendererName = Literal["raster", "pybullet"]
_E = TypeVar("_E", bound="Episode", covariant=True)


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
    def camera(self) -> CameraModel:
        """The camera that the tracker watches."""
        return self.observation.camera

    @property
    def judged(self) -> tuple[Truth, CameraModel]:
        """Truth and camera that following is judged by: those of the steered camera, if the episode has two."""
        view = self.observation.steered
        if self.steered is None or view is None:
            return self.truth, self.camera
        return self.steered, view.camera


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


class Pictureless(ABC):
    """A scenario's simulation without pictures, see ``scenarios.envs.pictureless``.

    Attributes:
        version: of the contents of ``arrays``; increment it with every change of them.
        runs: the runs that error models of trackers are fitted to.
        world_place: ``module:name`` of its ``KernelWorld``, whose kernels take seconds to import.
        fixed_fields: fields of a preset that its ``KernelWorld`` reads, the same for all episodes.
        watches_at_rest: whether the tracker's camera is at rest, so that its answers are the same whatever is steered.
    """

    version: int
    runs: TrackerRuns
    world_place: str
    watches_at_rest = False
    fixed_fields: tuple[str, ...] = ("frame_count", "rate_hz", "width_px", "height_px")

    @abstractmethod
    def is_playable(self, preset: Any) -> bool:
        """Return whether a configuration measures the camera's pose, which no picture can replace here."""

    def check_playable(self, preset: Any) -> None:
        """Raise ValueError for a configuration that is not playable, with the reason."""
        check("preset", self.is_playable(preset), "one with instruments (ego) or odometry", "neither")

    @abstractmethod
    def arrays(self, preset: Any, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return an episode's plan as arrays by name, of the same shapes for every seed."""

    def world(
        self, preset: Any, arrays: dict[str, NDArray[np.float64]], link: LinkLimits, errors: NDArray[np.void]
    ) -> KernelWorld:
        """Return the world of E episodes: ``arrays`` have E first; ``errors`` are as ``error_kernel`` reads them."""
        made: KernelWorld = pkgutil.resolve_name(self.world_place)(preset, arrays, link, errors)
        return made


@dataclass(frozen=True, eq=False)
class KeptWorld:
    """A world without the objects of an episode, for several episodes, which may run at the same time.

    Attributes:
        world: with the bodies that all of them have; an episode takes place in a copy.
        content: what the scenario drew these from, e.g. a town's layout.
    """

    world: World
    content: Any


@dataclass(frozen=True, eq=False)
class Setup:
    """What an episode is built from, see ``Scenario.episode``.

    Attributes:
        preset: the configuration.
        seed: of the episode: all its random numbers follow from it, the preset and ``kept``.
        closed_loop: whether commands steer the camera.
        covers_all: whether truth covers all objects, or leaves out what ``truth="target"`` does, see ``Truth``.
        kept: the world that the episode takes place in; None: its own.
        day_seed: of the first episode that shares its background pictures, see ``Scenario.day_of``; None: its own.
        background: whether ``Start`` has pictures without targets, which take time to draw.
    """

    scenario: Scenario[Any]
    preset: Any
    seed: int
    renderer: RendererName = "raster"
    closed_loop: bool = False
    covers_all: bool = True
    kept: KeptWorld | None = None
    day_seed: int | None = None
    background: bool = True

    def rng(self, stream: str) -> np.random.Generator:
        """Return the generator of a named stream of the episode, e.g. ``traffic``."""
        return generator(self.seed, stream)

    def day_rng(self, stream: str) -> np.random.Generator:
        """Return the generator of a named stream that all episodes with the same background pictures share."""
        return generator(self.seed if self.day_seed is None else self.day_seed, stream)


def _all_alike(preset: Any) -> Hashable:
    """Return one kind for all worlds. A lambda could not be pickled."""
    return None


@dataclass(frozen=True)
class Scenario(Generic[_E]):
    """A kind of world.

    Attributes:
        id: catalogue id with its version, e.g. ``road-town-v2``. summary: what it is, in one line.
        start: what a tracker gets before the first picture, in one line.
        stage: builds an episode, most often a class: a ``scenarios.stage.Stage``.
        presets: name -> a frozen dataclass that configures an episode. It has at least ``summary``, ``closed_loop``
            (whether a controller steers), ``frame_count``, ``rate_hz``, ``width_px`` and ``height_px``.
        classes: every kind that its objects may have (``Truth.kinds``) -> class, e.g. ``sedan`` -> ``car``. The order
            gives classes and kinds the numbers that they have in exports: a new one stands last.
        carrier: the camera's carrier: all that a controller or an env needs for steering it.
        truth: the kind of truth of its frames.
        target: name of the object that a single-target tracker is started on, see ``Truth.names``.
        widest_view_m: width of what the picture shows at the target's place, up to which the target counts as in view:
            how near one must get, or how far zoom in. Its source counts pixels on the target, and all presets of a
            scenario that has one take pictures of the width that it is derived for.
        pictureless: its simulation without pictures; None if it has none.
        seeded_as: the id that seeds of episodes derive from, if it is not its own.
        new_world: builds the world of an episode, without the episode; None if its worlds cannot be kept.
        world_kind: returns what of a preset decides, with the seed, what a kept world is.
        day_of: returns, of a preset and a seed, the seed of the first episode with the same background pictures: a
            data set has them once, and all its episodes in one split. None: no episode shares another's.
    """

    id: str
    summary: str
    start: str
    stage: Callable[[Setup], _E]
    presets: dict[str, Any]
    classes: Mapping[str, str]
    carrier: Carrier
    truth: type[Truth] = Truth
    target: str = "target"
    widest_view_m: float = np.inf
    pictureless: Pictureless | None = None
    seeded_as: str = ""
    new_world: Callable[[Setup], KeptWorld] | None = None
    world_kind: Callable[[Any], Hashable] = _all_alike
    day_of: Callable[[Any, int], int] | None = None

    def configuration(self, preset: Any, seed: int = 0) -> Any:
        """Return a preset by its name, which may change fields, or a configuration unchanged.

        Args:
            seed: of the episode, which values of ``scenarios.field_values`` depend on if they are drawn.

        Raises:
            ValueError: for an unknown name or field, and for a value that the preset rejects.
        """
        if not isinstance(preset, str):
            return preset
        name, values = split_name(preset)
        check_choice("preset", name, self.presets)
        return changed(self.presets[name], values, seed) if values else self.presets[name]

    def has_preset(self, name: str) -> bool:
        """Return whether a name begins with one of its presets."""
        return split_name(name)[0] in self.presets

    def episode(
        self,
        preset: Any,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
        kept: KeptWorld | None = None,
        background: bool = True,
    ) -> _E:
        """Build one episode.

        Args:
            preset: its name, or a configuration.
            seed: any whole number >= 0; 10,000 to 19,999 is the test split.
            closed_loop: whether commands steer the camera; None: as in the preset.
            truth: ``target`` leaves out expensive fields that scores of following do not use, see ``Truth``.
            kept: a world of ``keep_world`` that the episode takes place in; None: its own.
            background: False leaves out the pictures without targets of ``Start``; all frames stay the same.

        Raises:
            ValueError: for an unknown preset, renderer or extent of truth, a negative seed, or a loop that cannot be
                closed.
        """
        check("truth", truth in ("all", "target"), "'all' or 'target'", truth)
        check("kept", kept is None or self.new_world is not None, f"none, as {self.id} keeps no worlds", type(kept))
        configuration = self.configuration(preset, seed)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        day = seed if self.day_of is None else self.day_of(configuration, seed)
        own_seed, day_seed, covers_all = self._own(seed), self._own(day), truth == "all"
        return self.stage(
            Setup(self, configuration, own_seed, renderer, looped, covers_all, kept, day_seed, background)
        )

    def keep_world(self, preset: Any, seed: int) -> KeptWorld:
        """Build the world of the seed's episode, without the episode, for several of them.

        Raises:
            ValueError: if its worlds cannot be kept.
        """
        if self.new_world is None:
            raise ValueError(f"scenario: expected one that keeps worlds, got {self.id}")
        return self.new_world(Setup(self, self.configuration(preset, seed), self._own(seed)))

    def _own(self, seed: int) -> int:
        return episode_seed(seed, self.seeded_as or self.id, 0)


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


MOST_FRAMES = 100_000
"""Most pictures of an episode: it is planned as a whole, and its poses stand in memory."""
_SLOWEST_HZ, _FASTEST_HZ = 0.01, 1000.0


def check_size(preset: Any) -> None:
    """Raise ValueError for a ``width_px`` or a ``height_px`` that is not drawn."""
    for name in ("width_px", "height_px"):
        value = getattr(preset, name)
        check(name, 32 <= value <= 4096, "a whole number from 32 to 4096", value)


def check_length(preset: Any, longest_s: float) -> None:
    """Raise ValueError for a ``frame_count`` or a ``rate_hz`` that no episode has, or that last too long together.

    Args:
        longest_s: the time for which the scene goes on, seconds.
    """
    frames, rate, slowest = preset.frame_count, preset.rate_hz, max(_SLOWEST_HZ, 2.0 / longest_s)
    check("rate_hz", slowest <= rate <= _FASTEST_HZ, f"a number in [{slowest:.3g}, {_FASTEST_HZ:g}]", rate)
    most = min(MOST_FRAMES, int(longest_s * rate))
    why = f", as an episode lasts {longest_s:g} s at the most" if most < MOST_FRAMES else ""
    check("frame_count", 2 <= frames <= most, f"a whole number in [2, {most}]{why}", frames)
