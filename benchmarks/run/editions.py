"""Editions: what made a row, as numbers that stand beside the things.

The column ``editions`` of a row is a flat object of texts:

==============  ==================================================================================================
``scene``       catalogue id, and a digest of the preset: ``road-town-v2 3f0a9c1b52``; of a real sequence or
                recording its name, and a digest of its content
``judge``       suite and its edition: ``frame-out 1``
``tracker``     name, edition and a digest of the parameters: ``colour_pf 1 8fb21c5fb8``
``controller``  the same, of the controller; a trained policy also has ``policy``, a digest of its files
packages        ``numpy``, ``numba``, ``opencv``; ``pybullet`` where it draws
==============  ==================================================================================================

A number is raised by whoever changes what its thing does: ``Suite(edition=)``, ``register(edition=)``, the version in
a scenario's id. Canaries (``tests/canaries``) tell when that is due. Where code lies and how it is written is in no
row. The module of a user has no number that anyone would raise: a digest of its content follows, see ``own_code``.

A resumed run keeps the rows of the present editions and repeats the others.
"""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import hashlib
import importlib.metadata
import json
import os
import re
from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.contract.suite import Suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.own_modules import imported_files
from scenarios import catalog
from scenarios.field_values import split_name
from scenarios.scenario import Scenario
from sim.meshes.file import digest_of_files
from trackers.controllers.catalogue import POLICY, ControllerEntry, controller_entry
from trackers.controllers.policy import load_policy, policy_path

Editions = dict[str, str]
"""Part of a row -> what made it."""
_PACKAGES = {"numpy": "numpy", "numba": "numba", "opencv": "opencv-python-headless"}
_PYBULLET = ("pybullet", "pybullet-arm64")
"""Packages that bring it, of which one is installed."""
_DIGITS = 10


def scene_edition(scenario: Scenario, configuration: Any, values: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return the edition of a configuration of a scenario.

    Args:
        values: that a preset's name changes. They may be drawn, so only the content of the meshes that they name is
            part of it, as of those that the configuration names.
    """
    texts = [*_texts(configuration), *(each for text in values.values() for each in re.split(r"[\[\](),]", text))]
    return _words(scenario.id, digest_of(configuration), own_code(scenario.stage.__module__), digest_of_files(texts))


def _texts(value: Any) -> Iterator[str]:
    """Yield all texts in a configuration."""
    if isinstance(value, str):
        yield value
    elif dataclasses.is_dataclass(value):
        for each in dataclasses.fields(value):
            yield from _texts(getattr(value, each.name))
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _texts(part)


def preset_edition(scenario: str, preset: str) -> str:
    """Return the edition of a preset by its name. Raises ValueError for an unknown scenario."""
    found = catalog.scenario(scenario)
    name, values = split_name(preset)
    return scene_edition(found, found.presets.get(name), values)


def judge_edition(judging: Suite) -> str:
    """Return the edition of a suite, with the content of rows that a user adds to it."""
    own = (metric.value.__module__ for metric in judging.metrics if metric.value is not None)
    modules = {judging.judge.__module__, *own}
    return _words(judging.name, judging.edition, *map(own_code, sorted(modules)))


def tracker_edition(tracker: TrackerSpec) -> str:
    """Return the edition of a tracker with its parameters."""
    return _words(tracker.name, tracker.edition, digest_of(tracker.parameters), own_code(tracker.module))


def controller_edition(controller: ControllerEntry) -> Editions:
    """Return ``controller`` of ``editions``, and ``policy`` of a trained one."""
    code = own_code(controller.controller.__module__)
    if not controller.name.startswith(POLICY):
        return {"controller": _words(controller.name, controller.edition, digest_of(controller.parameters()), code)}
    file = controller.name.removeprefix(POLICY)
    path, base = policy_path(file), load_policy(file).base
    contents = b"".join(each.read_bytes() for each in (path, path.with_suffix(".safetensors")))
    corrected = base and controller_edition(controller_entry(base["controller"], controller.carrier))
    return {
        "controller": _words(path.stem, controller.edition, code),
        "policy": _digest(contents + json.dumps(corrected, sort_keys=True).encode()),
    }


@cache
def package_versions(renderer: str = "raster") -> Editions:
    """Return the versions of the packages that frames and scores depend on."""
    found = {name: importlib.metadata.version(package) for name, package in _PACKAGES.items()}
    for package in _PYBULLET if renderer == "pybullet" else ():
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found["pybullet"] = importlib.metadata.version(package)
    return found


def digest_of(values: Any) -> str:
    """Return a digest of the fields of a dataclass that differ from their defaults, so that a new field outdates no
    row; of other values, of what they are.
    """
    return _digest(json.dumps(_plain(values), sort_keys=True).encode())


def _plain(value: Any) -> Any:
    """Return a value as JSON has it; a dataclass with its name, since others may have the same fields."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {each.name: getattr(value, each.name) for each in dataclasses.fields(value) if _differs(value, each)}
        return [type(value).__name__, {name: _plain(each) for name, each in fields.items()}]
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return value if isinstance(value, str | int | float | None) else repr(value)


def _differs(value: Any, field: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    default = field.default if field.default_factory is missing else field.default_factory()
    return default is missing or _plain(default) != _plain(getattr(value, field.name))


def own_code(module: str) -> str:
    """Return a digest of a user's module, "" for ours and installed ones.

    It covers all modules of users that it imports, directly or not, whatever their comments and layout; and the data
    files in their folders whose name, stem or path from there one of them has as a string. A module must not write such
    a file itself.
    """
    files = imported_files([module], users_alone=True)
    if not files:
        return ""
    trees = [ast.parse(file.read_bytes()) for file in files]
    nodes = (node for tree in trees for node in ast.walk(tree))
    strings = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    folders = {file.parent for file in files}
    data = {each for folder in folders for each in folder.iterdir() if {each.name, each.stem} & strings}
    data |= {folder / text for folder in folders for text in strings if "/" in text}
    # Unlike ``Path.is_file`` it takes any string, one of 10,000 letters too.
    data = {each for each in data if each.suffix != ".py" and os.path.isfile(each)}
    contents = [ast.dump(tree).encode() for tree in trees]
    contents += [each.name.encode() + b"\0" + each.read_bytes() for each in data]
    return _digest(b"".join(sorted(hashlib.sha256(each).digest() for each in contents)))


def _words(*parts: object) -> str:
    return " ".join(filter(None, map(str, parts)))


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:_DIGITS]
