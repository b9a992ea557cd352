"""The contestants of each scenario of a suite, from the names that users gave."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from benchmarks.run.contestants import entrants
from benchmarks.suites.registry import Scene, Suite
from scenarios import catalog
from trackers.controllers.catalogue import controller_entry, controllers


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


def parties(
    suite: Suite,
    scenarios: Sequence[str],
    presets: Sequence[str],
    trackers: Sequence[str],
    steering: Sequence[str],
    *,
    variants: bool,
) -> list[Party]:
    """Return the contestants, scenario by scenario.

    Each scenario gets the given names that it knows; a scenario that knows none is left out. A name that no scenario
    knows goes to the first one, which refuses it.

    Args:
        scenarios, trackers, steering: names that users gave; () = all of the suite, the scenario's own, and, where
            controllers are contestants, all controllers.
        presets: names, at least one. variants: whether ablations are included by default.

    Raises:
        ValueError: for scenarios that the suite does not have.
    """
    scenes = _scenes(suite, scenarios, presets)
    tracking = _shared(trackers, [partial(_tracks, suite.tracked_by(scene)) for scene in scenes])
    driving = _shared(steering, [partial(_steers, scene) for scene in scenes])
    found = []
    for (scene, shown), watching, commanding in zip(scenes.items(), tracking, driving, strict=True):
        if (trackers and not watching) or (steering and not commanding):
            continue
        found.append(
            Party(
                catalog.scenario(scene.scenario).id,
                shown,
                watching or scene.trackers or _everyone(suite.tracked_by(scene), variants),
                commanding or (_everybody(scene, variants) if suite.judges_controllers else ()),
            )
        )
    if not found:
        raise ValueError(f"trackers: expected some that {', '.join(steering)} can steer by, got {', '.join(trackers)}")
    return found


def _scenes(suite: Suite, scenarios: Sequence[str], presets: Sequence[str]) -> dict[Scene, tuple[str, ...]]:
    """Return the scenes and which of the presets are of each."""
    given = [catalog.scenario(name).id for name in scenarios]
    scenes = {catalog.scenario(scene.scenario).id: scene for scene in suite.scenes}
    for name in given:
        if name not in scenes:
            raise ValueError(f"scenario: expected one of {', '.join(scenes)}; got {name!r}")
    chosen = [scene for scenario, scene in scenes.items() if scenario in (given or scenes)]
    shares = _shared(presets, [catalog.scenario(scene.scenario).presets.__contains__ for scene in chosen])
    return {scene: share for scene, share in zip(chosen, shares, strict=True) if share}


def _shared(names: Sequence[str], known_by: Sequence[Callable[[str], bool]]) -> list[tuple[str, ...]]:
    """Return for each scene, by whether it knows a name, those of the names that are its own."""
    if len(known_by) == 1:
        return [tuple(names)]
    shares: list[list[str]] = [[] for _ in known_by]
    for name in names:
        who = [share for share, knows in zip(shares, known_by, strict=True) if knows(name)]
        for share in who or shares[:1]:
            share.append(name)
    return [tuple(share) for share in shares]


def _tracks(suite_name: str, name: str) -> bool:
    return name in entrants(suite_name)


def _steers(scene: Scene, name: str) -> bool:
    try:
        controller_entry(name, catalog.scenario(scene.scenario).carrier.name)
    except ValueError:
        return False
    return True


def _everyone(suite_name: str, variants: bool) -> tuple[str, ...]:
    everyone = entrants(suite_name)
    return tuple(name for name, who in everyone.items() if variants or who.role != "variant")


def _everybody(scene: Scene, variants: bool) -> tuple[str, ...]:
    everybody = controllers(catalog.scenario(scene.scenario).carrier.name)
    return tuple(name for name, who in everybody.items() if variants or who.role != "variant")
