"""The registry of controllers, by carrier and name.

A controller registers where it is defined, as a tracker does::

    @register_controller("centre", role="baseline", carrier="helicopter", summary="keeps the estimate in the middle")
    class CentreController:
        Parameters = CentreParameters
        def __init__(self, parameters: CentreParameters): ...

Values found by tuning lie in ``trackers/tuned/controllers/CARRIER/NAME.json`` and take the place of the defaults.
``policy:FILE`` names a trained policy.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from trackers.protocols import Controller
from trackers.registry import OWN_NEEDS_MODULE, MethodEntry, check_registered, nearest, tuned_values
from trackers.types import CameraCommand

ControllerRole = Literal["ours", "policy", "baseline", "blind", "variant", "oracle", "external"]

POLICY = "policy:"
"""Prefix of a trained policy's name; a file follows."""
_MODULES = {
    "helicopter": {
        "hold": "hold",
        "centre": "centring",
        "search": "centring",
        "reentry": "reentry",
        "predictive": "predictive",
        "learnt": "learnt",
    },
    "robot": {"hold": "hold", "centre": "centring_robot", "search": "centring_robot", "reentry": "reentry_robot"},
    "tank-head": {"hold": "hold", "centre": "head", "lead": "head"},
    "harbour-head": {"hold": "hold", "centre": "head", "lead": "head"},
    "tank-ptz": {"hold": "hold", "centre": "head", "lead": "ptz"},
    "harbour-ptz": {"hold": "hold", "centre": "head", "lead": "ptz"},
}
"""Carrier -> name of a controller -> module of this package that registers it, in the order of ``controllers``.

``NAME_as_written`` stands in the module of ``NAME``. Add yours here.
"""
_AS_WRITTEN = "_as_written"

_ENTRIES: dict[tuple[str, str], ControllerEntry] = {}
_T = TypeVar("_T", bound=type)


class Kernel(NamedTuple):
    """A controller for many carriers at a time.

    Attributes:
        steer: called once a frame as ``steer(beliefs, parameters, memory, times_s, out)``: B beliefs (B,) of dtype
            ``BELIEF``, the parameters' record (1,), memory (B,), times (B,) in seconds; it writes commands to ``out``
            (B, 4), the numbers of ``Carrier.commands``.
        parameters: dtype of the parameters' record, with their names.
        memory: dtype of what the kernel keeps from frame to frame, zeros at the start of an episode.
    """

    steer: Callable[..., None]
    parameters: np.dtype[Any]
    memory: np.dtype[Any] = np.dtype([])

    def record(self, parameters: Any) -> NDArray[np.void]:
        """Return parameters as a record (1,)."""
        return np.array([tuple(getattr(parameters, name) for name in self.parameters.names or ())], self.parameters)


@dataclass(frozen=True)
class ControllerEntry(MethodEntry):
    """One registered controller.

    Attributes:
        name: the name that users type. carrier: name of the carrier that it steers, see ``trackers.types.Carrier``.
        role: its role in a comparison.
        summary: one line.
        controller: class with ``Parameters`` and ``__init__(parameters)``.
        overrides: parameter values that belong to the entry.
        edition: of its commands; raise it when they change.
        kernel: the same controller for many carriers at a time; None if there is none.
    """

    name: str
    carrier: str
    role: ControllerRole
    summary: str
    controller: Callable[[Any], Controller]
    overrides: Mapping[str, Any] = field(default_factory=dict)
    kernel: Kernel | None = None
    edition: int = 1

    def parameters(self, **changes: Any) -> Any:
        """Return the parameters: defaults, then tuned values, then ``changes``."""
        tuned = tuned_values(f"controllers/{self.carrier}/{self.name}", self.controller.__module__)
        return self._with({**tuned, **self.overrides, **changes})

    @property
    def parameters_class(self) -> type:
        """See ``MethodEntry``."""
        return self.controller.Parameters  # type: ignore[attr-defined, no-any-return]

    def create(self, **changes: Any) -> Controller:
        """Return a new controller for one episode."""
        return self.controller(self.parameters(**changes))

    def create_as_written(self) -> Controller:
        """Return a new controller with its values as written, without tuning."""
        return self.controller(self._with(self.overrides))


def register_controller(
    name: str, *, role: ControllerRole, carrier: str, summary: str, edition: int = 1
) -> Callable[[_T], _T]:
    """Class decorator: register a controller under ``name`` for a carrier, with its ``KERNEL`` if it has one.

    Raises:
        ValueError: for a name that is taken, an unknown role, or a class without parameters or ``command``.
    """

    def add(controller: _T) -> _T:
        check_registered(controller, role, get_args(ControllerRole), "command")
        _load(carrier, name)
        old = _ENTRIES.get((carrier, name))
        if old is not None and old.controller is not controller:
            raise ValueError(f"name: expected one that no controller of a {carrier} has, got {name!r}")
        if not controller.__module__.startswith(f"{__package__}."):
            controller.command = _commanding(controller.command)  # type: ignore[attr-defined]
        # One that inherits may command something else than the kernel of the class that it is made from.
        kernel = vars(controller).get("KERNEL")
        _ENTRIES[carrier, name] = ControllerEntry(
            name, carrier, role, summary, controller, kernel=kernel, edition=edition
        )
        return controller

    return add


def _commanding(command: Callable[..., CameraCommand]) -> Callable[..., CameraCommand]:
    """Return the method of a user's controller, in which an exit is an error, and an answer that is no command too."""

    @wraps(command)
    def checked(*given: Any) -> CameraCommand:
        try:
            answer = command(*given)
        except SystemExit as left:
            raise RuntimeError(f"it called sys.exit({left.code!r})").with_traceback(left.__traceback__) from None
        if not isinstance(answer, CameraCommand):
            raise TypeError(f"command: expected a CameraCommand, got {type(answer).__name__}")
        return answer

    return checked


def controllers(carrier: str) -> dict[str, ControllerEntry]:
    """Return all controllers of a carrier by name: ours, then others in order of registration; policies are files."""
    order = {name: place for place, name in enumerate(_MODULES.get(carrier, {}))}
    for name in order:
        _load(carrier, name)
    names = [name for steered, name in _ENTRIES if steered == carrier]
    names.sort(key=lambda name: order.get(name.removesuffix(_AS_WRITTEN), len(order)))
    return {name: _ENTRIES[carrier, name] for name in names}


def _load(carrier: str, name: str) -> None:
    """Import the module that registers a controller of ours; nothing for any other."""
    module = _MODULES.get(carrier, {}).get(name.removesuffix(_AS_WRITTEN))
    if module is not None:
        importlib.import_module(f"{__package__}.{module}")


def steers_instead(name: str) -> str:
    """Return which carriers a controller of this name steers, as a clause of an error; empty for an unknown one."""
    for carrier in _MODULES:
        _load(carrier, name)
    carriers = sorted(carrier for carrier, known in _ENTRIES if known == name)
    return f", which steers a {' or a '.join(carriers)}" if carriers else ""


def our_controller(carrier: str) -> str:
    """Return the name of a carrier's controller of the role ``ours``; ``none`` if it has none."""
    return next((name for name, entry in controllers(carrier).items() if entry.role == "ours"), "none")


def controller_entry(name: str, carrier: str) -> ControllerEntry:
    """Return one controller's entry; of ours, only the module that defines it is imported.

    Raises:
        ValueError: for an unknown name (the message lists the known ones), a file that holds no policy, or a policy
            for another carrier.
    """
    if name.startswith(POLICY):
        return _policy_entry(name.removeprefix(POLICY), carrier)
    _load(carrier, name)
    if (carrier, name) not in _ENTRIES:
        known = controllers(carrier)
        expected = f"one of {', '.join(known)}, or {POLICY}FILE"
        why = steers_instead(name) or nearest(name, known) + OWN_NEEDS_MODULE
        raise ValueError(f"controller: expected {expected}; got {name!r}{why}")
    return _ENTRIES[carrier, name]


def _policy_entry(file: str, carrier: str) -> ControllerEntry:
    # Policies create controllers themselves, so their module imports this one.
    module = importlib.import_module("trackers.controllers.policy")
    policy, name = module.load_policy(file), f"{POLICY}{file}"
    if policy.carrier.name != carrier:
        raise ValueError(f"controller: expected a policy for a {carrier}, got {name!r} for a {policy.carrier.name}")
    summary = f"trained in {policy.env} with {policy.tracker}"
    return ControllerEntry(name, carrier, "policy", summary, module.PolicyController, {"file": file})
