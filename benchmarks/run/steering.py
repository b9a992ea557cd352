"""How a camera is steered: by a tuned controller through a link, or by one as written without a link."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from benchmarks.contract.suite import suite, suites
from scenarios import catalog
from trackers import registry
from trackers.controllers.catalogue import controller_entry, controllers
from trackers.protocols import Controller


def link_in(suite_name: str, link: str = "prompt") -> str | None:
    """Return the link of a suite's controllers when ``link`` is asked for.

    None in suites of trackers: their only controller is the paper's, as written, and the carrier gets its commands
    unchanged.
    """
    return link if suite(suite_name).judges_controllers else None


def suite_shown(scenario: str, preset: str, link: str | None) -> str:
    """Return the suite whose kind of steering is shown if users name none: one that judges controllers.

    A preset in closed loop belongs to suites of trackers and is steered as there, unless a link is asked for.
    """
    configuration = catalog.scenario(scenario).presets.get(preset)
    as_written = link is None and configuration is not None and configuration.closed_loop
    steered = (each for each in suites().values() if not each.follows_many)
    return next(each.name for each in steered if each.judges_controllers != as_written)


def suite_watching(scenario: str, tracker: str | None) -> str:
    """Return the suite whose targets are shown without a controller: one of the scenario that fits the tracker.

    A tracker of many targets is shown with all of its tracks, if a suite asks for them.
    """
    known = None if tracker is None else registry.entries().get(tracker)
    many = tracker is None or (known is not None and known.follows_many)
    own = [each for each in suites().values() if each.is_about(scenario) and not each.judges_controllers]
    fitting = [each for each in own if each.follows_many and many] or [each for each in own if not each.follows_many]
    return fitting[0].name if fitting else suite_shown(scenario, "", None)


def controller_maker(name: str, carrier: str, link: str | None, values: Mapping[str, Any]) -> Callable[[], Controller]:
    """Return what makes a controller that steers a carrier through a link, see ``link_in``.

    Args:
        values: parameter values in place of the tuned ones; with a link only.

    Raises:
        ValueError: for an unknown name.
    """
    entry = controller_entry(name, carrier)
    return entry.create_as_written if link is None else partial(entry.create, **values)


def default_controllers(scenario: str, *, variants: bool = False) -> tuple[str, ...]:
    """Return the controllers of a scenario that steer where none are named, ablations only with ``variants``."""
    known = controllers(catalog.scenario(scenario).carrier.name)
    return tuple(name for name, entry in known.items() if variants or entry.role != "variant")
