"""A trained policy as a controller, and its files: weights (safetensors) and their meaning (JSON), without code.

``NAME.json`` holds::

    {"format": 2, "env": "frameout/RoadTownFollow-v3",
     "carrier": {"name": "helicopter", "looks": "down", "axes": [["forward_mps", 25.0, 40.0], ...]},
     "tracker": "mosaic_graph_pf", "base": {"controller": "reentry", "parameters": {...}} or null,
     "correction_share": 0.7, "corrects": "always" | "unseen", "features": [...], "history": 6, "action_repeat": 4,
     "cells": 64, "layers": 3, "hidden": "tanh" | "relu", "output": "clip" | "tanh", "weights_sha256": "...",
     "made": {...}}

With ``base`` null the policy gives the whole command; otherwise it corrects that controller's. Its input is the
features and their changes over ``history`` pictures (``FeatureHistory``); an action holds for ``action_repeat``
pictures. ``made`` records the training. ``NAME.safetensors`` holds ``mean`` (in,) and ``deviation`` (in,), by which the
input is standardised, and ``weight_0`` (out, in), ``bias_0`` (out,), ``weight_1`` … With C > 0 ``cells`` the layers
follow an LSTM: ``cells_in`` (4 C, in), ``cells_back`` (4 C, C) and ``cells_bias`` (4 C,), of the gates in, forget, new
and out.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from trackers.atomic_file import write_atomic
from trackers.belief.features import FEATURES, FeatureFilter, FeatureHistory, command_of, is_seen, shares_of
from trackers.belief.sighting import BeliefFilter
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.kernel_controller import share_beliefs
from trackers.types import CameraCommand, Carrier, CommandAxis, Estimate, Observation

FORMAT = 2
_KEYS = (
    *("env", "carrier", "tracker", "base", "correction_share", "corrects", "features", "history", "action_repeat"),
    *("hidden", "output", "made"),
)
_CELLS = ("cells_in", "cells_back", "cells_bias")
LARGEST_INPUT = 10.0
"""Standardised numbers beyond it are clipped, as in training."""
_MOST_FRAMES = 1000


@dataclass(frozen=True)
class Policy:
    """A network from a belief's features to an action, and the action's meaning; see the module.

    Attributes:
        history: number of earlier pictures that it sees the changes since.
        action_repeat: number of pictures that an action holds.
        mean, deviation: (in,) float32 of its input in training.
        weights: (out, in) float32 of each layer. biases: (out,).
        cells: what the module says of an LSTM before the layers; () without one.
    """

    env: str
    carrier: Carrier
    tracker: str
    base: dict[str, Any] | None
    correction_share: float
    corrects: Literal["always", "unseen"]
    features: tuple[str, ...]
    history: int
    action_repeat: int
    hidden: Literal["tanh", "relu"]
    output: Literal["clip", "tanh"]
    mean: NDArray[np.float32]
    deviation: NDArray[np.float32]
    weights: tuple[NDArray[np.float32], ...]
    biases: tuple[NDArray[np.float32], ...]
    cells: tuple[NDArray[np.float32], ...] = ()
    made: dict[str, Any] = field(default_factory=dict)

    @property
    def cell_count(self) -> int:
        """Number of cells of the LSTM, 0 without one."""
        return self.cells[2].size // 4 if self.cells else 0

    def new_memory(self, count: int) -> NDArray[np.float32]:
        """Return the memory (2, B, C) at the beginning of B episodes: what each cell gives out, and what it keeps."""
        return np.zeros((2, count, self.cell_count), np.float32)

    def action(self, numbers: NDArray[np.float32], memory: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the actions (B, A) in [-1, 1], the mean of the distribution in training.

        Args:
            numbers: (B, in) of a ``FeatureHistory``.
            memory: (2, B, C) after the actions before; it is updated.
        """
        values = np.clip((numbers - self.mean) / self.deviation, -LARGEST_INPUT, LARGEST_INPUT)
        if self.cells:
            values = _remember(self.cells, values, memory)
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = values @ weight.T + bias
            if k + 1 < len(self.weights):
                values = np.tanh(values) if self.hidden == "tanh" else np.maximum(values, 0.0)
        values = values.astype(float)
        return np.tanh(values) if self.output == "tanh" else np.clip(values, -1.0, 1.0)


def _remember(
    cells: tuple[NDArray[np.float32], ...], values: NDArray[np.float32], memory: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Update the memory (2, B, C) by an input (B, in) and return what the cells give out (B, C).

    A long short-term memory (Hochreiter, Schmidhuber, Neural Computation 1997; Gers et al. 2000).
    """
    given, kept = memory
    from_input, back, bias = cells
    enter, stay, new, leave = np.split(values @ from_input.T + given @ back.T + bias, 4, axis=1)
    kept[:] = _gate(stay) * kept + _gate(enter) * np.tanh(new)
    given[:] = _gate(leave) * np.tanh(kept)
    return given


def _gate(x: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(0.5 + 0.5 * np.tanh(0.5 * x), np.float32)


def save_policy(policy: Policy, path: Path) -> Path:
    """Write ``path`` (JSON) and the weights beside it, each atomically, and return ``path``."""
    path = path.with_suffix(".json")
    tensors = {f"weight_{k}": weight for k, weight in enumerate(policy.weights)}
    tensors |= {f"bias_{k}": bias for k, bias in enumerate(policy.biases)}
    tensors |= {"mean": policy.mean, "deviation": policy.deviation} | dict(zip(_CELLS, policy.cells, strict=False))
    document = {"format": FORMAT} | {name: getattr(policy, name) for name in _KEYS}
    document |= {"cells": policy.cell_count, "layers": len(policy.weights)}
    axes = [dataclasses.astuple(axis) for axis in policy.carrier.axes]
    weights = save({k: np.ascontiguousarray(v) for k, v in tensors.items()})
    document["weights_sha256"] = hashlib.sha256(weights).hexdigest()
    document["carrier"] = {"name": policy.carrier.name, "looks": policy.carrier.looks, "axes": axes}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path.with_suffix(".safetensors"), weights)
    write_atomic(path, json.dumps(document, indent=1) + "\n")
    return path


def load_policy(file: str) -> Policy:
    """Return a policy by the path of its JSON or weights file.

    Raises:
        ValueError: if there is no such file, or it holds no policy of this format.
    """
    path = policy_path(file)
    got = repr(file) if path == Path(file) else f"{file!r}, whose JSON file would be {str(path)!r}"
    try:
        document = json.loads(path.read_text())
        stored = path.with_suffix(".safetensors").read_bytes()
        if hashlib.sha256(stored).hexdigest() != document["weights_sha256"]:
            raise ValueError("the weights that were saved with it, got others")
        tensors = load(stored)
        layers = range(document["layers"])
        if document["format"] != FORMAT:
            raise ValueError(f"format {FORMAT}, got {document['format']!r}")
        weights, biases = (tuple(tensors[f"{part}_{k}"] for k in layers) for part in ("weight", "bias"))
        values = {key: document[key] for key in _KEYS} | {"weights": weights, "biases": biases}
        values |= {name: tensors[name] for name in ("mean", "deviation")}
        values["cells"] = tuple(tensors[name] for name in _CELLS) if document["cells"] else ()
        carrier = document["carrier"]
        axes = tuple(CommandAxis(*axis) for axis in carrier["axes"])
        values["carrier"] = Carrier(carrier["name"], axes, carrier["looks"])
        values["features"] = tuple(document["features"])
        policy = Policy(**values)
        _check_shapes(policy)
    except OSError as error:
        missing = f" of {error.filename}" if str(error.filename) != str(path) else ""
        raise ValueError(f"policy: expected a file that can be read, got {got}: {error.strerror}{missing}") from None
    except (KeyError, TypeError, ValueError, SafetensorError) as error:
        reason = f"no {error} in it" if isinstance(error, KeyError) else str(error)
        raise ValueError(f"policy: expected a policy of format {FORMAT}, got {got}: {reason}") from None
    return policy


def policy_path(file: str) -> Path:
    """Return the JSON file of a policy by its path or that of its weights. Raises ValueError for no name of a file."""
    if not Path(file).name:
        raise ValueError(f"policy: expected a file, got {file!r}")
    return Path(file).with_suffix(".json")


def _check_shapes(policy: Policy) -> None:
    if policy.features != FEATURES:
        raise ValueError(f"one with the {len(FEATURES)} features of this version, got other features")
    for name, known in (("hidden", ("tanh", "relu")), ("output", ("clip", "tanh")), ("corrects", ("always", "unseen"))):
        if getattr(policy, name) not in known:
            raise ValueError(f"{name} of {' or '.join(known)}, got {getattr(policy, name)!r}")
    if not isinstance(policy.correction_share, int | float) or not 0 < policy.correction_share <= 2:
        raise ValueError(f"correction_share in (0, 2], got {policy.correction_share!r}")
    for name, least in (("history", 0), ("action_repeat", 1)):
        value = getattr(policy, name)
        if not isinstance(value, int) or not least <= value <= _MOST_FRAMES:
            raise ValueError(f"{name} of {least} to {_MOST_FRAMES}, got {value!r}")
    width = len(policy.features) * (1 + policy.history)
    for name in ("mean", "deviation"):
        values = getattr(policy, name)
        if values.shape != (width,) or not np.isfinite(values).all() or (name == "deviation" and values.min() <= 0):
            raise ValueError(f"{name} of {width} finite numbers{' > 0' if name == 'deviation' else ''}, got others")
    if policy.cells:
        cells = policy.cell_count
        wanted = [(4 * cells, width), (4 * cells, cells), (4 * cells,)]
        if [each.shape for each in policy.cells] != wanted or not all(np.isfinite(each).all() for each in policy.cells):
            raise ValueError(f"cells of finite numbers of the shapes {wanted}, got others")
        width = cells
    for weight, bias in zip(policy.weights, policy.biases, strict=True):
        if weight.ndim != 2 or weight.shape[1] != width or bias.shape != (len(weight),):
            raise ValueError(f"layers that fit each other, got {weight.shape} after {width} numbers")
        if not (np.isfinite(weight).all() and np.isfinite(bias).all()):
            raise ValueError("finite weights, got others")
        width = len(weight)
    if not policy.weights or width != len(policy.carrier.axes):
        raise ValueError(f"as many outputs as its carrier has axes, {len(policy.carrier.axes)}, got {width}")


@dataclass(frozen=True)
class PolicyParameters:
    """Settings.

    Attributes:
        file: the policy, see ``trackers.controllers.policy.load_policy``.
    """

    file: str


class PolicyController:
    """Computes belief, features, network and command of every picture, as the env does in training."""

    Parameters: type = PolicyParameters

    def __init__(self, parameters: PolicyParameters) -> None:
        self.parameters = parameters
        self._policy = policy = load_policy(parameters.file)
        beliefs = BeliefFilter(policy.carrier.looks)
        self._features, self._history = FeatureFilter(policy.carrier, beliefs), FeatureHistory(1, policy.history)
        self._pictures, self._shares = 0, np.zeros(len(policy.carrier.axes))
        self._memory = policy.new_memory(1)
        self._given = CameraCommand()
        base = policy.base
        self._base = None
        if base is not None:
            self._base = controller_entry(base["controller"], policy.carrier.name).create(**base["parameters"])
            share_beliefs(self._base, beliefs)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command of the policy's mean action."""
        policy = self._policy
        features = self._features.update(observation, estimate, self._given)[None]
        (self._history.add if self._pictures else self._history.begin)(features)
        if self._pictures % policy.action_repeat == 0:
            self._shares = policy.action(self._history.numbers(), self._memory)[0]
        self._pictures += 1
        shares = self._shares
        if self._base is not None:
            base = self._base.command(observation, estimate)
            if policy.corrects == "unseen" and is_seen(estimate):
                self._given = base
                return base
            shares = shares_of(policy.carrier, base) + policy.correction_share * shares
        self._given = command_of(policy.carrier, shares)
        return self._given
