from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.run import jobs, source_files, versions
from benchmarks.run.contestants import entrant
from benchmarks.run.versions import versions_of
from benchmarks.suites.registry import register_suite, suite, suites
from scenarios import catalog
from trackers.controllers.catalogue import controller_entry

ROW = ("frame-out", "road-town-v2", "quick")


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a copy of the four packages, of which hashes are taken."""
    root = source_files.ROOT
    for package in ("sim", "trackers", "scenarios", "benchmarks"):
        for file in (root / package).rglob("*"):
            if file.suffix in (".py", ".json"):
                copy = tmp_path / file.relative_to(root)
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(file.read_bytes())
    monkeypatch.setattr(source_files, "ROOT", tmp_path)
    forget()
    yield tmp_path
    forget()


def forget() -> None:
    """Forget what files were made of."""
    versions._modules_hash.cache_clear()
    source_files._read.cache_clear()


def changed(tree: Path, file: str, added: str = "\nCHANGED = True\n") -> set[str]:
    """Return which hashes of a row change with a file of the tree."""
    before = versions_of(*ROW, entrant("background_pf"), controller_entry("centre", "helicopter"))
    path = tree / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text((path.read_text() if path.exists() else "") + added)
    forget()
    after = versions_of(*ROW, entrant("background_pf"), controller_entry("centre", "helicopter"))
    return {name for name in before if before[name] != after[name]}


def file_of(module: str) -> str:
    """Return where a module lies in the tree."""
    return f"{module.replace('.', '/')}.py"


def test_a_change_of_parameters_shows_and_only_there() -> None:
    known = entrant("colour_pf")
    other = replace(known, parameters="others")
    first, second = versions_of(*ROW, known), versions_of(*ROW, other)
    assert first.pop("tracker") != second.pop("tracker")
    assert first == second
    assert set(first) == {"frameout", "numpy", "numba", "opencv", "pybullet", "scene", "judge", "loop"}


def test_a_change_of_a_preset_shows_and_only_there(monkeypatch: pytest.MonkeyPatch) -> None:
    before = versions_of(*ROW, entrant("colour_pf"))
    presets = catalog.scenario(ROW[1]).presets
    monkeypatch.setitem(presets, ROW[2], replace(presets[ROW[2]], frame_count=70))
    after = versions_of(*ROW, entrant("colour_pf"))
    assert {name for name in before if before[name] != after[name]} == {"scene"}


def test_who_steers_shows_beside_what_tracks() -> None:
    known, centre = entrant("colour_pf"), controller_entry("centre", "helicopter")
    alone, steered = versions_of(*ROW, known), versions_of(*ROW, known, centre)
    assert {name: steered[name] for name in alone} == alone
    assert set(steered) - set(alone) == {"controller"}
    other = versions_of(*ROW, known, replace(centre, overrides={"fastest_mps": 1.0}))
    assert {name for name in steered if steered[name] != other[name]} == {"controller"}
    assert versions_of(*ROW, known, controller_entry("hold", "helicopter"))["controller"] != steered["controller"]


@pytest.mark.parametrize(
    "file",
    [
        "scenarios/fish_tank/scenario.py",
        file_of(type(catalog.scenario("stereo-follow")).__module__),
        file_of(suite("stereo").judge.__module__),
        file_of(catalog.__name__),
        file_of("trackers.registry"),
        file_of(entrant("hold").module),
        file_of(entrant("oracle_map").module),
        "sim/shaders/water.py",
    ],
)
def test_what_a_row_does_not_depend_on_leaves_it(tree: Path, file: str) -> None:
    """Another scene, another suite's judge, a tracker more: no row of this one is outdated."""
    assert changed(tree, file) == set()


def test_a_change_shows_where_it_counts(tree: Path) -> None:
    assert changed(tree, file_of("sim.world")) == {"scene"}
    assert changed(tree, file_of("benchmarks.scores.recovery")) == {"judge"}
    assert changed(tree, file_of("scenarios.loop")) == {"loop"}
    assert changed(tree, file_of(jobs.__name__)) == {"loop"}
    assert changed(tree, file_of("trackers.particle_filter")) == {"tracker"}
    assert changed(tree, file_of("trackers.controllers.centre")) == {"controller"}


def test_a_learnt_model_is_part_of_what_loads_it_alone(tree: Path) -> None:
    (model,) = tree.glob("trackers/**/road_town_classes.json")
    other = entrant("colour_pf")
    before = versions_of(*ROW, other)
    assert changed(tree, str(model.relative_to(tree)), " ") == {"tracker"}
    assert versions_of(*ROW, other) == before
    assert changed(tree, str(model.with_name("harbour.json").relative_to(tree)), "{}") == set()


def test_what_a_judge_imports_is_found_however_new_it_is(tree: Path) -> None:
    judge = file_of(suite(ROW[0]).judge.__module__)
    assert changed(tree, judge, "\nfrom benchmarks.metrics import brand_new\n") == {"judge"}
    assert changed(tree, "benchmarks/metrics/brand_new.py") == {"judge"}
    assert changed(tree, "benchmarks/metrics/brand_new.py") == {"judge"}


def test_a_new_suite_with_a_judge_of_its_own_leaves_rows_of_others(monkeypatch: pytest.MonkeyPatch) -> None:
    before = versions_of(*ROW, entrant("colour_pf"))
    monkeypatch.setattr("benchmarks.suites.registry._SUITES", dict(suites()))
    register_suite(replace(suite("frame-out"), name="other", judge=suite("stereo").judge))
    assert versions_of(*ROW, entrant("colour_pf")) == before
    assert versions_of("other", *ROW[1:], entrant("colour_pf"))["judge"] != before["judge"]
