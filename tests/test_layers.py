"""Who may know whom: the import-linter contracts of pyproject.toml hold, and each of them can fail."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from itertools import pairwise
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("sim", "trackers", "scenarios", "benchmarks", "tools")
ROOMS = ("contract", "statistics", "judges", "run", "show", "data", "learning", "papers", "cli")
"""Of benchmarks, the lowest first; learning and papers lie beside one another."""
VAGUE_NAMES = {"utils", "util", "common", "helpers", "helper", "base", "misc"}
SEEDED = {"Generator", "PCG64", "Philox", "SeedSequence", "default_rng"}
NO_DRAW = {"get_state", "set_state", "getstate", "setstate"}
"""Functions that keep the state of users' trackers, whose draws are theirs."""


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run import-linter on the packages in ``folder`` with our contracts."""
    program = Path(sys.executable).with_name("lint-imports")
    command = [str(program), "--no-cache", "--config", str(ROOT / "pyproject.toml")]
    # Without PYTHONPATH it would look at the installed packages instead.
    return subprocess.run(
        command, cwd=folder, env={"PYTHONPATH": str(folder)}, capture_output=True, text=True, check=False
    )


def write_tree(folder: Path, module: str, source: str) -> None:
    """Write packages that keep the contracts, but for ``source`` in ``module``."""
    files = {f"{package}/__init__.py": "" for package in PACKAGES}
    files |= {
        "sim/bullet.py": "import pybullet\n",
        "sim/world.py": "",
        "trackers/types.py": "",
        "trackers/protocols.py": "",
    }
    files |= {"trackers/registry.py": "", "scenarios/town.py": "import sim.world\nimport trackers.types\n"}
    files |= {f"benchmarks/{room}/__init__.py": "" for room in ROOMS}
    files |= {"benchmarks/cli/main.py": "import scenarios.town\nimport trackers.registry\n"}
    files |= {f"{Path(module).parent}/__init__.py": "", module: source}
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_the_contracts_hold() -> None:
    result = lint_imports(ROOT)
    assert result.returncode == 0, result.stdout + result.stderr
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    assert f"Contracts: {len(contracts)} kept, 0 broken" in result.stdout


@pytest.mark.parametrize(
    ("module", "source", "contract"),
    [
        ("sim/camera.py", "import trackers.types", "sim imports nothing of ours"),
        ("trackers/cheat.py", "import sim.world", "trackers imports nothing of ours"),
        ("trackers/cheat.py", "from scenarios import town", "trackers imports nothing of ours"),
        ("scenarios/env.py", "import trackers.registry", "scenarios sees sim and, of trackers"),
        ("scenarios/env.py", "import benchmarks.cli.main", "nobody imports benchmarks"),
        ("scenarios/env.py", "import pybullet", "only sim.bullet imports pybullet"),
        ("tools/speed/rendering.py", "import pybullet", "only sim.bullet imports pybullet"),
        ("scenarios/env.py", "import gymnasium", "gymnasium is imported directly by envs"),
        ("trackers/env.py", "import gymnasium", "gymnasium is imported directly by envs"),
        *(
            (f"benchmarks/{low}/one.py", f"import benchmarks.{high}", "the rooms of benchmarks")
            for low, high in pairwise(room for room in ROOMS if room != "papers")
        ),
        ("benchmarks/learning/one.py", "import benchmarks.papers", "the rooms of benchmarks"),
        ("benchmarks/cli/one.py", "import tools", "the rooms of benchmarks"),
    ],
)
def test_a_contract_can_fail(tmp_path: Path, module: str, source: str, contract: str) -> None:
    write_tree(tmp_path, module, source + "\n")
    result = lint_imports(tmp_path)
    broken = [line for line in result.stdout.splitlines() if " BROKEN" in line]
    assert any(line.startswith(contract) for line in broken), result.stdout + result.stderr


def test_a_tree_that_keeps_them_passes(tmp_path: Path) -> None:
    write_tree(tmp_path, "tools/speed/rendering.py", "import sim.world\n")
    result = lint_imports(tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr


def test_no_module_imports_itself_by_way_of_others() -> None:
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    TopologicalSorter(imports).prepare()


def our_modules() -> list[Path]:
    return [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]


def test_modules_are_named_for_what_they_hold() -> None:
    for path in our_modules():
        assert path.stem not in VAGUE_NAMES, f"{path}: the name says nothing of what it holds"
        # Three packages have a face, see test_face.py.
        if path.name == "__init__.py" and (path.parent.parent != ROOT or path.parent.name == "sim"):
            assert path.read_text() == "", f"{path}: expected an empty file"


def test_randomness_is_always_passed_in() -> None:
    """No module draws from NumPy's global state, makes an unseeded generator, or has one as a default."""
    for path in our_modules():
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call):
                continue
            library, _, name = ast.unparse(node.func).rpartition(".")
            if library in {"np.random", "numpy.random", "random"} and name not in NO_DRAW:
                where = f"{path}:{node.lineno}"
                assert name in SEEDED, f"{where}: {library}.{name} draws from a state that no seed reaches"
                assert node.args or node.keywords, f"{where}: {name}() without a seed"
