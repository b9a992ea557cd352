"""The contestants of each scenario of a suite, from users' names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from benchmarks.contract.suite import Scene, Suite
from benchmarks.run.contestants import entrants_of
from benchmarks.run.steering import default_controllers
from scenarios import catalog
from sim.checks import check_choice
from trackers.controllers.catalogue import controller_entry


@dataclass(frozen=True, slots=True)
class Party:
    """The contestants of one scenario.

    Attributes:
        scenario: catalogue id. presets: of it.
        trackers, controllers: names; no controllers = as presets say.
    """

    scenario: str
    presets: tuple[str, ...]
    trackers: tuple[str, ...]
    controllers: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Asked:
    """Names that a user gives.

    Attributes:
        scenarios: () = all of the suite. presets: () = each scenario's default.
        trackers: () = the scenario's. controllers: () = all where they are contestants.
    """

    scenarios: tuple[str, ...] = ()
    presets: tuple[str, ...] = ()
    trackers: tuple[str, ...] = ()
    controllers: tuple[str, ...] = ()


def parties(suite: Suite, asked: Asked, *, variants: bool, absent: bool = False) -> list[Party]:
    """Return the contestants, scenario by scenario.

    Each scenario gets the given names that it knows; a scenario that knows none is left out. A name that no scenario
    knows goes to the first one, which refuses it.

    Args:
        variants: whether ablations are included by default. absent: whether trackers that are not installed are, too.

    Raises:
        ValueError: for scenarios that the suite does not have.
    """
    scenes = _scenes(suite, asked.scenarios, asked.presets)
    tracking = _shared(asked.trackers, [entrants_of(suite, scene).__contains__ for scene in scenes])
    driving = _shared(asked.controllers, [partial(_steers, scene) for scene in scenes])
    found = []
    for (scene, shown), watching, commanding in zip(scenes.items(), tracking, driving, strict=True):
        if (asked.trackers and not watching) or (asked.controllers and not commanding):
            continue
        found.append(
            Party(
                catalog.scenario(scene.scenario).id,
                shown,
                watching or scene.trackers or _default_trackers(suite, scene, variants, absent),
                commanding or _default_controllers(suite, scene, variants),
            )
        )
    if not found:
        wanted = f"some that {', '.join(asked.controllers)} can steer by"
        raise ValueError(f"trackers: expected {wanted}, got {', '.join(asked.trackers)}")
    return found


def _scenes(suite: Suite, scenarios: Sequence[str], presets: Sequence[str]) -> dict[Scene, tuple[str, ...]]:
    """Return the scenes, each with its presets."""
    given = [catalog.scenario(name).id for name in scenarios]
    latest = [catalog.scenario(scene.scenario).id for scene in suite.scenes]
    for name in given:
        if not suite.is_about(name):
            check_choice("scenario", name, latest)
    chosen = [replace(suite.scene(name), scenario=name) for name in given or latest]
    if not presets:
        return {scene: (scene.preset or suite.preset,) for scene in chosen}
    shares = _shared(presets, [catalog.scenario(scene.scenario).presets.__contains__ for scene in chosen])
    return {scene: share for scene, share in zip(chosen, shares, strict=True) if share}


def _shared(names: Sequence[str], known_by: Sequence[Callable[[str], bool]]) -> list[tuple[str, ...]]:
    """Return for each scene the names that it knows; the first scene also gets names that none knows."""
    if len(known_by) == 1:
        return [tuple(names)]
    shares: list[list[str]] = [[] for _ in known_by]
    for name in names:
        knowing = [share for share, knows in zip(shares, known_by, strict=True) if knows(name)]
        for share in knowing or shares[:1]:
            share.append(name)
    return [tuple(share) for share in shares]


def _steers(scene: Scene, name: str) -> bool:
    try:
        controller_entry(name, catalog.scenario(scene.scenario).carrier.name)
    except ValueError:
        return False
    return True


def _default_trackers(suite: Suite, scene: Scene, variants: bool, absent: bool) -> tuple[str, ...]:
    """Return a scene's entrants, those that need what is not installed only if ``absent``."""
    known = {name: each for name, each in entrants_of(suite, scene).items() if absent or each.available()}
    return tuple(name for name, each in known.items() if variants or each.role != "variant")


def _default_controllers(suite: Suite, scene: Scene, variants: bool) -> tuple[str, ...]:
    return default_controllers(scene.scenario, variants=variants) if suite.judges_controllers else ()
