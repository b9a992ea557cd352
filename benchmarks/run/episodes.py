"""Episodes before they are opened: what names them in rows, how they are opened and judged. Workers receive them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, runtime_checkable

from benchmarks.contract.judging import Judge
from benchmarks.contract.rows import REAL, Row
from benchmarks.contract.suite import Suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.editions import (
    Editions,
    controller_edition,
    judge_edition,
    package_versions,
    scene_edition,
    tracker_edition,
)
from scenarios import catalog
from scenarios.command_link import CommandLink, Link, episode_link, link_named
from scenarios.field_values import split_name
from scenarios.scenario import Episode, RendererName, Scenario
from scenarios.truth import TruthExtent
from sim.checks import check
from trackers.controllers.catalogue import ControllerEntry, controller_entry
from trackers.protocols import Controller


@runtime_checkable
class ForeseeingController(Controller, Protocol):
    """An oracle, which gets the episode before it steers."""

    def foresee(self, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """Take the episode: catalogue id, configuration and seed, and the link to the carrier."""
        ...


@dataclass(frozen=True)
class Steering:
    """A controller that steers by the estimates of a tracker.

    Attributes:
        name: of the controller. carrier: name of what it steers.
        link: how commands reach the carrier, see ``scenarios.command_link``; None = unchanged, and the controller has
            its values as written.
        values: parameter values in place of the tuned ones; with a link only.
    """

    name: str
    carrier: str
    link: str | None = None
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def entry(self) -> ControllerEntry:
        """The registered controller. Raises ValueError for an unknown name."""
        return controller_entry(self.name, self.carrier)

    def create(self, episode: EpisodeSpec) -> Controller:
        """Return a new controller for one episode."""
        made = self.entry.create_as_written() if self.link is None else self.entry.create(**self.values)
        if isinstance(made, ForeseeingController):
            assert isinstance(episode, Simulated)
            check("controllers", self.link is not None, "one that knows no more than a tracker", repr(self.name))
            made.foresee(episode.scenario.id, episode.configuration, episode.seed, link_named(str(self.link)))
        return made


class EpisodeSpec(ABC):
    """One episode before it is opened.

    Attributes:
        scenario: what its scenario is; None for what is real.
        preset, renderer, seed: as they stand in rows.
        steering: who steers the camera; None = the set path.
    """

    scenario: Scenario | None
    preset: str
    renderer: RendererName | Literal["real"]
    seed: int
    steering: Steering | None = None

    @property
    def scenario_id(self) -> str:
        """Column ``scenario`` of its rows."""
        return REAL if self.scenario is None else self.scenario.id

    @property
    def columns(self) -> Row:
        """Columns of its rows that others do not have."""
        return {}

    @property
    def sequence(self) -> str:
        """Name of the real sequence; "" of others."""
        return ""

    @property
    def in_words(self) -> str:
        """Which one it is, e.g. ``road-town-v2 quick, seed 0``."""
        which = f"sequence {self.sequence}" if self.sequence else f"seed {self.seed}"
        return f"{self.scenario_id} {self.preset}, {which}"

    @property
    def has_one_target(self) -> bool:
        """Whether one target is given and known, so that trackers of many follow it in suites of many too."""
        return False

    @property
    @abstractmethod
    def edition(self) -> str:
        """``scene`` of ``editions``; "" for what cannot be read."""

    @abstractmethod
    def open(self, truth: TruthExtent) -> Episode:
        """Return the episode before its first frame. Raises UnreadableSequence if its first picture is broken."""

    @abstractmethod
    def judge(self, suite: Suite, episode: Episode) -> Judge:
        """Return a suite's judge of the opened episode."""

    def command_link(self, episode: Episode) -> CommandLink | None:
        """Return what passes commands on to the carrier of the opened episode; None passes them on unchanged."""
        return None

    @property
    def picture_delay_frames(self) -> int:
        """See ``scenarios.command_link.Link``."""
        return 0


@dataclass(frozen=True)
class Simulated(EpisodeSpec):
    """An episode of a scenario, rendered.

    Attributes:
        configuration: of the episode, the scenario's preset or a change of it that is called ``preset``.
    """

    scenario: Scenario
    preset: str
    seed: int
    configuration: Any
    renderer: RendererName = "raster"
    steering: Steering | None = None

    @property
    def edition(self) -> str:
        """See ``EpisodeSpec``; of the values that a preset's name changes only meshes are part of it."""
        name, values = split_name(self.preset)
        return scene_edition(self.scenario, self.scenario.presets[name] if values else self.configuration, values)

    def open(self, truth: TruthExtent) -> Episode:
        """See ``EpisodeSpec``."""
        how = {"renderer": self.renderer, "closed_loop": self.steering is not None, "truth": truth}
        return self.scenario.episode(self.configuration, self.seed, **how)  # type: ignore[arg-type]

    def judge(self, suite: Suite, episode: Episode) -> Judge:
        """See ``EpisodeSpec``."""
        return suite.judge_of(episode, self.scenario)

    def command_link(self, episode: Episode) -> CommandLink | None:
        """See ``EpisodeSpec``."""
        if self.steering is None or self.steering.link is None:
            return None
        return episode_link(self.scenario.carrier, episode.rate_hz, link_named(self.steering.link), self.seed)

    @property
    def picture_delay_frames(self) -> int:
        """See ``EpisodeSpec``."""
        named = None if self.steering is None else self.steering.link
        return 0 if named is None else link_named(named).picture_delay_frames


def editions_of(suite: Suite, episode: EpisodeSpec, tracker: TrackerSpec) -> Editions:
    """Return ``editions`` of the rows of a tracker in an episode."""
    made = {
        **package_versions(episode.renderer),
        "scene": episode.edition,
        "judge": judge_edition(suite),
        "tracker": " ".join(filter(None, (tracker_edition(tracker), tracker.content(episode)))),
    }
    return made if episode.steering is None else made | controller_edition(episode.steering.entry)


def simulated(
    scenario: str,
    preset: str,
    seed: int,
    *,
    renderer: RendererName = "raster",
    controller: str | None = None,
    link: str | None = None,
    changed: Mapping[str, Any] | None = None,
) -> Simulated:
    """Return an episode by names; with ``changed`` fields of the preset. Raises ValueError for unknown ones."""
    found = catalog.scenario(scenario)
    configuration = found.configuration(preset, seed)
    if changed:
        configuration = replace(configuration, **changed)
    steering = None if controller is None else Steering(controller, found.carrier.name, link)
    return Simulated(found, preset, seed, configuration, renderer, steering)
