"""Setting up a fresh machine: pins are whole and exact, the Makefile does what README says, one line of refusal."""

from __future__ import annotations

import ast
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[1]
PACKAGES = ("sim", "trackers", "scenarios", "benchmarks")
TOOLS = ("sh", "bash", "make", "mkdir", "touch", "cat", "chmod", "dirname", "env")
LOGGING = '#!/bin/sh\necho "$(basename "$0") $*" >> "$LOG"\n'


def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    matches = [re.fullmatch(r"([A-Za-z0-9_.-]+)==([0-9][A-Za-z0-9.+!]*)", line) for line in lines if line[0] != "#"]
    assert all(matches), "constraints.txt: expected NAME==VERSION on every line"
    return {canonical(match[1]): match[2] for match in matches if match}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def requirements_of(name: str, extras: tuple[str, ...]) -> list[Requirement]:
    """Return what a distribution needs here, with its extras."""
    needed = map(Requirement, importlib.metadata.requires(name) or [])
    return [
        each
        for each in needed
        if each.marker is None or any(each.marker.evaluate({"extra": extra}) for extra in ("", *extras))
    ]


def our_requirements() -> list[Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    optional = project["optional-dependencies"]
    return [
        Requirement(line) for line in (*project["dependencies"], *(each for more in optional.values() for each in more))
    ]


def is_for_here(requirement: Requirement) -> bool:
    """Return whether a requirement is one of this interpreter and platform."""
    return requirement.marker is None or requirement.marker.evaluate()


def test_every_package_that_is_needed_is_pinned_to_what_is_tested() -> None:
    """Walk through the requirements of what is installed, as an installer would."""
    pinned = pins()
    ours = our_requirements()
    elsewhere = {canonical(each.name) for each in ours if not is_for_here(each)}
    waiting, seen = [each for each in ours if is_for_here(each)], set()
    while waiting:
        requirement = waiting.pop()
        key = (canonical(requirement.name), tuple(sorted(requirement.extras)))
        # The pins are those of PyTorch for processors; that for CUDA brings libraries of its own.
        if key in seen or key[0].startswith(("nvidia-", "cuda-", "triton")):
            continue
        seen.add(key)
        assert key[0] in pinned, f"constraints.txt: {requirement.name} is missing"
        # What a wheel was built for (``+cpu``) is no part of the pin.
        assert Version(importlib.metadata.version(key[0])).public == pinned[key[0]], key[0]
        assert requirement.specifier.contains(pinned[key[0]], prereleases=True)
        waiting += requirements_of(requirement.name, key[1])
    # The Makefile installs TrackEval without what it asks for, which the tests need for themselves.
    assert set(pinned) == {name for name, _ in seen} | elsewhere | {"setuptools", "trackeval"}
    needed = {canonical(each.name) for each in requirements_of("trackeval", ())} - {"opencv-python"}
    assert needed <= set(pinned)


def test_what_is_imported_is_declared_and_what_is_declared_is_imported() -> None:
    """A package that only comes along with another one may be gone tomorrow."""
    modules_of: dict[str, set[str]] = {}
    for module, names in importlib.metadata.packages_distributions().items():
        for name in names:
            modules_of.setdefault(canonical(name), set()).add(module)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = {canonical(each.name) for each in map(Requirement, project["dependencies"]) if is_for_here(each)}
    extras = project["optional-dependencies"]
    optional = {canonical(Requirement(line).name) for name in {*extras} - {"dev"} for line in extras[name]}
    imported = imported_modules() - set(sys.stdlib_module_names) - set(PACKAGES)
    used = {name for name, modules in modules_of.items() if modules & imported} - {"frameout"}
    assert used - optional == declared


def imported_modules() -> set[str]:
    found = set()
    for path in (path for package in PACKAGES for path in (ROOT / package).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                found.add(node.module.partition(".")[0])
    return found


def test_pins_name_no_index() -> None:
    text = (ROOT / "constraints.txt").read_text() + (ROOT / "Makefile").read_text()
    assert "://" not in text
    assert re.search(r"\bindex", text) is None


class Machine:
    """A machine with a few tools, a checkout, and stand-ins for installers that write down how they are called."""

    def __init__(self, folder: Path) -> None:
        self.checkout, self.bin, self.log = folder / "checkout", folder / "bin", folder / "log"
        self.checkout.mkdir()
        self.bin.mkdir()
        self.log.touch()
        for name in ("Makefile", "constraints.txt", "pyproject.toml"):
            shutil.copy(ROOT / name, self.checkout)
        shutil.copytree(ROOT / ".ci", self.checkout / ".ci")
        for name in (*TOOLS, "basename"):
            os.symlink(shutil.which(name) or f"/bin/{name}", self.bin / name)

    def put(self, name: str, script: str) -> None:
        path = self.bin / name
        path.write_text(script)
        path.chmod(0o755)

    def put_python(self, name: str, version: str) -> None:
        """Put an interpreter that answers as this version would, and whose venv holds logging programs."""
        right = 0 if version in ("3.11", "3.12", "3.13") else 1
        programs = "python frameout pytest sphinx-build"
        made = f"for p in {programs}; do printf '%s' \"$TEMPLATE\" > .venv/bin/$p; chmod +x .venv/bin/$p; done"
        self.put(
            name,
            f'#!/bin/sh\ncase "$1" in -c) exit {right};; esac\n{LOGGING[10:]}mkdir -p .venv/bin\n{made}\n',
        )

    def make(self, *arguments: str, program: str = "make") -> subprocess.CompletedProcess[str]:
        environment = {"PATH": str(self.bin), "LOG": str(self.log), "TEMPLATE": LOGGING}
        return subprocess.run(
            [program, *arguments],
            cwd=self.checkout,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )

    def calls(self) -> list[str]:
        lines = self.log.read_text().splitlines()
        self.log.write_text("")
        return lines


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_demo_installs_pinned_packages_and_runs(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    done = machine.make("demo")
    assert done.returncode == 0, done.stderr
    assert machine.calls() == [
        "python3.11 -m venv .venv",
        "python -m pip install --quiet -c constraints.txt setuptools",
        "python -m pip install --quiet -c constraints.txt --no-build-isolation -e .",
        "frameout bench frame-out --seeds 0:5"
        " --trackers mosaic_graph_pf colour_pf hold hold_ground oracle_map --out results/demo",
        "frameout render road-town --seed 3 --frames 90 --tracker mosaic_graph_pf --out results/demo/frame_out.mp4",
    ]


def test_the_site_needs_no_more_than_its_extra(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    assert machine.make("docs").returncode == 0
    calls = machine.calls()
    assert calls[3] == "python -m pip install --quiet -c constraints.txt --no-build-isolation -e .[docs]"
    assert calls[4].startswith("sphinx-build ")
    assert len(calls) == 5


def test_a_second_call_installs_nothing_unless_the_pins_changed(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    machine.make("demo")
    machine.calls()
    machine.make("demo")
    assert [call.split()[0] for call in machine.calls()] == ["frameout", "frameout"]
    later = (machine.checkout / ".venv/installed").stat().st_mtime + 2
    os.utime(machine.checkout / "constraints.txt", (later, later))
    machine.make("demo")
    assert any("pip install" in call for call in machine.calls())


def test_an_interrupted_install_is_gone_on_with(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    machine.make("demo")
    (machine.checkout / ".venv/installed").unlink()
    machine.calls()
    assert machine.make("demo").returncode == 0
    assert [call.split()[0] for call in machine.calls()] == ["python", "python", "frameout", "frameout"]


@pytest.mark.parametrize(("name", "version"), [("python3.13", "3.13"), ("python3", "3.12")])
def test_any_python_of_the_right_version_will_do(machine: Machine, name: str, version: str) -> None:
    machine.put_python("python3.11", "broken shim")
    machine.put_python(name, version)
    assert machine.make("demo").returncode == 0
    assert machine.calls()[0] == f"{name} -m venv .venv"


@pytest.mark.parametrize("found", [{}, {"python3": "3.14"}, {"python3.11": "broken shim", "python3": "3.10"}])
@pytest.mark.parametrize("target", ["demo", "test"])
def test_a_wrong_python_is_refused_in_one_line(machine: Machine, found: dict[str, str], target: str) -> None:
    for name, version in found.items():
        machine.put_python(name, version)
    done = machine.make(target)
    assert done.returncode != 0
    (line,) = done.stderr.splitlines()
    assert "frameout needs Python 3.11, 3.12 or 3.13" in line
    assert machine.calls() == []
    assert not (machine.checkout / ".venv").exists()


@pytest.mark.parametrize(("version", "interpreter"), [("3.11", "bin/python3.11"), (None, "3.11")])
def test_uv_is_used_where_it_is_there(machine: Machine, version: str | None, interpreter: str) -> None:
    if version is not None:
        machine.put_python("python3.11", version)
    machine.put_python("uv", "uv")
    assert machine.make("demo").returncode == 0
    calls = machine.calls()
    assert re.fullmatch(rf"uv venv .*--python \S*{interpreter} \.venv", calls[0])
    installs = [call for call in calls if " pip install " in call]
    assert len(installs) == 2
    assert all(
        call.startswith("uv pip install --python .venv/bin/python --quiet -c constraints.txt") for call in installs
    )


def test_ci_runs_the_tests_without_standard_input(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    done = machine.make(str(machine.checkout / ".ci/run"), program="bash")
    assert done.returncode == 0, done.stderr
    calls = machine.calls()
    assert calls[-1].startswith("pytest -n 2")
    assert any("-e .[dev,docs,tune,train,play,data,s3,dask,rerun]" in call for call in calls)


def test_ci_fails_if_the_tests_do(machine: Machine) -> None:
    machine.put_python("python3.11", "3.11")
    machine.make("test")
    (machine.checkout / ".venv/bin/pytest").write_text("#!/bin/sh\nexit 3\n")
    assert machine.make(".ci/run", program="bash").returncode != 0


def test_the_workflow_runs_the_whole_check_with_pinned_actions(machine: Machine) -> None:
    text = (ROOT / ".github/workflows/check.yml").read_text()
    actions = re.findall(r"uses: (\S+)", text)
    assert actions
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action) for action in actions)
    assert "secrets" not in text
    assert 'python: ["3.11", "3.12", "3.13"]' in text
    assert re.findall(r"run: (.+)", text) == ["make check PYTHON=python"]
    assert machine.make("--dry-run", "check").returncode == 2
    machine.put_python("python3.11", "3.11")
    planned = machine.make("--dry-run", "check").stdout
    assert all(program in planned for program in ("ruff format", "ruff check", "mypy", "lint-imports", "pytest"))


def test_a_wheel_has_every_file_of_the_packages_but_the_published_tables() -> None:
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    shipped = {path for package, globs in data.items() for glob in globs for path in (ROOT / package).glob(glob)}
    found = (path for package in PACKAGES for path in (ROOT / package).rglob("*") if path.is_file())
    there = {path for path in found if path.suffix != ".py" and "__pycache__" not in path.parts}
    assert there - shipped == {path for path in there if path.is_relative_to(ROOT / "benchmarks" / "results")}
    assert len(shipped) > 50
    folders = {path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    assert all((folder / "__init__.py").is_file() for folder in folders), "setuptools leaves out a folder without one"


def test_the_container_copies_what_the_wheel_is_made_of() -> None:
    copied = re.findall(r"^COPY (.+) \S+$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    assert {word for line in copied for word in line.split()} >= {
        *PACKAGES,
        "constraints.txt",
        "pyproject.toml",
        "README.md",
    }
    assert all((ROOT / word).exists() for line in copied for word in line.split())
