"""Which way a camera is steered: by a controller as tuned, through a link, or as written, without one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.suites.registry import suite, suites
from scenarios import catalog
from trackers import registry
from trackers.controllers.catalogue import controller_entry
from trackers.protocols import Controller


def link_in(suite_name: str, link: str = "prompt") -> str | None:
    """Return the link through which controllers steer in a suite where ``link`` is asked for.

    None in suites of trackers: they have one controller for all, the paper's, as it was written, and the carrier gets
    its commands as they are.
    """
    return link if suite(suite_name).judges_controllers else None


def suite_shown(scenario: str, preset: str, link: str | None) -> str:
    """Return the suite whose way of steering is shown where users name none: one that judges controllers.

    A preset that is steered by itself belongs to suites of trackers, and is shown as they have it unless a link is
    asked for.
    """
    configuration = catalog.scenario(scenario).presets.get(preset)
    as_written = link is None and configuration is not None and configuration.closed_loop
    steered = (each for each in suites().values() if not each.follows_many)
    return next(each.name for each in steered if each.judges_controllers != as_written)


def suite_watching(scenario: str, tracker: str | None) -> str:
    """Return the suite whose targets are shown where no controller is named: the scenario's own that fits the tracker.

    A tracker of many targets is shown with all of its tracks, if a suite asks for them.
    """
    known = None if tracker is None else registry.entries().get(tracker)
    many = tracker is None or (known is not None and known.follows_many)
    own = [each for each in suites().values() if each.is_about(scenario) and not each.judges_controllers]
    fitting = [each for each in own if each.follows_many and many] or [each for each in own if not each.follows_many]
    return fitting[0].name if fitting else suite_shown(scenario, "", None)


def controller_for(name: str, carrier: str, link: str | None, values: Mapping[str, Any]) -> Controller:
    """Return a fresh controller that steers a carrier through a link, see ``link_in``.

    Args:
        values: of its parameters, other than those it was tuned to; for one that steers through a link.

    Raises:
        ValueError: for an unknown name or parameter.
    """
    entry = controller_entry(name, carrier)
    return entry.create_as_written() if link is None else entry.create(**values)
