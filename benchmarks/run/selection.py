"""From names to what is run: trackers, controllers, episodes. Commands look things up here, once."""

from __future__ import annotations

import dataclasses
import importlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, NamedTuple, cast, get_args

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import DEFAULT, Scene, Suite, suite, suites
from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.contract.varied import Varied, base_of, varied
from benchmarks.run.blindfold import Blindfolded, ManyBlindfolded
from benchmarks.run.editions import preset_edition
from benchmarks.run.episodes import EpisodeSpec, Simulated, Steering, simulated
from benchmarks.run.experiment import Experiment
from benchmarks.run.jobs import Job
from benchmarks.run.own_inputs import own
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.stale_kernels import forget_stale_kernels
from scenarios import catalog
from scenarios.command_link import LINKS
from scenarios.field_values import with_values
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
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
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
        assert named.scenario is not None
        return Blindfolded(tracker, named.scenario.target)

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
    same = {field: getattr(entry, field) for field in ("name", "role", "summary", "edition", "reproducible")}
    own = {"suites": entry.suites or (DEFAULT,), "parameters": entry.parameters(**values)}
    return Registered(**same, **own, module=entry.tracker.__module__, entry=entry)


def trackers_of(*suite_names: str) -> dict[str, TrackerSpec]:
    """Return all trackers and references, or those of some suites, by name: in order of registration, references."""
    references = (each for suite in suites().values() for each in suite.references)
    known = (*map(registered, registry.entries().values()), *references)
    return {each.name: each for each in known if not suite_names or not set(suite_names).isdisjoint(each.suites)}


def trackers_in(suite: Suite, scene: Scene, added: Mapping[str, TrackerSpec]) -> dict[str, TrackerSpec]:
    """Return all that may take part in a scene of a suite, by name: its trackers, those of the suite itself, and of
    those that a user has ``added``.
    """
    ours = {name: each for name, each in added.items() if _enters(each, suite, scene)}
    return trackers_of(suite.tracked_by(scene)) | trackers_of(suite.name) | ours


def _enters(tracker: TrackerSpec, suite: Suite, scene: Scene) -> bool:
    return not {suite.tracked_by(scene), suite.name}.isdisjoint(tracker.suites)


def tracker_named(name: str, **values: Any) -> TrackerSpec:
    """Return one tracker or reference; a tracker with ``values`` of its parameters, if any are given.

    ``NAME[PARAMETER=VALUE]`` is a tracker too, see ``contract.varied``.

    Raises:
        ValueError: for an unknown name; lists the known ones.
    """
    if (other := with_value(name)) is not None:
        return other
    entry = registry.entry(name) if values else registry.entry_or_none(name)
    if entry is not None:
        return registered(entry, **values)
    known = trackers_of()
    if name not in known:
        unknown = f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("tracker", name, known, why=suggestion(name, known) or unknown)
    return known[name]


def with_value(name: str) -> Registered | None:
    """Return the tracker ``NAME[PARAMETER=VALUE]``; None for a name without a parameter.

    Raises:
        ValueError: for an unknown tracker or parameter, and for what is no value of it.
    """
    found = varied(name)
    if found is None:
        return None
    entry = registry.entry(found.base)
    try:
        value = json.loads(found.value)
    except ValueError:
        value = found.value
    fields = {field.name: field for field in dataclasses.fields(entry.parameters_class)}
    usual = fields[found.parameter].default if found.parameter in fields else None
    if isinstance(usual, int) and not isinstance(usual, bool):
        whole = isinstance(value, int) and not isinstance(value, bool)
        check(f"{found.base}.{found.parameter}", whole, "a whole number", repr(found.value))
    return registered(entry, **{found.parameter: value})


def varied_names(words: Sequence[str]) -> tuple[str, ...]:
    """Return the trackers' names that ``NAME.PARAMETER=V1,V2,…`` stand for.

    Raises:
        ValueError: for other words, and for what ``with_value`` refuses.
    """
    names = []
    for word in words:
        match = re.fullmatch(r"(\w+)\.(\w+)=([^=,\[\]]+(?:,[^=,\[\]]+)*)", word)
        check("vary", match is not None, "NAME.PARAMETER=V1,V2,…, such as colour_pf.particles=50,200", repr(word))
        assert match is not None
        names += [str(Varied(match[1], match[2], value.strip())) for value in match[3].split(",")]
    for name in names:
        with_value(name)
    return tuple(dict.fromkeys(names))


def default_controllers(scenario: Scenario, *, variants: bool = False) -> tuple[str, ...]:
    """Return the controllers of a scenario that steer where none are named, ablations only with ``variants``."""
    known = catalogue.controllers(scenario.carrier.name)
    return tuple(name for name, entry in known.items() if variants or entry.role != "variant")


def check_renderer(name: str) -> RendererName:
    """Return a renderer's name. Raises ValueError for an unknown one."""
    check_choice("renderer", name, get_args(RendererName))
    return cast(RendererName, name)


def experiment_on(
    judging: Suite | str,
    scenario: str,
    presets: Sequence[str] | Mapping[str, Any],
    trackers: Sequence[str] | Mapping[str, TrackerSpec],
    seeds: Sequence[int],
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
    for name in controllers or ():
        _check_controller(judged, scene, name)
    check_choice("link", link, LINKS)
    if not isinstance(trackers, Mapping):
        trackers = {name: _tracker_of(judged, scene, name, {}, bool(how.get("modules"))) for name in trackers}
    drawn = check_renderer(renderer)
    got = f"{seeds.start}:{seeds.stop}" if isinstance(seeds, range) else list(seeds)
    check("seeds", len(seeds) > 0 and min(seeds) >= 0, "A:B with 0 <= A < B", got)
    if not isinstance(presets, Mapping):
        for name in presets:
            # Else a mesh that is missing would be named when the folder of results is made already.
            preset_edition(scene.id, name)
    episodes = [
        Simulated(scene, name, seed, configuration, drawn, steering)
        for seed in seeds
        for name in presets
        for configuration in [presets[name] if isinstance(presets, Mapping) else scene.configuration(name, seed)]
        for steering in _steering(judged, scene, configuration, controllers, link)
    ]
    return Experiment(judged, episodes, trackers, **how)


def job_on(
    judging: Suite | str,
    scenario: str,
    preset: str,
    seed: int,
    trackers: Sequence[str] | Mapping[str, TrackerSpec] = (),
    *,
    controller: str | None = None,
    link: str | None = None,
    renderer: str = "raster",
    **how: Any,
) -> Job:
    """Return the job of one episode by names; ``link`` None = commands arrive unchanged. ``trackers``: see
    ``experiment_on``, ``how``: see ``Job``.

    Raises:
        ValueError: for unknown names.
    """
    judged = suite(judging) if isinstance(judging, str) else judging
    drawn = check_renderer(renderer)
    episode = simulated(scenario, preset, seed, renderer=drawn, controller=controller, link=link)
    if not isinstance(trackers, Mapping):
        trackers = {name: tracker_named(name) for name in trackers}
    return Job(judged, episode, trackers, **how)


def job_of(row: Row, seed: int, episode: EpisodeSpec | None = None) -> Job:
    """Return the job that repeats the run of a row, on this ``seed``; on ``episode`` of what is real."""
    steered = {"controller": row["controller"], "link": row.get("link"), "renderer": row["renderer"]}
    how: Any = {"modules": tuple(row.get("modules", ())), "real_time_hz": row.get("real_time_hz")}
    how |= {"limit_s": row.get("limit_s", Job.limit_s), "repeats": 1}
    name = row["tracker"]
    added = process_trackers([row["process"]] if "process" in row else [], how["limit_s"])
    tracker = {name: added.get(name) or tracker_named(name)}
    if episode is not None:
        return Job(suite(row["suite"]), episode, tracker, **how)
    return job_on(row["suite"], row["scenario"], row["preset"], seed, tracker, **steered, **how)


def _check_controller(suite: Suite, scenario: Scenario, name: str) -> None:
    """Raise ValueError for an unknown controller, or a file without a usable policy."""
    carrier = scenario.carrier.name
    if name.startswith(catalogue.POLICY) and suite.controller is not None:
        catalogue.controller_entry(name, carrier)
        return
    on_set_path = () if suite.judges_controllers else (SET_PATH,)
    steering = () if suite.controller is None else tuple(catalogue.controllers(carrier))
    check_choice("controllers", name, on_set_path + steering, why=catalogue.steers_instead(name))


def _steering(
    suite: Suite, scenario: Scenario, preset: Any, controllers: Sequence[str] | None, link: str
) -> list[Steering | None]:
    if controllers is None:
        usual = suite.controller if preset.closed_loop and suite.controller else SET_PATH
        controllers = default_controllers(scenario) if suite.judges_controllers else [usual]
    # Controllers that compete are tuned, and steer through a link.
    how = (scenario.carrier.name, link if suite.judges_controllers else None)
    return [None if name == SET_PATH else Steering(name, *how) for name in controllers]


def _tracker_of(
    suite: Suite, scenario: Scenario, name: str, added: Mapping[str, TrackerSpec], own_modules: bool
) -> TrackerSpec:
    """Return a tracker that may take part. Raises ValueError for another name."""
    if (other := with_value(name)) is not None:
        _tracker_of(suite, scenario, base_of(name), added, own_modules)
        return other
    scene = suite.scene(scenario.id)
    entry = registry.entry_or_none(name)
    if entry is None or {suite.tracked_by(scene), suite.name}.isdisjoint(entry.suites or (DEFAULT,)):
        expected = trackers_in(suite, scene, added)
        if name in expected:
            return expected[name]
        known = {**trackers_of(), **added}
        whose = f", which is of suite {', '.join(known[name].suites)}" if name in known else ""
        if not (whose or own_modules):
            whose = suggestion(name, expected) + f"{registry.OWN_NEEDS_MODULE} (--modules; in Python modules=)"
        check_choice("trackers", name, expected, why=whose)
    assert entry is not None
    many = not suite.follows_many or entry.follows_many
    check("trackers", many, "ones of many targets, with a method start", repr(name))
    return registered(entry)


class Choice(NamedTuple):
    """What runs in one scenario, by names.

    Attributes:
        scenario: catalogue id. presets: of it.
        trackers: by name. controllers: names; none = as presets say.
    """

    scenario: str
    presets: tuple[str, ...]
    trackers: Mapping[str, TrackerSpec]
    controllers: tuple[str, ...]


def choices(
    suite: Suite,
    *,
    scenarios: Sequence[str] = (),
    presets: Sequence[str] = (),
    settings: Sequence[str] = (),
    trackers: Sequence[str] = (),
    controllers: Sequence[str] = (),
    added: Mapping[str, TrackerSpec] = MappingProxyType({}),
    variants: bool,
    own_modules: bool = False,
) -> list[Choice]:
    """Return what runs, scenario by scenario, of the names that a user gives.

    Each scenario gets the given names that it knows; a scenario that knows none is left out. A name that no scenario
    knows goes to the first one, which refuses it.

    Args:
        scenarios: () = all of the suite. presets: () = each scenario's default. settings: values of their fields.
        trackers: () = the scenario's, and those ``added``. controllers: () = all where they compete.
        added: trackers that a user brings, by name.
        variants: whether ablations are included by default.
        own_modules: whether modules of the user's were imported.

    Raises:
        ValueError: for scenarios and trackers that the suite does not have.
    """
    latest = [catalog.id_of(scene.scenario) for scene in suite.scenes]
    given = [catalog.id_of(name) for name in scenarios]
    for name in given:
        if not suite.is_about(name):
            check_choice("scenario", name, latest)
    scenes = [replace(suite.scene(name), scenario=name) for name in given or latest]
    shown: list[tuple[str, ...]] = [(scene.preset or suite.preset,) for scene in scenes]
    if presets:
        shown = _shared(presets, scenes, lambda scene, name: catalog.scenario(scene.scenario).has_preset(name))
        scenes = [scene for scene, share in zip(scenes, shown, strict=True) if share]
    shown = [tuple(with_values(name, settings) for name in share) for share in shown]
    found = []
    for scene, its_presets, its_trackers, its_controllers in zip(
        scenes,
        filter(None, shown),
        _shared(trackers, scenes, lambda scene, name: base_of(name) in trackers_in(suite, scene, added)),
        _shared(controllers, scenes, _steers),
        strict=True,
    ):
        if (trackers and not its_trackers) or (controllers and not its_controllers):
            continue
        scenario = catalog.scenario(scene.scenario)
        if suite.judges_controllers:
            its_controllers = its_controllers or default_controllers(scenario, variants=variants)
        entered = (name for name, each in added.items() if _enters(each, suite, scene))
        usual = (*scene.trackers, *entered) if scene.trackers else ()
        # All trackers are imported where none is named alone.
        its_trackers = (
            its_trackers
            or usual
            or tuple(
                name
                for name, each in trackers_in(suite, scene, added).items()
                if not each.missing() and (variants or each.role != "variant")
            )
        )
        chosen = {name: _tracker_of(suite, scenario, name, added, own_modules) for name in its_trackers}
        found.append(Choice(scenario.id, its_presets, chosen, its_controllers))
    check("trackers", bool(found), f"some that {', '.join(controllers)} can steer by", ", ".join(trackers))
    return found


def _shared(
    names: Sequence[str], scenes: Sequence[Scene], knows: Callable[[Scene, str], bool]
) -> list[tuple[str, ...]]:
    """Return for each scene the names that it knows; the first scene also gets names that none knows."""
    if len(scenes) == 1:
        return [tuple(names)]
    known = {(scene, name) for scene in scenes for name in names if knows(scene, name)}
    unknown = [name for name in names if not any((scene, name) in known for scene in scenes)]
    return [
        tuple(name for name in names if (scene, name) in known or (scene is scenes[0] and name in unknown))
        for scene in scenes
    ]


def _steers(scene: Scene, name: str) -> bool:
    try:
        catalogue.controller_entry(name, catalog.scenario(scene.scenario).carrier.name)
    except ValueError:
        return False
    return True
