"""From names to what is run: trackers, controllers, episodes. Commands look things up here, once."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast, get_args

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import DEFAULT, Scene, Suite, suite, suites
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.blindfold import Blindfolded, ManyBlindfolded
from benchmarks.run.episodes import Grid, Simulated, Steering, simulated
from benchmarks.run.experiment import Experiment
from benchmarks.run.jobs import Job
from benchmarks.run.own_inputs import own
from benchmarks.run.stale_kernels import forget_stale_kernels
from scenarios import catalog
from scenarios.command_link import LINKS
from scenarios.loop import FromPictures, LoopTracker, ManyFromPictures
from scenarios.scenario import Episode, RendererName, Scenario
from sim.checks import check, check_choice, suggestion
from trackers import registry
from trackers.controllers import catalogue
from trackers.follow_one import FollowOne

SET_PATH = "set-path"


@dataclass(frozen=True, kw_only=True)
class Registered(TrackerSpec):
    """A tracker of the registry, with its parameters."""

    entry: registry.TrackerEntry

    def create(
        self, episode: Episode, scenario: Scenario | None, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        tracker = self.entry.tracker(self.parameters, rng)
        if self.entry.follows_many and many:
            return ManyBlindfolded(tracker) if self.role == "blind" else ManyFromPictures(tracker)
        if self.entry.follows_many:
            start = own(episode.start)
            return FromPictures(FollowOne(tracker, start.background, start.site))
        if self.role != "blind":
            return FromPictures(tracker)
        assert scenario is not None
        return Blindfolded(tracker, scenario.target)

    def missing(self) -> str:
        """See ``TrackerSpec``."""
        return self.entry.missing()

    def __reduce_ex__(self, protocol: Any) -> Any:
        # By name: a class that no module holds, e.g. one made in a loop, would travel with all that it refers to.
        if self.module == "__main__":
            return super().__reduce_ex__(protocol)
        return _registered_in, (self.module, self.name, self.parameters)


def _registered_in(module: str, name: str, parameters: Any) -> Registered:
    importlib.import_module(module)
    return replace(registered(registry.entry(name)), parameters=parameters)


def registered(entry: registry.TrackerEntry, **values: Any) -> Registered:
    """Return a tracker of the registry; with ``values`` of its parameters, if any are given."""
    forget_stale_kernels()
    return Registered(
        name=entry.name,
        role=entry.role,
        summary=entry.summary,
        suites=entry.suites or (DEFAULT,),
        parameters=entry.parameters(**values),
        module=entry.tracker.__module__,
        edition=entry.edition,
        reproducible=entry.reproducible,
        entry=entry,
    )


def trackers_of(*suite_names: str) -> dict[str, TrackerSpec]:
    """Return all trackers and references, or those of some suites, by name; trackers in order of registration."""
    known = (
        *map(registered, registry.entries().values()),
        *(ref for each in suites().values() for ref in each.references),
    )
    return {each.name: each for each in known if not suite_names or not set(suite_names).isdisjoint(each.suites)}


def trackers_in(suite: Suite, scene: Scene) -> dict[str, TrackerSpec]:
    """Return all that may take part in a scene of a suite, by name: its trackers, and those of the suite itself."""
    return trackers_of(suite.tracked_by(scene)) | trackers_of(suite.name)


def tracker_named(name: str, **values: Any) -> TrackerSpec:
    """Return one tracker or reference; a tracker with ``values`` of its parameters, if any are given.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    entry = registry.entry(name) if values else registry.entry_or_none(name)
    if entry is not None:
        return registered(entry, **values)
    known = trackers_of()
    if name not in known:
        unknown = f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("tracker", name, known, why=suggestion(name, known) or unknown)
    return known[name]


def default_controllers(scenario: Scenario, *, variants: bool = False) -> tuple[str, ...]:
    """Return the controllers of a scenario that steer where none are named, ablations only with ``variants``."""
    known = catalogue.controllers(scenario.carrier.name)
    return tuple(name for name, entry in known.items() if variants or entry.role != "variant")


def controllers_of(suite: Suite, scenario: Scenario) -> tuple[str, ...]:
    """Return the names of the controllers of a suite, with ``SET_PATH`` where a set path is a choice."""
    steering = tuple(catalogue.controllers(scenario.carrier.name))
    if suite.judges_controllers:
        return steering
    return (SET_PATH,) if suite.controller is None else (SET_PATH, *steering)


def check_renderer(name: str) -> RendererName:
    """Return a renderer's name. Raises ValueError for an unknown one."""
    check_choice("renderer", name, get_args(RendererName))
    return cast(RendererName, name)


def experiment_on(
    judging: Suite | str,
    scenario: str,
    presets: Sequence[str] | Mapping[str, Any],
    trackers: Sequence[str] | Mapping[str, TrackerSpec],
    seeds: range,
    *,
    controllers: Sequence[str] | None = None,
    link: str = "prompt",
    renderer: str = "raster",
    **how: Any,
) -> Experiment:
    """Return an experiment by names.

    Args:
        judging: the suite. scenario: catalogue id.
        presets: names; or the names in rows → configurations.
        trackers: names; or the names in rows → trackers.
        controllers: names of those that steer the camera, ``SET_PATH`` for none; None = ``default_controllers`` where
            they compete, else the suite's controller in presets in closed loop.
        link: how commands reach the carrier where controllers compete; elsewhere commands arrive unchanged.
        how: see ``Experiment``.

    Raises:
        ValueError: for unknown names and values out of range.
    """
    judged = suite(judging) if isinstance(judging, str) else judging
    scene = catalog.scenario(scenario)
    steered = bool(scene.carrier.axes) or not judged.judges_controllers
    check("scenario", steered, "one with a camera that can be steered", repr(scene.id))
    if not isinstance(presets, Mapping):
        for name in presets:
            check_choice("preset", name, scene.presets)
        presets = {name: scene.presets[name] for name in presets}
    for name in controllers or ():
        _check_controller(judged, scene, name)
    check_choice("link", link, LINKS)
    chosen = trackers if isinstance(trackers, Mapping) else _trackers_named(judged, scene, trackers, how)
    drawn = check_renderer(renderer)
    check("seeds", 0 <= seeds.start < seeds.stop, "A:B with 0 <= A < B", f"{seeds.start}:{seeds.stop}")
    kinds = [
        Simulated(scene, name, seeds.start, preset, drawn, steering)
        for name, preset in presets.items()
        for steering in _steering(judged, scene, preset, controllers, link)
    ]
    return Experiment(judged, Grid(kinds, seeds), chosen, **how)


def job_on(
    judging: Suite | str,
    scenario: str,
    preset: str,
    seed: int,
    trackers: Sequence[str] = (),
    *,
    controller: str | None = None,
    link: str | None = None,
    renderer: str = "raster",
    **how: Any,
) -> Job:
    """Return the job of one episode by names; ``link`` None = commands arrive unchanged. ``how``: see ``Job``.

    Raises:
        ValueError: for unknown names.
    """
    judged = suite(judging) if isinstance(judging, str) else judging
    drawn = check_renderer(renderer)
    episode = simulated(scenario, preset, seed, renderer=drawn, controller=controller, link=link)
    return Job(judged, episode, {name: tracker_named(name) for name in trackers}, **how)


def job_of(row: Row, seed: int) -> Job:
    """Return the job that repeats the run of a row, on this ``seed``."""
    return job_on(
        row["suite"],
        row["scenario"],
        row["preset"],
        seed,
        (row["tracker"],),
        controller=row["controller"],
        link=row.get("link"),
        renderer=row["renderer"],
        modules=tuple(row.get("modules", ())),
        repeats=1,
        limit_s=row.get("limit_s", Job.limit_s),
    )


def _check_controller(suite: Suite, scenario: Scenario, name: str) -> None:
    """Raise ValueError for an unknown controller, or a file without a usable policy."""
    if name.startswith(catalogue.POLICY) and suite.controller is not None:
        catalogue.controller_entry(name, scenario.carrier.name)
    else:
        check_choice("controllers", name, controllers_of(suite, scenario), why=catalogue.steers_instead(name))


def _steering(
    suite: Suite, scenario: Scenario, preset: Any, controllers: Sequence[str] | None, link: str
) -> list[Steering | None]:
    if controllers is None and suite.judges_controllers:
        controllers = default_controllers(scenario)
    if controllers is None:
        steered = preset.closed_loop and suite.controller is not None
        controllers = [str(suite.controller)] if steered else [SET_PATH]
    # Controllers that compete are tuned, and steer through a link.
    how = (scenario.carrier.name, link if suite.judges_controllers else None)
    return [None if name == SET_PATH else Steering(name, *how) for name in controllers]


def _trackers_named(
    suite: Suite, scenario: Scenario, names: Sequence[str], how: Mapping[str, Any]
) -> dict[str, TrackerSpec]:
    return {name: _tracker_of(suite, scenario, name, bool(how.get("modules"))) for name in names}


def _tracker_of(suite: Suite, scenario: Scenario, name: str, own_modules: bool) -> TrackerSpec:
    """Return a tracker that may take part. Raises ValueError for another name."""
    scene = suite.scene(scenario.id)
    entry = registry.entry_or_none(name)
    if entry is None or {suite.tracked_by(scene), suite.name}.isdisjoint(entry.suites or (DEFAULT,)):
        expected = trackers_in(suite, scene)
        if name in expected:
            return expected[name]
        known = trackers_of()
        whose = f", which is of suite {_suites_in_words(known[name].suites)}" if name in known else ""
        if not (whose or own_modules):
            whose = suggestion(name, expected) + f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("trackers", name, expected, why=whose)
    assert entry is not None
    many = not suite.follows_many or entry.follows_many
    check("trackers", many, "ones of many targets, with a method start", repr(name))
    return registered(entry)


def _suites_in_words(wanted: Sequence[str]) -> str:
    """Return the names of a tracker's suites, which a user may have misspelt."""
    return ", ".join(name if name in suites() else f"{name} (there is no such suite)" for name in wanted)


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Names that a user gives.

    Attributes:
        scenarios: () = all of the suite. presets: () = each scenario's default.
        trackers: () = the scenario's. controllers: () = all where they compete.
    """

    scenarios: tuple[str, ...] = ()
    presets: tuple[str, ...] = ()
    trackers: tuple[str, ...] = ()
    controllers: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choice:
    """What runs in one scenario, by names.

    Attributes:
        scenario: catalogue id. presets: of it.
        trackers, controllers: names; no controllers = as presets say.
    """

    scenario: str
    presets: tuple[str, ...]
    trackers: tuple[str, ...]
    controllers: tuple[str, ...]


def choices(suite: Suite, selection: Selection, *, variants: bool, absent: bool = False) -> list[Choice]:
    """Return what runs, scenario by scenario.

    Each scenario gets the given names that it knows; a scenario that knows none is left out. A name that no scenario
    knows goes to the first one, which refuses it.

    Args:
        variants: whether ablations are included by default. absent: whether trackers that are not installed are, too.

    Raises:
        ValueError: for scenarios that the suite does not have.
    """
    scenes = _scenes(suite, selection.scenarios, selection.presets)
    several = len(scenes) > 1
    among = [trackers_in(suite, scene).__contains__ for scene in scenes] if several else []
    tracking = _shared(selection.trackers, among)
    driving = _shared(selection.controllers, [partial(_steers, scene) for scene in scenes] if several else [])
    found = []
    for (scene, shown), watching, commanding in zip(scenes.items(), tracking, driving, strict=True):
        if (selection.trackers and not watching) or (selection.controllers and not commanding):
            continue
        scenario = catalog.scenario(scene.scenario)
        controllers = default_controllers(scenario, variants=variants) if suite.judges_controllers else ()
        found.append(
            Choice(
                scenario.id,
                shown,
                watching or scene.trackers or _default_trackers(suite, scene, variants, absent),
                commanding or controllers,
            )
        )
    if not found:
        wanted = f"some that {', '.join(selection.controllers)} can steer by"
        raise ValueError(f"trackers: expected {wanted}, got {', '.join(selection.trackers)}")
    return found


def _scenes(suite: Suite, scenarios: Sequence[str], presets: Sequence[str]) -> dict[Scene, tuple[str, ...]]:
    """Return the scenes, each with its presets."""
    given = [catalog.id_of(name) for name in scenarios]
    latest = [catalog.id_of(scene.scenario) for scene in suite.scenes]
    for name in given:
        if not suite.is_about(name):
            check_choice("scenario", name, latest)
    chosen = [replace(suite.scene(name), scenario=name) for name in given or latest]
    if not presets:
        return {scene: (scene.preset or suite.preset,) for scene in chosen}
    known = [partial(_has_preset, scene.scenario) for scene in chosen] if len(chosen) > 1 else []
    return {scene: share for scene, share in zip(chosen, _shared(presets, known), strict=True) if share}


def _has_preset(scenario: str, preset: str) -> bool:
    return preset in catalog.scenario(scenario).presets


def _shared(names: Sequence[str], known_by: Sequence[Callable[[str], bool]]) -> list[tuple[str, ...]]:
    """Return for each scene the names that it knows; the first scene also gets names that none knows.

    ``known_by``: empty for a single scene.
    """
    if not known_by:
        return [tuple(names)]
    shares: list[list[str]] = [[] for _ in known_by]
    for name in names:
        knowing = [share for share, knows in zip(shares, known_by, strict=True) if knows(name)]
        for share in knowing or shares[:1]:
            share.append(name)
    return [tuple(share) for share in shares]


def _steers(scene: Scene, name: str) -> bool:
    try:
        catalogue.controller_entry(name, catalog.scenario(scene.scenario).carrier.name)
    except ValueError:
        return False
    return True


def _default_trackers(suite: Suite, scene: Scene, variants: bool, absent: bool) -> tuple[str, ...]:
    """Return a scene's trackers, those that need what is not installed only if ``absent``."""
    known = {name: each for name, each in trackers_in(suite, scene).items() if absent or not each.missing()}
    return tuple(name for name, each in known.items() if variants or each.role != "variant")
