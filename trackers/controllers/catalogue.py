"""Every controller by the carrier it steers and its name.

A controller registers where it is defined, as a tracker does::

    @register_controller("centre", role="baseline", carrier="helicopter", summary="keeps the estimate in the middle")
    class CentreController:
        Parameters = CentreParameters
        def __init__(self, parameters: CentreParameters): ...

Values found by tuning lie in ``trackers/tuned/controllers/CARRIER/NAME.json`` and take the place of the defaults. The
name ``policy:FILE`` is that of a trained policy.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from trackers.controllers.policy_file import Policy, load_policy, shipped_policies
from trackers.protocols import Controller
from trackers.registry import check_registered

ControllerRole = Literal["ours", "policy", "baseline", "blind", "variant"]

POLICY = "policy:"
"""What the name of a trained policy begins with; a file follows, or the name of one that comes with the package."""
_MODULES = (
    "trackers.controllers.hold",
    "trackers.controllers.centre",
    "trackers.controllers.search",
    "trackers.controllers.reentry",
    "trackers.controllers.centre_robot",
    "trackers.controllers.search_robot",
    "trackers.controllers.reentry_robot",
)
"""Modules that define controllers. Add yours here."""

_ENTRIES: dict[tuple[str, str], ControllerEntry] = {}
_T = TypeVar("_T", bound=type)
Kernel = tuple[Callable[..., None], np.dtype[Any]]


@dataclass(frozen=True)
class ControllerEntry:
    """One registered controller.

    Attributes:
        name: what users type. carrier: name of what it steers, see ``trackers.types.Carrier``.
        role: what it is to a comparison.
        summary: one line.
        controller: class with ``Parameters`` and ``__init__(parameters)``.
        overrides: parameter values that belong to the entry.
        kernel: the same law for many beliefs at a time, called as ``law(beliefs, parameters, out)``, and the dtype of
            its parameters' record, fields in the order of ``Parameters``; None if there is none.
    """

    name: str
    carrier: str
    role: ControllerRole
    summary: str
    controller: Callable[[Any], Controller]
    overrides: Mapping[str, Any] = field(default_factory=dict)
    kernel: Kernel | None = None

    def parameters(self, **changes: Any) -> Any:
        """Return the parameters: defaults, then tuned values, then ``changes``."""
        return self._made({**tuned_controller(self.carrier, self.name), **self.overrides, **changes})

    def create(self, **changes: Any) -> Controller:
        """Return a fresh controller for one episode."""
        return self.controller(self.parameters(**changes))

    def create_as_written(self) -> Controller:
        """Return a fresh controller with the values it was written with, whatever tuning found."""
        return self.controller(self._made(dict(self.overrides)))

    def written(self) -> dict[str, Any]:
        """Return the values that the controller was written with, of all that tuning may set."""
        return {name: each.default for name, each in self.tunables().items()} | dict(self.overrides)

    def tunables(self) -> dict[str, dataclasses.Field[Any]]:
        """Return the parameters that declare a range to be tuned in (``registry.tunable``), by name."""
        fields = dataclasses.fields(self.controller.Parameters)  # type: ignore[attr-defined]
        return {field.name: field for field in fields if "low" in field.metadata}

    def _made(self, values: dict[str, Any]) -> Any:
        kind = self.controller.Parameters  # type: ignore[attr-defined]
        known = {field.name for field in dataclasses.fields(kind)}
        for name in values:
            if name not in known:
                raise ValueError(f"{self.name}.{name}: expected one of {sorted(known)}, got an unknown parameter")
        return kind(**values)


def register_controller(
    name: str, *, role: ControllerRole, carrier: str, summary: str, kernel: Kernel | None = None
) -> Callable[[_T], _T]:
    """Class decorator: make a controller known under ``name`` for a carrier.

    Raises:
        ValueError: for a name that is taken, an unknown role, a class without parameters.
    """

    def add(controller: _T) -> _T:
        check_registered(controller, role, get_args(ControllerRole))
        old = _ENTRIES.get((carrier, name))
        if old is not None and old.controller is not controller:
            raise ValueError(f"controller: the name {name!r} is taken")
        _ENTRIES[carrier, name] = ControllerEntry(name, carrier, role, summary, controller, kernel=kernel)
        return controller

    return add


def controllers(carrier: str) -> dict[str, ControllerEntry]:
    """Return all controllers of a carrier by name, in order of registration, and the policies that come along."""
    known = _registered(carrier)
    for name in shipped_policies():
        policy = load_policy(name)
        if policy.carrier.name == carrier:
            known[f"{POLICY}{name}"] = _policy_entry(policy, name)
    return known


def controller_entry(name: str, carrier: str) -> ControllerEntry:
    """Return one controller's entry.

    Raises:
        ValueError: for an unknown name; lists the known ones. For a file that holds no policy, or one for another
            carrier.
    """
    if name.startswith(POLICY):
        policy = load_policy(name.removeprefix(POLICY))
        if policy.carrier.name != carrier:
            raise ValueError(f"controller: expected a policy for a {carrier}, got {name!r} for a {policy.carrier.name}")
        return _policy_entry(policy, name.removeprefix(POLICY))
    # Not by way of the policies that come along: whoever trains one anew needs none that can be loaded.
    known = _registered(carrier)
    if name not in known:
        raise ValueError(f"controller: expected one of {', '.join(known)}, or {POLICY}FILE; got {name!r}")
    return known[name]


def create_controller(name: str, carrier: str, **changes: Any) -> Controller:
    """Return a fresh controller for one episode; ValueError for an unknown name."""
    return controller_entry(name, carrier).create(**changes)


def tuned_controller(carrier: str, name: str) -> dict[str, Any]:
    """Return the values that tuning wrote for a controller, empty if it never ran."""
    file = resources.files("trackers").joinpath("tuned", "controllers", carrier, f"{name}.json")
    return json.loads(file.read_text())["parameters"] if file.is_file() else {}


def _registered(carrier: str) -> dict[str, ControllerEntry]:
    for module in _MODULES:
        importlib.import_module(module)
    return {name: entry for (whose, name), entry in _ENTRIES.items() if whose == carrier}


def _policy_entry(policy: Policy, file: str) -> ControllerEntry:
    summary = f"trained in {policy.env} with {policy.tracker}"
    module = importlib.import_module("trackers.controllers.policy")
    return ControllerEntry(
        f"{POLICY}{file}", policy.carrier.name, "policy", summary, module.PolicyController, {"file": file}
    )
