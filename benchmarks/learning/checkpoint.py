"""Checkpoints of a training without pickle: tensors as safetensors, a replay buffer as arrays, numbers as JSON."""

from __future__ import annotations

import json
import secrets
import shutil
from pathlib import Path
from typing import Any

import numpy as np

_FOLDER, _OLD = "checkpoint", ".checkpoint.old"
_REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
_OPTIMISER = "optimizer"


def save_checkpoint(model: Any, out: Path, settings: dict[str, Any]) -> None:
    """Write a model's state atomically: a killed run leaves the previous checkpoint."""
    from safetensors.torch import save

    for left_over in out.glob(f".{_FOLDER}.new.*"):
        shutil.rmtree(left_over, ignore_errors=True)
    beside = out / f".{_FOLDER}.new.{secrets.token_hex(8)}"
    beside.mkdir(parents=True)
    # save_file does not raise OSError on a full disk.
    (beside / "tensors.safetensors").write_bytes(save(_tensors(model)))
    state = {"settings": settings, "steps": model.num_timesteps, "updates": model._n_updates}
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        filled = buffer.buffer_size if buffer.full else buffer.pos
        np.savez(beside / "replay.npz", **{name: getattr(buffer, name)[:filled] for name in _REPLAYED})
        state |= {"replay_position": int(buffer.pos), "replay_full": bool(buffer.full)}
    (beside / "state.json").write_text(json.dumps(state) + "\n")
    place, old = out / _FOLDER, out / _OLD
    if place.exists():
        shutil.rmtree(old, ignore_errors=True)
        place.rename(old)
    beside.rename(place)
    shutil.rmtree(old, ignore_errors=True)


def checkpointed_settings(out: Path) -> dict[str, Any] | None:
    """Return the settings of the checkpoint in a folder, None if there is none."""
    state = _latest(out) / "state.json"
    if not state.is_file():
        return None
    settings: dict[str, Any] = json.loads(state.read_text())["settings"]
    return settings


def checkpointed_steps(out: Path) -> int:
    """Return the number of steps before the checkpoint in a folder."""
    return int(json.loads((_latest(out) / "state.json").read_text())["steps"])


def load_checkpoint(model: Any, out: Path) -> None:
    """Load the checkpoint in a folder into a fresh model of the same settings."""
    from safetensors.torch import load_file

    folder = _latest(out)
    state = json.loads((folder / "state.json").read_text())
    parameters = model.get_parameters()
    for name, tensor in load_file(folder / "tensors.safetensors").items():
        group, *keys = name.split("/")
        if group == "log_ent_coef":
            model.log_ent_coef.data.copy_(tensor)
        elif _OPTIMISER in group:
            # The optimiser is fresh: its groups come from the settings.
            parameters[group]["state"].setdefault(int(keys[0]), {})[keys[1]] = tensor
        else:
            parameters[group][keys[0]] = tensor
    model.set_parameters(parameters)
    model.num_timesteps, model._n_updates = state["steps"], state["updates"]
    buffer = getattr(model, "replay_buffer", None)
    if buffer is not None:
        with np.load(folder / "replay.npz", allow_pickle=False) as arrays:
            for name in _REPLAYED:
                getattr(buffer, name)[: len(arrays[name])] = arrays[name]
        buffer.pos, buffer.full = state["replay_position"], state["replay_full"]


def _latest(out: Path) -> Path:
    """Return the folder of the checkpoint; the previous one after a kill between the two renames."""
    return out / _FOLDER if (out / _FOLDER).exists() else out / _OLD


def _tensors(model: Any) -> dict[str, Any]:
    """Return all tensors of a model by ``group/name``, those of optimisers by ``group/number/name``."""
    tensors: dict[str, Any] = {}
    for group, content in model.get_parameters().items():
        if _OPTIMISER in group:
            for number, values in content["state"].items():
                tensors |= {f"{group}/{number}/{name}": value for name, value in values.items()}
        else:
            tensors |= {f"{group}/{name}": value for name, value in content.items()}
    if getattr(model, "log_ent_coef", None) is not None:
        tensors["log_ent_coef"] = model.log_ent_coef
    return {name: tensor.detach().clone().contiguous() for name, tensor in tensors.items()}
