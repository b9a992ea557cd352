"""The gallery's page in MyST Markdown: every scene and preset of the catalogue with a picture and a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from benchmarks.contract.suite import suites
from benchmarks.show.page import page_environment
from scenarios import catalog
from scenarios.scenario import Scenario
from tools.gallery.pictures import ShownPreset, newest_scenarios, shown_presets


@dataclass(frozen=True, slots=True)
class _Scene:
    """A scenario as the page shows it, with its presets' settings; ``older``: its earlier versions."""

    scenario: Scenario
    env_id: str
    suites: tuple[str, ...]
    presets: tuple[tuple[ShownPreset, Any], ...]
    older: tuple[Scenario, ...]


def gallery_page(pictures: str) -> str:
    """Return the scenes as Markdown, each under a heading of the second level.

    Args:
        pictures: where the page finds the folder that ``write_pictures`` filled, without a slash at its end.
    """
    scenes = [_scene(name) for name in newest_scenarios()]
    return (
        page_environment(__file__, autoescape=False)
        .get_template("gallery.md.jinja")
        .render(scenes=scenes, pictures=pictures)
    )


def _scene(name: str) -> _Scene:
    scenario = catalog.scenario(name)
    versions = [each for each in catalog.entries() if catalog.unversioned(each.id) == catalog.unversioned(name)]
    return _Scene(
        scenario,
        next(each.env_id for each in versions if each.id == name),
        tuple(suite.name for suite in suites().values() if suite.is_about(name)),
        tuple((each, scenario.presets[each.preset]) for each in shown_presets() if each.scenario == name),
        tuple(catalog.scenario(each.id) for each in versions if each.id != name),
    )
