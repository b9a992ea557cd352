"""The kinds of actions: a command, a correction of a controller's command, or a controller's parameters."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.settings import FollowSettings, OutOfRange
from sim.checks import check
from trackers.belief.features import command_of, is_seen, shares_of
from trackers.belief.sighting import BeliefFilter
from trackers.controllers.catalogue import ControllerEntry, controller_entry
from trackers.controllers.kernel_controller import share_beliefs
from trackers.protocols import Controller
from trackers.types import CameraCommand, Carrier, Estimate, Observation

_TOLERANCE = 1e-6


Steering = Callable[[NDArray[np.float64], Observation, Estimate], CameraCommand]
"""Returns the command of an action (A,) in [-1, 1], given the latest observation and estimate; one per episode."""


def steering(settings: FollowSettings, carrier: Carrier, beliefs: BeliefFilter | None = None) -> Steering:
    """Return the steering of a new episode.

    Args:
        beliefs: filters the estimates for others too; a controller by beliefs then need not do it a second time.
    """
    if settings.action == "command":
        return lambda action, observation, estimate: command_of(carrier, action)
    if isinstance(settings.controller, str):
        entry = controller_entry(settings.controller, carrier.name)
        controller = entry.create(**settings.controller_values)
        if beliefs is not None:
            share_beliefs(controller, beliefs)
        if settings.action == "parameters":
            return partial(_set_parameters, controller, entry.tunables())
    else:
        # A copy, so that no state carries over from one episode to the next.
        controller = copy.deepcopy(settings.controller)
    return partial(_corrected, settings, carrier, controller)


def _corrected(
    settings: FollowSettings,
    carrier: Carrier,
    controller: Controller,
    action: NDArray[np.float64],
    observation: Observation,
    estimate: Estimate,
) -> CameraCommand:
    """Return a controller's command, to which an action is added as a share of the limits."""
    own = _commanded(controller, observation, estimate)
    # Without a correction, keep the controller's command to the last bit: no division by a limit and back.
    if not action.any() or (settings.corrects == "unseen" and is_seen(estimate)):
        return own
    return command_of(carrier, shares_of(carrier, own) + settings.correction_share * action)


def _set_parameters(
    controller: Any,
    tunables: Mapping[str, dataclasses.Field[Any]],
    action: NDArray[np.float64],
    observation: Observation,
    estimate: Estimate,
) -> CameraCommand:
    """Return the command of a controller whose parameters an action sets: -1 the lowest value, 1 the highest."""
    shares = zip(tunables.items(), action, strict=True)
    values = {name: _placed(field, float(share)) for (name, field), share in shares}
    controller.parameters = dataclasses.replace(controller.parameters, **values)
    return _commanded(controller, observation, estimate)


def action_count(settings: FollowSettings, carrier: Carrier) -> int:
    """Return the length of an action.

    Raises:
        ValueError: for an unknown controller, values that it rejects, or a controller without tunable parameters.
    """
    named, sets = isinstance(settings.controller, str), settings.action == "parameters"
    wanted = "the name of a controller, for the action 'parameters'"
    check("controller", named or not sets, wanted, repr(settings.controller))
    if settings.action == "command" or not named:
        return len(carrier.axes)
    entry = controller_entry(settings.controller, carrier.name)
    check("controller", entry.role != "oracle", "one that knows no more than a policy", repr(entry.name))
    check_values(entry, settings.controller_values)
    count = len(entry.tunables()) if sets else len(carrier.axes)
    check("controller", count > 0, "one with parameters to set, for the action 'parameters'", repr(entry.name))
    return count


def checked_actions(actions: Any, shape: tuple[int, ...] | None, out_of_range: OutOfRange) -> NDArray[np.float64]:
    """Return a copy of an action, or of the actions of many envs, as floats; ``clip`` brings them into [-1, 1].

    Raises:
        ValueError: for another shape, numbers not finite, or with ``refuse`` outside [-1, 1].
    """
    try:
        given = np.array(actions, dtype=float)
    except (TypeError, ValueError):
        given = np.empty(0)
    clips = out_of_range == "clip"
    good = np.isfinite(given) if clips else np.abs(given) <= 1.0 + _TOLERANCE
    if given.shape != shape or not good.all():
        wanted = f"{'finite ' if clips else ''}numbers of shape {shape}{'' if clips else ' from -1 to 1'}"
        raise ValueError(f"action: expected {wanted}, got {_in_short(given, good, shape, actions)}")
    return np.clip(given, -1.0, 1.0) if clips else given


def _in_short(given: NDArray[np.float64], good: NDArray[np.bool_], shape: tuple[int, ...] | None, actions: Any) -> Any:
    """Return refused actions in short: those of many envs would fill the screen."""
    if given.ndim < 2:
        return actions
    if given.shape != shape:
        return f"shape {given.shape}"
    wrong = int(np.argmin(good.all(axis=1)))
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


def _placed(field: dataclasses.Field[Any], share: float) -> float | int:
    """Return the value at a share in [-1, 1] of a parameter's range."""
    low, high = field.metadata["low"], field.metadata["high"]
    place = 0.5 * (share + 1.0)
    value = low * (high / low) ** place if field.metadata["log"] else low + place * (high - low)
    return round(value) if isinstance(field.default, int) else value
