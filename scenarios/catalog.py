"""Every scenario by its catalogue id."""

from __future__ import annotations

import pkgutil
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenarios.envs.registration import register_env
from sim.checks import check_choice, suggestion

if TYPE_CHECKING:
    from scenarios.scenario import Scenario, Survey


def unversioned(name: str) -> str:
    """Return a scenario's id without its version."""
    return name.rsplit("-v", 1)[0]


@dataclass(frozen=True)
class Entry:
    """A scenario's description, available without importing its modules, which takes seconds.

    Attributes:
        id: catalogue id with its version. place: ``module:name`` of the ``Scenario``.
        env_id: Gymnasium's id of its env, '' if there is none.
        tracker, preset: defaults of that env.
        survey: ``module:name`` of its ``Survey``, '' if there is none.
        is_next: whether tables do not rest on it yet: an id without a version means the one before.
    """

    id: str
    place: str
    env_id: str = ""
    tracker: str = ""
    preset: str = "standard"
    survey: str = ""
    is_next: bool = False


_ENTRIES: tuple[Entry, ...] = (
    Entry(
        "road-town-v2",
        "scenarios.road_town.scenario:ROAD_TOWN",
        "frameout/RoadTownFollow-v3",
        "mosaic_graph_pf",
        survey="scenarios.road_town.survey:FRAME_OUTS",
    ),
    Entry(
        "road-town-v3",
        "scenarios.road_town.scenario:ROAD_TOWN_NEXT",
        survey="scenarios.road_town.survey:FRAME_OUTS_NEXT",
        is_next=True,
    ),
    Entry(
        "stereo-follow-v2",
        "scenarios.stereo_follow.scenario:STEREO_FOLLOW",
        "frameout/StereoFollow-v3",
        "stereo_people",
    ),
    Entry("fish-tank-v1", "scenarios.fish_tank.scenario:FISH_TANK", "frameout/FishTankFollow-v2", "shoal_chain"),
    Entry(
        "harbour-v1",
        "scenarios.harbour.scenario:HARBOUR",
        "frameout/HarbourFollow-v1",
        "harbour_watch",
        preset="patrol",
    ),
    Entry(
        "fish-tank-ptz-v1", "scenarios.fish_tank.ptz:FISH_TANK_PTZ", "frameout/FishTankPtz-v1", "panorama_difference"
    ),
    Entry("harbour-ptz-v1", "scenarios.harbour.ptz:HARBOUR_PTZ", "frameout/HarbourPtz-v1", "panorama_difference"),
    Entry("paper-sheet-v1", "scenarios.paper_sheet.scenario:PAPER_SHEET"),
)
"""In order of publication: a later version of a scenario stands after an earlier one. Add yours here."""
DEFAULT = unversioned(_ENTRIES[0].id)
DEFAULT_ENV = next(entry.env_id for entry in reversed(_ENTRIES) if unversioned(entry.id) == DEFAULT and entry.env_id)
"""Default scenario and env of the commands."""
SUCCESSORS: Mapping[str, str] = {
    "road-town-v1": "road-town-v2",
    "frameout/RoadTownFollow-v1": "frameout/RoadTownFollow-v3",
    "frameout/RoadTownFollow-v2": "frameout/RoadTownFollow-v3",
    "stereo-follow-v1": "stereo-follow-v2",
    "frameout/StereoFollow-v1": "frameout/StereoFollow-v3",
    "frameout/StereoFollow-v2": "frameout/StereoFollow-v3",
    "frameout/FishTankFollow-v1": "frameout/FishTankFollow-v2",
}
"""Id of a scenario or env that has been deleted → what took its place. A deleted id is never given again."""


def register(entry: Entry) -> None:
    """Add a scenario, and its env to Gymnasium. Raises ValueError if another scenario has its id or its env's."""
    global _ENTRIES
    if entry not in _ENTRIES:
        if entry.id in names():
            raise ValueError(f"scenario: expected an id that is free, got {entry.id!r}")
        if entry.env_id in envs():
            raise ValueError(f"env_id: expected an id that is free, got {entry.env_id!r}")
        _register_env(entry)
        _ENTRIES = (*_ENTRIES, entry)


def _register_env(entry: Entry) -> None:
    if entry.env_id:
        register_env(entry.env_id, entry.id, entry.tracker)


def entries() -> tuple[Entry, ...]:
    """Return all entries."""
    return _ENTRIES


def names() -> tuple[str, ...]:
    """Return the ids of all scenarios, with their versions."""
    return tuple(entry.id for entry in _ENTRIES)


def envs() -> dict[str, tuple[str, str]]:
    """Return env id -> catalogue id and default tracker."""
    return {entry.env_id: (entry.id, entry.tracker) for entry in _ENTRIES if entry.env_id}


def env_preset(name: str) -> str:
    """Return the default preset of a scenario's env. Raises ValueError for an unknown name."""
    return _entry(name).preset


def scenario(name: str) -> Scenario:
    """Return a scenario by id; an id without a version (``road-town``) means the latest version that tables rest on.

    Raises:
        ValueError: for an unknown name; lists the known ones. For a deleted one; names its successor. For a scenario
            with another id than its entry.
    """
    entry = _entry(name)
    found: Scenario = pkgutil.resolve_name(entry.place)
    if found.id != entry.id:
        raise ValueError(f"scenario: expected {entry.place} to have its entry's id {entry.id!r}, got {found.id!r}")
    return found


def id_of(name: str) -> str:
    """Return a scenario's id with its version, without importing it. Raises ValueError for an unknown name."""
    return _entry(name).id


def survey(name: str) -> Survey | None:
    """Return a scenario's survey, None if it has none. Raises ValueError for an unknown name."""
    place = _entry(name).survey
    return pkgutil.resolve_name(place) if place else None


def check_env(name: str) -> None:
    """Raise ValueError for an unknown env id, see ``scenario``."""
    _check_id("env", name, envs())


def _entry(name: str) -> Entry:
    # Without its version a name is the latest one's that tables rest on.
    known = {unversioned(entry.id): entry for entry in _ENTRIES if not entry.is_next}
    known |= {entry.id: entry for entry in _ENTRIES}
    _check_id("scenario", name, known)
    return known[name]


def _check_id(parameter: str, name: str, known: Collection[str]) -> None:
    if name in SUCCESSORS:
        raise ValueError(f"{parameter}: expected {SUCCESSORS[name]}, which took its place, got {name!r}")
    own = "; one of your own is known once its module is imported (--modules)"
    check_choice(parameter, name, known, why=suggestion(name, known) or own)


for _entry_of_ours in _ENTRIES:
    _register_env(_entry_of_ours)
