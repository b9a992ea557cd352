"""The packages say what is public, load it only where it is asked for, and Gymnasium knows the env ids in any order."""

from __future__ import annotations

import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import benchmarks
from benchmarks.run import packages
from scenarios import catalog
from trackers import registry

ROOT = Path(__file__).parents[1]
FACES = ("scenarios", "trackers", "benchmarks")


def run(script: str) -> str:
    """Return what a fresh interpreter prints."""
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("face", FACES)
def test_every_public_name_is_there_and_hides_no_module(face: str) -> None:
    package = importlib.import_module(face)
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    assert set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        value = getattr(package, name)
        # Once a module is imported, its name in the package is the module: nothing else may be called so.
        assert (value is sys.modules.get(f"{face}.{name}")) == (name in modules), name
    with pytest.raises(AttributeError, match=f"module '{face}' has no attribute 'nix'"):
        package.nix  # noqa: B018


@pytest.mark.parametrize("module", ["trackers", "trackers.registry", "benchmarks"])
def test_gymnasium_is_not_imported_without_need(module: str) -> None:
    assert run(f"import sys, {module}; print('gymnasium' in sys.modules)") == "False"


def test_a_face_imports_nothing_but_what_python_and_gymnasium_bring() -> None:
    """So `import scenarios` costs next to nothing beside Gymnasium, whatever the machine."""
    script = "import sys, gymnasium; before = set(sys.modules); import scenarios, trackers, benchmarks; "
    script += "print(*sorted({name.partition('.')[0] for name in set(sys.modules) - before}))"
    # Of sim only the checks of names and values, which import nothing.
    ours = {*FACES, "sim"}
    assert set(run(script).split()) - set(sys.stdlib_module_names) == ours
    script = script.replace("import scenarios, trackers, benchmarks", "import trackers, benchmarks")
    assert set(run(script.replace(", gymnasium", "")).split()) - set(sys.stdlib_module_names) == ours - {
        "scenarios",
        "sim",
    }


def test_benching_one_tracker_enters_no_other_scene_reader_or_export(tmp_path: Path) -> None:
    script = "import sys, benchmarks; benchmarks.bench(trackers='hold', preset='quick', seeds=range(1), quick=True, "
    script += f"workers=0, out={str(tmp_path)!r}); print(*sys.modules)"
    ours = {name for name in run(script).split() if name.startswith(("sim.", "trackers.", "scenarios.", "benchmarks."))}
    assert len(ours) <= 212
    known = {entry.tracker.__module__ for entry in registry.entries().values()}
    assert ours & known == {"trackers.baselines.single_target"}
    assert not {name for name in ours if name.startswith("benchmarks.data.")}
    scenes = {entry.place.partition(":")[0] for entry in catalog.entries()}
    assert ours & scenes == {"scenarios.road_town.scenario"}


@pytest.mark.parametrize(
    "imports",
    [
        "import gymnasium as gym, scenarios",
        "import scenarios, gymnasium as gym",
        "from scenarios import envs; import gymnasium as gym",
    ],
)
def test_gymnasium_knows_the_ids_whichever_is_imported_first(imports: str) -> None:
    script = f"{imports}; import scenarios; print(*(name for name in gym.registry if name.startswith('frameout/')))"
    assert run(script).split() == [
        *(
            f"frameout/{name}Follow-{version}"
            for name, version in (("RoadTown", "v3"), ("Stereo", "v3"), ("FishTank", "v2"), ("Harbour", "v1"))
        ),
        "frameout/FishTankPtz-v1",
        "frameout/HarbourPtz-v1",
    ]


@pytest.mark.heavy
@pytest.mark.parametrize("before", ["", "import scenarios.catalog; "])
def test_an_id_that_names_the_module_is_made(before: str) -> None:
    script = (
        f"{before}import gymnasium as gym; env = gym.make('scenarios:frameout/RoadTownFollow-v3', tracker='hold'); "
    )
    assert run(script + "print(env.spec.id)") == "frameout/RoadTownFollow-v3"


def test_data_sets_say_what_to_install_where_their_packages_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packages, "_DATA", ("no_such_package",))
    with pytest.raises(ImportError, match=re.escape("no_such_package to be installed (pip install 'frameout[data]')")):
        benchmarks.DataSet  # noqa: B018
