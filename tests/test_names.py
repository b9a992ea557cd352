"""No general room names a scene, a suite or a carrier: what it needs of one, the scene or its suite supplies."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from benchmarks.contract import suite as suite_registry
from scenarios import catalog
from trackers import registry as tracker_registry
from trackers.controllers import catalogue

ROOT = Path(__file__).parents[1]
GENERAL = tuple(f"trackers/controllers/{name}.py" for name in ("catalogue", "policy"))
"""Modules in these rooms that serve all of their kind."""
LISTS = {
    "scenarios/catalog.py": ("_ENTRIES", "SUCCESSORS"),
    "benchmarks/contract/suite.py": ("_MODULES",),
    "benchmarks/contract/rows.py": ("EVENT_COLUMNS",),
    "benchmarks/show/showing.py": ("_SHOWN",),
    "trackers/registry.py": ("_MODULES",),
    "trackers/controllers/catalogue.py": ("_MODULES",),
    "tools/scale.py": ("_SCENES", "_TINY"),
}
"""The one list of each registry, that of what took the place of deleted ids, that of columns of rows, and what a tool
measures."""
FOREIGN = {"benchmarks/learning/rollouts/lerobot.py": ("robot_type",)}
"""Words of others' formats."""


SCENES = tuple(entry for entry in catalog.entries() if entry.place.startswith("scenarios."))
SUITES = suite_registry._MODULES
"""Ours alone: other tests register scenes and suites of theirs."""


def own_rooms() -> tuple[str, ...]:
    """Return the folders and modules of a scene or a suite, of the papers, of trackers and controllers made for one."""
    scenes = [entry.place.partition(":")[0] for entry in SCENES]
    modules = [*scenes, *SUITES.values(), *tracker_registry._MODULES]
    modules += [f"trackers.controllers.{module}" for named in catalogue._MODULES.values() for module in named.values()]
    paths = [Path(*module.split(".")) for module in modules]
    shown = ["benchmarks/show/suites/", *(f"benchmarks/show/video/{name}.py" for name in ("fish", "harbour", "stereo"))]
    return (
        "benchmarks/papers/",
        "tools/learn/",
        *shown,
        *{f"{path.parent}/" if len(path.parts) > 2 else f"{path}.py" for path in paths},
    )


@cache
def patterns() -> tuple[re.Pattern[str], re.Pattern[str]]:
    """Return what matches names in identifiers and modules, and what matches them in strings.

    ``road-town`` in any spelling is a name wherever it stands; a suite that is called by a plain word (``follow``) is
    named by a module of its room, and by a string that holds nothing else or sets it off by a path or a command.
    """
    scenarios = [catalog.scenario(entry.id) for entry in SCENES]
    names = {catalog.unversioned(each.id) for each in scenarios} | {each.carrier.name for each in scenarios}
    names |= {name for name in SUITES if "-" in name}
    spelt = {form for name in names for form in (name, name.replace("-", "_"), name.replace("-", " "))}
    spelt |= {form.upper() for form in spelt}
    capital = "|".join(name.title().replace("-", "") for name in names)
    plain = "|".join(name for name in SUITES if "-" not in name)
    anywhere = rf"(?<![A-Za-z])(?:{'|'.join(spelt)})(?![a-z])|(?:{capital})(?![a-z])|\bjudges\.(?:{plain})\b"
    alone = rf"(?:^|/|\b(?:suite|bench|compare) )(?:{plain})(?:$|/| )"
    return re.compile(anywhere), re.compile(f"{anywhere}|{alone}")


def words_of(tree: ast.Module) -> Iterator[tuple[int, str, bool]]:
    """Yield line, text, and whether it is a string, of all that a module says but for docstrings."""
    docstrings = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        match node:
            case ast.Constant(value=str(text)) if node not in docstrings:
                yield line, text, True
            case ast.ImportFrom():
                yield from ((line, f"{node.module}.{alias.name}", False) for alias in node.names)
            case ast.alias(name=text, asname=other):
                yield from ((line, each, False) for each in (text, other or ""))
            case (
                ast.Name(id=text)
                | ast.Attribute(attr=text)
                | ast.arg(arg=text)
                | ast.keyword(arg=str(text))
                | ast.FunctionDef(name=text)
                | ast.ClassDef(name=text)
            ):
                yield line, text, False


def without_list(tree: ast.Module, name: str) -> ast.Module:
    """Return a module without the first assignment to ``name`` at its top level, if there is one."""

    def is_it(node: ast.stmt) -> bool:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        return isinstance(target, ast.Name) and target.id == name and getattr(node, "value", None) is not None

    first = next((node for node in tree.body if is_it(node)), None)
    return ast.Module([node for node in tree.body if node is not first], [])


def named_in(place: str, source: str) -> list[str]:
    """Return where a module names a scene, a suite or a carrier, but for its registry's list."""
    tree = ast.parse(source)
    for name in LISTS.get(place, ()):
        tree = without_list(tree, name)
    in_code, in_strings = patterns()
    return [
        f"{place}:{line}: {text!r}"
        for line, text, is_string in words_of(tree)
        if text not in FOREIGN.get(place, ()) and (in_strings if is_string else in_code).search(text)
    ]


def general_modules() -> list[str]:
    packages = ("sim", "trackers", "scenarios", "benchmarks", "tools")
    places = [path.relative_to(ROOT).as_posix() for name in packages for path in sorted((ROOT / name).rglob("*.py"))]
    return [place for place in places if place in GENERAL or not place.startswith(own_rooms())]


@pytest.mark.heavy
def test_general_rooms_name_no_scene_no_suite_and_no_carrier() -> None:
    places = general_modules()
    assert set(LISTS) | set(GENERAL) <= set(places)
    assert all((ROOT / room).exists() for room in own_rooms())
    found = [line for place in places for line in named_in(place, (ROOT / place).read_text())]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "source",
    [
        "from scenarios.road_town.scenario import ROAD_TOWN",
        "from scenarios import stereo_follow as scene",
        "import benchmarks.judges.follow.suite",
        "from benchmarks.judges import stereo",
        "def f(env='frameout/RoadTownFollow-v3'): pass",
        "x = scenario.id == 'stereo-follow-v2'",
        "x = rows['frame_out']",
        "x = f'{place}/results/follow'",
        "x = suite('stereo')",
        "print(f'judge it: frameout bench follow --controllers {name}')",
        "x = module.ROAD_TOWN_PRESETS",
        "def is_helicopter(carrier): pass",
        "class RobotDrawing: pass",
        "f(robot_width_m=1)",
        "'a docstring'; x = 'paper_sheet'",
    ],
)
def test_a_name_is_found(source: str) -> None:
    assert named_in("sim/planted.py", source)
    assert named_in("scenarios/catalog.py", f"_ENTRIES = ()\n{source}")


def test_what_names_nothing_passes() -> None:
    source = (
        '"""The robot of stereo-follow."""\nfrom scenarios.envs.follow_env import FollowEnv\nside = exits.follow(s)'
    )
    assert not named_in(
        "sim/planted.py", f"{source}\nx = 'a stereo pair: frame-outs that follow'\n'''As ``road-town``.'''"
    )


@pytest.mark.parametrize("place", LISTS)
def test_a_list_of_a_registry_is_one(place: str) -> None:
    tree = ast.parse((ROOT / place).read_text())
    assert all(len(without_list(tree, name).body) == len(tree.body) - 1 for name in LISTS[place])
    empty = "".join(f"{name} = ()\n" for name in LISTS[place])
    for name in LISTS[place]:
        full = empty.replace(f"{name} = ()", f"{name} = ('road-town', 'benchmarks.judges.follow.suite')")
        assert not named_in(place, full)
        assert named_in(place, f"{full}{name} += ('stereo-follow',)")
    assert named_in(place, f"{empty}OTHERS = ('road-town',)")
