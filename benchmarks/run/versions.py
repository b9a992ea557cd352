"""Versions of rows: of packages, and hashes of code and parameters.

A resumed run repeats rows of other code. A hash covers only the modules of its part: a change in one tracker, scene or
judge does not outdate rows of the others.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.run import contestants, jobs
from benchmarks.run.contestants import Entrant
from benchmarks.run.source_files import source_files
from benchmarks.suites import registry as suites
from scenarios import catalog
from scenarios.scenario import Survey
from trackers import registry
from trackers.controllers import catalogue
from trackers.controllers.catalogue import POLICY, ControllerEntry, controller_entry
from trackers.controllers.policy_file import load_policy, policy_path

_PACKAGES = {
    "frameout": "frameout",
    "numpy": "numpy",
    "numba": "numba",
    "opencv": "opencv-python-headless",
    "pybullet": "pybullet",
}
_REGISTRIES = tuple(module.__name__ for module in (catalog, catalogue, contestants, registry, suites))
"""They name all scenes, judges and contestants; a row names its own."""
_DIGITS = 10


def versions_of(
    suite: str,
    scenario: str,
    preset: str,
    entrant: Entrant,
    controller: ControllerEntry | None = None,
    changed: Mapping[str, Any] | None = None,
) -> dict[str, str]:
    """Return ``versions`` of rows: of packages, ``scene``, ``judge``, ``loop``, ``tracker`` and ``controller``.

    ``changed``: fields of the preset that have other values.
    """
    loop = modules_of(suite, scenario)[-1]
    made = {
        **package_versions(),
        "scene": scene_version(scenario, preset, changed),
        "judge": judge_version(suite),
        "loop": _modules_hash(loop),
        "tracker": _hash_with((entrant.module,), entrant.parameters),
    }
    return made if controller is None else made | _versions_of_controller(controller)


def scene_version(scenario: str, preset: str, changed: Mapping[str, Any] | None = None) -> str:
    """Return ``scene`` of ``versions_of``: hash of the code that makes an episode's frames, and of the preset."""
    found = catalog.scenario(scenario)
    configuration = replace(found.presets[preset], **changed) if changed else found.presets.get(preset)
    return _hash_with((type(found).__module__,), configuration)


def judge_version(suite: str) -> str:
    """Return ``judge`` of ``versions_of``: hash of the code that makes rows of truth and answers."""
    judging = suites.suite(suite)
    own = sorted({score.__module__ for score in judging.added().values()})
    return _hash_with((judging.judge.__module__, *own), judging.truth)


def versions_on_files(suite: str, entrant: Entrant) -> dict[str, str]:
    """Return ``versions`` of rows about real recordings: of packages, ``judge`` and ``tracker``."""
    judge = suites.suite(suite).recordings
    assert judge is not None
    tracker = _hash_with((entrant.module,), entrant.parameters)
    return {**package_versions(), "judge": _modules_hash(judge.__module__), "tracker": tracker}


def versions_on_sequences(suite: str, entrant: Entrant, loop: str) -> dict[str, str]:
    """Return ``versions`` of rows about real sequences: of packages, ``judge``, ``loop`` (its module), ``tracker``."""
    judging = suites.suite(suite).on_sequences
    assert judging is not None
    judge = _modules_hash(judging.judge.__module__)
    tracker = _hash_with((entrant.module,), entrant.parameters)
    return {**package_versions(), "judge": judge, "loop": _modules_hash(loop), "tracker": tracker}


def modules_of(suite: str, scenario: str) -> tuple[str, str, str]:
    """Return the modules of a scene, of the judge and of the loop that runs episodes."""
    return type(catalog.scenario(scenario)).__module__, suites.suite(suite).judge.__module__, jobs.__name__


def versions_of_modules(*modules: str) -> dict[str, str]:
    """Return ``versions`` of rows that modules measured without a tracker."""
    return {**package_versions(), "experiment": _modules_hash(*modules)}


def _versions_of_controller(controller: ControllerEntry) -> dict[str, str]:
    """Return ``controller``; for a trained policy also ``policy``, of its files and the controller that it corrects."""
    made = {"controller": _hash_with((controller.controller.__module__,), controller.parameters())}
    if controller.name.startswith(POLICY):
        file = controller.name.removeprefix(POLICY)
        path, base = policy_path(file), load_policy(file).base
        files = _hash_files([path, path.with_suffix(".safetensors")])
        corrected = base and _versions_of_controller(controller_entry(base["controller"], controller.carrier))
        made["policy"] = hashlib.sha256(f"{files}{corrected}".encode()).hexdigest()[:_DIGITS]
    return made


def hash_of_survey(survey: Survey) -> str:
    """Hash of a survey's module and of all that it imports."""
    return _modules_hash(type(survey).__module__)


@cache
def package_versions() -> dict[str, str]:
    """Return the versions of the packages that frames and scores depend on."""
    return {name: importlib.metadata.version(package) for name, package in _PACKAGES.items()}


def _hash_with(modules: tuple[str, ...], values: Any) -> str:
    """Hash of modules, as ``_modules_hash``, and of parameter values."""
    return hashlib.sha256(f"{_modules_hash(*modules)}{values!r}".encode()).hexdigest()[:_DIGITS]


@cache
def _modules_hash(*modules: str) -> str:
    """Hash of modules and all that they import, see ``source_files``."""
    return _hash_files(source_files(modules, _REGISTRIES))


def _hash_files(files: Iterable[Path]) -> str:
    """Hash of the names and contents of files, without their folders."""
    each = sorted(hashlib.sha256(f"{file.name}\0".encode() + file.read_bytes()).digest() for file in files)
    return hashlib.sha256(b"".join(each)).hexdigest()[:_DIGITS]
