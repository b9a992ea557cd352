"""Settings of an env: the keywords of ``gym.make``, checked at once; ``reset(options=...)`` may change some."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from scenarios import catalog
from scenarios.command_link import LINKS, Link
from scenarios.envs.reward import Reward, reward_of
from scenarios.field_values import changeable, is_drawn, is_number, with_tuples
from scenarios.scenario import RendererName, Scenario
from sim.checks import check, check_choice
from sim.rng import generator
from trackers import registry

CHANNELS = ("track", "pixels", "depth", "segmentation")
ActionMode = Literal["command", "correction", "parameters"]
OutOfRange = Literal["refuse", "clip"]
Range = tuple[float, float]
_OF_ACTIONS: Mapping[str, tuple[ActionMode, ...]] = {
    "controller": ("correction", "parameters"),
    "controller_values": ("correction", "parameters"),
    "correction_share": ("correction",),
    "corrects": ("correction",),
}
"""Settings that some kinds of actions alone use."""
_MAPPINGS = ("changes", "randomise", "controller_values")
EPISODE_OPTIONS = ("preset", "changes", "randomise", "progress", "difficulty", "link")
"""Settings that ``reset(options=...)`` may change for one episode."""
WORLDS = 16
"""Default number of worlds that episodes take place in."""
OWN_WORLD = -1
"""``world_seed`` of an episode that has its own world."""
RESET_OPTIONS = ("episode_seed", "world_seed", *EPISODE_OPTIONS)


DEVELOPMENT_SEEDS = 10_000
"""Drawn seeds of episodes lie below this number; only options of ``reset`` select others."""


@dataclass(frozen=True)
class FollowSettings:
    """Settings of an env.

    Attributes:
        scenario: catalogue id.
        tracker: name in the registry, or an object with ``initialise`` and ``update``; None for a policy that sees the
            picture alone, e.g. with ``observation="pixels"``, and ``action="command"``.
        preset: name of one of the scenario's presets; None: the env's own (``standard``, or as ``frameout list`` says),
            unless ``difficulty`` is given.
        changes: fields of the preset -> other values, e.g. ``{"width_px": 84, "height_px": 84}``.
        randomise: numeric fields of the preset -> (low, high), drawn anew for every episode; or -> two such ranges,
            at the beginning of a training and at its end: a curriculum, which lies between them by ``progress``.
        progress: of the training, from 0 to 1; set for later episodes by ``env.unwrapped.progress``, or by ``set_attr``
            of a vector env.
        difficulty: None, or 0 (preset ``standard``) to 1 (``hard``), which interpolates these presets' numbers; given
            in place of ``preset``, never beside it.
        link: name of a preset of delay and noise (``prompt``, ``delayed``, ``noisy``, ``late``), or a ``Link``.
        controller: name, or an object with ``command``; used by the actions ``correction`` and ``parameters`` alone.
        controller_values: parameters of a named controller that replace its tuned values; they are not limited to the
            ranges that tuning searches and that the action ``parameters`` spans.
        observation: ``track`` (the tracker's belief and the carrier's measurements), ``pixels`` (the picture, the left
            one of a pair), ``depth``, ``segmentation``, or several of these, e.g. ``("track", "depth")``, as a
            dictionary; ``both`` is the first two. The last two are truth, which a real camera may not have.
        action: the ``command`` itself, a ``correction`` that is added to the controller's command, or the controller's
            ``parameters``.
        correction_share: the largest correction, as a share of the command's limit, above 0 and at most 2; of the
            action ``correction``.
        corrects: when corrections are added: ``always``, or while the target is ``unseen``; of the same action.
        out_of_range: ``refuse`` actions outside [-1, 1], or ``clip`` them, as Gymnasium's own envs do; those that are
            not finite are always refused.
        reward: weights of the reward's terms, a ``Reward`` or a mapping of some of them, e.g. ``{"effort": 0.5}``.
        lost_after_s: the episode terminates when the target has been out of view for this time; None: never.
        renderer: ``raster`` or ``pybullet``.
        worlds: number of worlds (towns, buildings) in which episodes take place: that of seed n is in the world of seed
            ``n % worlds``, with cars or people of its own. All envs of a process share these, built when they are first
            needed; a reset then takes a tenth of the time. Each takes memory in each process, some 50 MB. A field of
            ``randomise`` that decides what a world is, e.g. its extent, makes a new one for each value. 0: every
            episode has its own world, as in ``frameout bench`` and always from seed 10,000 on. None: 16 if the scenario
            can keep worlds, otherwise 0.
    """

    scenario: str
    tracker: Any
    preset: str | None = None
    changes: Mapping[str, Any] = field(default_factory=dict)
    randomise: Mapping[str, Range | tuple[Range, Range]] = field(default_factory=dict)
    progress: float = 0.0
    difficulty: float | None = None
    link: str | Link = "prompt"
    controller: Any = "centre"
    controller_values: Mapping[str, Any] = field(default_factory=dict)
    observation: str | Sequence[str] = "track"
    action: ActionMode = "command"
    correction_share: float = 0.7
    corrects: Literal["always", "unseen"] = "always"
    out_of_range: OutOfRange = "refuse"
    reward: Reward = field(default_factory=Reward)
    lost_after_s: float | None = None
    renderer: RendererName = "raster"
    worlds: int | None = None

    def __post_init__(self) -> None:
        scenario = catalog.scenario(self.scenario)
        for name, kind in (
            ("action", ActionMode),
            ("out_of_range", OutOfRange),
            ("renderer", RendererName),
        ):
            check_choice(name, getattr(self, name), get_args(kind))
        object.__setattr__(self, "reward", reward_of(self.reward))
        lost, worlds, links = self.lost_after_s, self.worlds, ", ".join(LINKS)
        tracker = "None, the name of a tracker, or an object with initialise and update"
        for name, good, wanted in (
            ("corrects", self.corrects in ("always", "unseen"), "one of always, unseen"),
            ("correction_share", 0 < self.correction_share <= 2, "a number in (0, 2]"),
            ("lost_after_s", lost is None or (is_number(lost) and lost > 0), "None or a number > 0"),
            ("tracker", _is_tracker(self.tracker), tracker),
            ("link", isinstance(self.link, Link) or self.link in tuple(LINKS), f"one of {links} or a Link"),
            ("progress", is_number(self.progress) and 0 <= self.progress <= 1, "a number from 0 to 1"),
            ("worlds", worlds is None or (_is_whole(worlds) and worlds >= 0), "None or a whole number >= 0"),
            *((name, isinstance(getattr(self, name), Mapping), "a dictionary") for name in _MAPPINGS),
        ):
            check(name, good, wanted, repr(getattr(self, name)))
        for name, actions in _OF_ACTIONS.items():
            unused = self.action not in actions and getattr(self, name) != _DEFAULTS[name]
            wanted = f"none with action={self.action!r}, as it is of {' and '.join(actions)}"
            check(name, not unused, wanted, repr(getattr(self, name)))
        given = self.observation
        check("observation", isinstance(given, str | Sequence) and len(given) > 0, "a channel, or several", repr(given))
        for each in self.channels:
            check_choice("observation", each, (*CHANNELS, "both") if isinstance(given, str) else CHANNELS)
        check("observation", len({*self.channels}) == len(self.channels), "each channel once", repr(given))
        if self.tracker is None:
            check("observation", "track" not in self.channels, "no track with tracker=None", repr(given))
            wanted = "'command' with tracker=None, as a controller steers by a tracker's estimates"
            check("action", self.action == "command", wanted, repr(self.action))
        if isinstance(self.tracker, str):
            registry.entry(self.tracker)
        if isinstance(self.preset, str):
            drawn = is_drawn(scenario.configuration(self.preset), self.preset)
            check("preset", not drawn, "fixed values, as `randomise` draws them", repr(self.preset))
        elif self.preset is not None:
            check_choice("preset", self.preset, scenario.presets)
        alone = self.preset is None or self.difficulty is None
        wanted = "no preset beside it, as it lies between standard and hard"
        check("difficulty", alone, wanted, f"preset={self.preset!r} and difficulty={self.difficulty!r}")
        if worlds:
            check_keeps_worlds("worlds", scenario)
        ranges = self._checked_ranges()
        for progress in (0, 1):
            for end in (0, 1):
                self.configuration({name: both[progress][end] for name, both in ranges.items()})

    def with_options(self, options: Mapping[str, Any]) -> FollowSettings:
        """Return these settings, changed by ``options`` of ``reset``."""
        for name in options:
            check("options", name in RESET_OPTIONS, f"keys among {', '.join(RESET_OPTIONS)}", repr(name))
        seed, world = options.get("episode_seed", 0), options.get("world_seed", OWN_WORLD)
        check("episode_seed", _is_whole(seed) and seed >= 0, "a whole number >= 0", repr(seed))
        own = f"a whole number >= 0, or {OWN_WORLD} for the episode's own world"
        check("world_seed", _is_whole(world) and (world >= 0 or world == OWN_WORLD), own, repr(world))
        if "world_seed" in options:
            check("world_seed", "episode_seed" in options, "an episode_seed beside it", "none")
            if world != OWN_WORLD:
                check_keeps_worlds("world_seed", catalog.scenario(self.scenario))
        changes = {name: value for name, value in options.items() if name in EPISODE_OPTIONS}
        if {"preset", "difficulty"} & changes.keys():
            # Either takes the place of whichever of the two the env was made with.
            changes = {"preset": None, "difficulty": None} | changes
        return dataclasses.replace(self, **changes) if changes else self

    def _checked_ranges(self) -> dict[str, tuple[Range, Range]]:
        """Return the ranges of ``randomise`` at the beginning and at the end of a training.

        Raises:
            ValueError: for an invalid range, or a field that must not vary by episode.
        """
        preset = self.configuration({})
        for name, limits in self.randomise.items():
            check("randomise", is_number(getattr(preset, name)), "fields that are numbers", repr(name))
            same = self.observes_pictures and name in ("width_px", "height_px")
            check("randomise", not same, "no size of the picture where that is observed", repr(name))
            good = _is_range(limits) or (
                isinstance(limits, Sequence) and len(limits) == 2 and all(map(_is_range, limits))
            )
            check(f"randomise.{name}", good, "two numbers in ascending order, or two ranges of them", limits)
        return {name: _ends(limits) for name, limits in self.randomise.items()}

    @property
    def is_curriculum(self) -> bool:
        """Whether a range of ``randomise`` changes with the progress of a training."""
        return any(first != last for first, last in map(_ends, self.randomise.values()))

    def world_of(self, seed: int) -> int:
        """Return the seed of the world in which an episode takes place, ``OWN_WORLD`` for its own.

        Episodes of the test split have their own, which no training has seen.
        """
        worlds = self.worlds if seed < DEVELOPMENT_SEEDS else 0
        if worlds is None:
            worlds = WORLDS if catalog.scenario(self.scenario).new_world else 0
        return seed % worlds if worlds else OWN_WORLD

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of what is observed."""
        if self.observation == "both":
            return ("track", "pixels")
        return (self.observation,) if isinstance(self.observation, str) else tuple(self.observation)

    @property
    def observes_one(self) -> bool:
        """Whether an observation is an array, not a dictionary."""
        return isinstance(self.observation, str) and self.observation != "both"

    @property
    def observes_pictures(self) -> bool:
        """Whether an observation has the size of a picture."""
        return self.channels != ("track",)

    @property
    def preset_name(self) -> str:
        """The preset that holds without a ``difficulty``."""
        return catalog.env_preset(self.scenario) if self.preset is None else self.preset

    @property
    def link_settings(self) -> Link:
        """The link's delay and noise."""
        return self.link if isinstance(self.link, Link) else LINKS[self.link]

    def configuration(self, drawn: Mapping[str, float]) -> Any:
        """Return the preset with ``changes`` and with ``drawn``, the values of the fields in ``randomise``.

        Raises:
            ValueError: for an unknown field, or a value that the preset rejects.
        """
        scenario = catalog.scenario(self.scenario)
        preset = scenario.configuration(self.preset_name)
        if self.difficulty is not None:
            graded = {"standard", "hard"} <= scenario.presets.keys()
            wanted = f"None{' or a number from 0 to 1' if graded else f', as {scenario.id} has no preset hard'}"
            good = graded and is_number(self.difficulty) and 0 <= self.difficulty <= 1
            check("difficulty", good, wanted, repr(self.difficulty))
            preset = between(scenario.presets["standard"], scenario.presets["hard"], self.difficulty)
        known = changeable(preset)
        for group in ("changes", "randomise"):
            for name in getattr(self, group):
                check_choice(group, name, sorted(known))
        values = {name: with_tuples(getattr(preset, name), value) for name, value in self.changes.items()}
        values |= {name: _like(getattr(preset, name), value) for name, value in drawn.items()}
        return dataclasses.replace(preset, **values)

    def configuration_of(self, seed: int, progress: float | None = None) -> Any:
        """Return the ``configuration`` of the episode with a seed, which draws the fields in ``randomise``.

        Args:
            progress: of the training; None: that of the settings.
        """
        rng, share, drawn = generator(seed, "randomise"), self.progress if progress is None else progress, {}
        for name, limits in self.randomise.items():
            first, last = _ends(limits)
            low, high = (
                first if first == last else ((1.0 - share) * a + share * b for a, b in zip(first, last, strict=True))
            )
            drawn[name] = float(rng.uniform(low, high))
        return self.configuration(drawn)


KEYWORDS = tuple(each.name for each in dataclasses.fields(FollowSettings) if each.name != "scenario")
"""Settings that users give; the env's id has the scenario."""
_DEFAULTS = {
    each.name: each.default_factory() if callable(each.default_factory) else each.default
    for each in dataclasses.fields(FollowSettings)
}


def between(easy: Any, hard: Any, difficulty: float) -> Any:
    """Interpolate two configurations; values that are not numbers come from the nearer one."""
    values = {
        each.name: _between(getattr(easy, each.name), getattr(hard, each.name), difficulty)
        for each in dataclasses.fields(easy)
    }
    return type(easy)(**values)


def _between(easy: Any, hard: Any, difficulty: float) -> Any:
    if isinstance(easy, tuple) and isinstance(hard, tuple) and len(easy) == len(hard):
        values = [_between(a, b, difficulty) for a, b in zip(easy, hard, strict=True)]
        return type(easy)(*values) if hasattr(easy, "_fields") else tuple(values)
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in (easy, hard))
    if not numbers:
        return hard if difficulty >= 0.5 else easy
    # The end is exact, and so is what both presets share.
    return hard if difficulty == 1.0 else _like(easy, easy + difficulty * (hard - easy))


def _is_range(limits: Any) -> bool:
    is_pair = isinstance(limits, Sequence) and len(limits) == 2 and all(map(is_number, limits))
    return is_pair and limits[0] <= limits[1]


def _ends(limits: Any) -> tuple[Range, Range]:
    """Return a checked range at the beginning and at the end of a training."""
    first, last = (limits, limits) if _is_range(limits) else limits
    return tuple(first), tuple(last)


def _is_whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def check_keeps_worlds(parameter: str, scenario: Scenario[Any]) -> None:
    """Raise ValueError for a scenario that cannot keep worlds."""
    able = (each for each in catalog.names() if catalog.scenario(each).new_world)
    wanted = f"a scenario that keeps worlds ({', '.join(able)})"
    check(parameter, scenario.new_world is not None, wanted, scenario.id)


def _is_tracker(tracker: Any) -> bool:
    if tracker is None or isinstance(tracker, str):
        return True
    return not isinstance(tracker, type) and all(
        callable(getattr(tracker, name, None)) for name in ("initialise", "update")
    )


def _like(example: Any, value: float) -> Any:
    """Return a value, rounded if the example is an integer."""
    return round(value) if isinstance(example, int) else float(value)
