"""What made a row: versions of packages, and hashes of the code and the parameters.

A resumed run does again what other code made. A tracker's hash covers only the modules it is made of, so a
change in one tracker does not make the others run again.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.run.contestants import Entrant
from trackers.controllers.catalogue import POLICY, ControllerEntry, controller_entry
from trackers.controllers.policy_file import load_policy, policy_path

_PACKAGES = {
    "frameout": "frameout",
    "numpy": "numpy",
    "numba": "numba",
    "opencv": "opencv-python-headless",
    "pybullet": "pybullet",
}
_SCENE_PARTS = (
    "sim",
    "scenarios",
    "benchmarks/scores",
    "benchmarks/suites/frame_out/metrics",
    "benchmarks/suites/stereo/metrics",
    "benchmarks/suites/follow/metrics",
    "benchmarks/suites/judging.py",
    "benchmarks/suites/follow/judge.py",
    "benchmarks/suites/frame_out/judge.py",
    "benchmarks/suites/stereo/disparity.py",
    "benchmarks/suites/stereo/judge.py",
    "benchmarks/suites/frame_out/episode_scores.py",
    "benchmarks/run/steering.py",
    "benchmarks/run/tracked.py",
    "trackers/estimate_check.py",
    "benchmarks/run/time_limit.py",
    "benchmarks/run/jobs.py",
    "trackers/belief/command_shares.py",
    "trackers/paper_b/matching.py",
)
_ROOT = Path(__file__).resolve().parents[2]
_DIGITS = 10


def versions_of(entrant: Entrant, controller: ControllerEntry | None = None) -> dict[str, str]:
    """Return what rows of one entrant say of their making: package versions, ``scene`` and ``tracker``; and
    ``controller`` where one steers.
    """
    made = {
        **_package_versions(),
        "scene": _scene_hash(),
        "tracker": _hash_with(entrant.module, entrant.parameters),
    }
    return made if controller is None else made | _versions_of_controller(controller)


def _versions_of_controller(controller: ControllerEntry) -> dict[str, str]:
    """Return ``controller``; for a trained policy ``policy`` too, its files and what it is a correction of."""
    made = {"controller": _hash_with(controller.controller.__module__, controller.parameters())}
    if controller.name.startswith(POLICY):
        file = controller.name.removeprefix(POLICY)
        path, base = policy_path(file), load_policy(file).base
        files = _hash_files([path, path.with_suffix(".safetensors")])
        corrected = base and _versions_of_controller(controller_entry(base["controller"], controller.carrier))
        made["policy"] = hashlib.sha256(f"{files}{corrected}".encode()).hexdigest()[:_DIGITS]
    return made


def _hash_with(module: str, parameters: Any) -> str:
    """Hash of a module, as ``_modules_hash``, and of the parameters that its class is set to."""
    return hashlib.sha256(f"{_modules_hash(module)}{parameters!r}".encode()).hexdigest()[:_DIGITS]


def versions_of_module(module: str) -> dict[str, str]:
    """Return what rows say that a module measured, where no tracker ran."""
    return {**_package_versions(), "scene": _scene_hash(), "experiment": _modules_hash(module)}


@cache
def _package_versions() -> dict[str, str]:
    return {name: importlib.metadata.version(package) for name, package in _PACKAGES.items()}


def hash_of_survey() -> str:
    """Hash of the code that decides what episodes of the scenario with presets hold, and of that which counts it."""
    return _modules_hash("scenarios.road_town.survey")


@cache
def _scene_hash() -> str:
    """Hash of everything that makes pictures, truth and scores. Envs only ask for them."""
    envs = _ROOT / "scenarios" / "envs"
    files = [file for part in _SCENE_PARTS for file in _files_of(_ROOT / part) if envs not in file.parents]
    return _hash_files(files)


@cache
def _modules_hash(module: str) -> str:
    """Hash of a module, of all modules of ours that it imports, directly or not, and of the learnt models."""
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = _source_of(name)
        if name in found or path is None:
            continue
        found[name] = path
        waiting += _imported(path)
    models = sorted((_ROOT / "trackers" / "paper_a").glob("*.json"))
    return _hash_files([found[name] for name in sorted(found)] + models)


def _imported(path: Path) -> list[str]:
    """Return the names of modules (and of what may be modules) that a file imports, registries excepted."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    ours = ("trackers.", "benchmarks.", "scenarios.", "sim.")
    registries = ("trackers.registry", "trackers.controllers.catalogue")
    return [name for name in names if name.startswith(ours) and not name.startswith(registries)]


def _source_of(module: str) -> Path | None:
    path = _ROOT.joinpath(*module.split("."))
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if candidate.is_file():
            return candidate
    # Users' own trackers lie elsewhere.
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None
    return Path(spec.origin) if spec is not None and spec.origin and spec.origin.endswith(".py") else None


def _files_of(path: Path) -> list[Path]:
    return [path] if path.is_file() else sorted(path.rglob("*.py"))


def _hash_files(files: list[Path]) -> str:
    digest = hashlib.sha256()
    for file in files:
        digest.update(f"{file.name}\0".encode() + file.read_bytes())
    return digest.hexdigest()[:_DIGITS]
