"""The kinds of actions: a command, a correction of a controller's command, or a controller's parameters."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.settings import FollowSettings
from sim.checks import check
from trackers.belief.features import command_of, is_seen, shares_of
from trackers.controllers.catalogue import ControllerEntry, controller_entry
from trackers.protocols import Controller
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_TOLERANCE = 1e-6


class Steering(Protocol):
    """Turns an action (A,) in [-1, 1] into a command; one object per episode."""

    def command(self, action: NDArray[np.float64], observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command of an action, given the latest observation and estimate."""
        ...


class Commands:
    """An action is the command, each number as a share of its limit."""

    def __init__(self, carrier: Carrier) -> None:
        self._carrier = carrier

    def command(self, action: NDArray[np.float64], observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Steering``."""
        return command_of(self._carrier, action)


class Corrections:
    """An action is added to a controller's command, as a share of the limits."""

    def __init__(self, carrier: Carrier, controller: Controller, share: float, only_unseen: bool) -> None:
        self._carrier, self._controller = carrier, controller
        self._share, self._only_unseen = share, only_unseen

    def command(self, action: NDArray[np.float64], observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Steering``."""
        own = _commanded(self._controller, observation, estimate)
        # Without a correction, keep the controller's command to the last bit: no division by a limit and back.
        if not action.any() or (self._only_unseen and is_seen(estimate)):
            return own
        return command_of(self._carrier, shares_of(self._carrier, own) + self._share * action)


class Parameters:
    """An action sets the tunable parameters of a controller, -1 the lowest value of each and 1 the highest."""

    def __init__(self, entry: ControllerEntry, controller: Controller) -> None:
        self._controller, self._fields = controller, entry.tunables()

    def command(self, action: NDArray[np.float64], observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Steering``."""
        shares = zip(self._fields.items(), action, strict=True)
        values = {name: _placed(field, float(share)) for (name, field), share in shares}
        self._controller.parameters = dataclasses.replace(self._controller.parameters, **values)  # type: ignore[attr-defined]
        return _commanded(self._controller, observation, estimate)


def action_count(settings: FollowSettings, carrier: Carrier) -> int:
    """Return the length of an action.

    Raises:
        ValueError: for an unknown controller, values that it rejects, or a controller without tunable parameters.
    """
    if settings.action == "command":
        return len(carrier.axes)
    if settings.action == "correction":
        if isinstance(settings.controller, str):
            check_values(controller_entry(settings.controller, carrier.name), settings.controller_values)
        return len(carrier.axes)
    entry = _named_entry(settings, carrier)
    count = len(entry.tunables())
    check("controller", count > 0, "one with parameters to set, for the action 'parameters'", repr(entry.name))
    check_values(entry, settings.controller_values)
    return count


def steering(settings: FollowSettings, carrier: Carrier) -> Steering:
    """Return the steering of a new episode."""
    if settings.action == "command":
        return Commands(carrier)
    if settings.action == "parameters":
        entry = _named_entry(settings, carrier)
        return Parameters(entry, entry.create(**settings.controller_values))
    if isinstance(settings.controller, str):
        controller = controller_entry(settings.controller, carrier.name).create(**settings.controller_values)
    else:
        # A copy, so that no state carries over from one episode to the next.
        controller = copy.deepcopy(settings.controller)
    return Corrections(carrier, controller, settings.correction_share, settings.corrects == "unseen")


def checked_actions(actions: Any, shape: tuple[int, ...] | None) -> NDArray[np.float64]:
    """Return a copy of an action, or of the actions of many envs, as floats.

    Raises:
        ValueError: for another shape, or numbers not finite or outside [-1, 1].
    """
    try:
        given = np.array(actions, dtype=float)
    except (TypeError, ValueError):
        given = np.empty(0)
    good = given.shape == shape and bool((np.abs(given) <= 1.0 + _TOLERANCE).all())
    # Formatted only on refusal: formatting takes longer than many a step.
    check(
        "action", good, f"numbers of shape {shape} from -1 to 1", actions if good else _in_short(given, shape, actions)
    )
    return given


def _in_short(given: NDArray[np.float64], shape: tuple[int, ...] | None, actions: Any) -> Any:
    """Return refused actions in short: those of many envs would fill the screen."""
    if given.ndim < 2:
        return actions
    if given.shape != shape:
        return f"shape {given.shape}"
    wrong = int(np.argmin((np.abs(given) <= 1.0 + _TOLERANCE).all(axis=1)))
    return f"{given[wrong]} of env {wrong}"


def _commanded(controller: Controller, observation: Observation, estimate: Estimate) -> CameraCommand:
    """Return a controller's command. Raises ValueError if it is none."""
    command = controller.command(observation, estimate)
    check("command", isinstance(command, CameraCommand), "a CameraCommand", type(command).__name__)
    return command


def check_values(entry: ControllerEntry, values: Mapping[str, Any]) -> None:
    """Raise ValueError for values that are not of a controller."""
    try:
        entry.parameters(**values)
    except ValueError as error:
        raise ValueError(f"controller_values: {error}") from None


def _named_entry(settings: FollowSettings, carrier: Carrier) -> ControllerEntry:
    wanted = "the name of a controller, for the action 'parameters'"
    check("controller", isinstance(settings.controller, str), wanted, repr(settings.controller))
    return controller_entry(settings.controller, carrier.name)


def _placed(field: dataclasses.Field[Any], share: float) -> float | int:
    """Return the value at a share in [-1, 1] of a parameter's range."""
    low, high = field.metadata["low"], field.metadata["high"]
    place = 0.5 * (share + 1.0)
    value = low * (high / low) ** place if field.metadata["log"] else low + place * (high - low)
    return round(value) if isinstance(field.default, int) else value
