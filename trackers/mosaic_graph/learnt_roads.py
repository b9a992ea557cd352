"""Roads found by a small network, in place of the colours learnt where the target drove.

The network is a U-Net (Ronneberger et al. 2015) with group normalisation (Wu and He 2018). ``examples/learn_roads.py``
trains it with PyTorch; here NumPy evaluates it.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load_file

from trackers.mosaic_graph.road_network import RoadFinder, SeenGround

Maps = NDArray[np.float32]
"""(H, W, C)."""
SHIPPED = Path(__file__).with_name("learnt_roads.safetensors")
"""Weights trained on 80 towns of ``road-town-v2``, preset ``quick``, seeds 0 to 79."""
DOWN = ((4, 24, 2, 1), (24, 40, 2, 1), (40, 64, 2, 1), (64, 64, 1, 2), (64, 64, 1, 4), (64, 64, 1, 8))
"""Channels in and out, stride and dilation of the layers that come first."""
UP = ((64 + 40, 40, 1, 1), (40 + 24, 24, 1, 1))
"""Those after them, each behind a doubling of the size and beside the second and the first layer's output."""
GROUPS, FILTER = 8, 3
"""Number of groups of channels that are normalised together, and side of the filters."""
STRIDE = 8
"""The sides of the ground are multiples of it."""
_LEAST_VARIANCE = 1e-5
_LEVELS = np.float32(32)


class RoadNetwork:
    """From the colours of ground to log-odds of road."""

    def __init__(self, weights: Path) -> None:
        """Read ``weights``, named as PyTorch names them. Raises ValueError for a file that holds no such network."""
        try:
            self._of = load_file(weights)
        except (OSError, SafetensorError) as error:
            raise ValueError(f"weights: expected a safetensors file, got {weights} ({error})") from error
        found, wanted = {name: array.shape for name, array in self._of.items()}, _shapes()
        wrong = sorted(name for name in {*found, *wanted} if found.get(name) != wanted.get(name))
        if wrong:
            got = ", ".join(f"{name} {found.get(name, 'missing')}" for name in wrong)
            raise ValueError(f"weights: expected what examples/learn_roads.py writes, got {weights} with {got}")

    def log_odds(self, ground: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the log-odds of road (H, W) of colours (H, W, 3), 0 to 1, black where nothing was seen; H and W are
        multiples of ``STRIDE``.
        """
        out = np.dstack([ground - np.float32(0.5), (ground.sum(axis=2) > 0).astype(np.float32)])
        levels = [out := self._layer(out, f"down.{k}", *plan[2:]) for k, plan in enumerate(DOWN)]
        for k, beside in enumerate((levels[1], levels[0])):
            out = self._layer(np.concatenate([_doubled(out), beside], axis=2), f"up.{k}", *UP[k][2:])
        return _doubled(self._convolve(out, "last", 1, 1))[..., 0]

    def _layer(self, maps: Maps, name: str, stride: int, dilation: int) -> Maps:
        """Convolve, normalise the channels by groups, and cut off what is negative."""
        out = self._convolve(maps, f"{name}.0", stride, dilation)
        groups = out.reshape(-1, GROUPS, out.shape[2] // GROUPS)
        mean, variance = groups.mean(axis=(0, 2), keepdims=True), groups.var(axis=(0, 2), keepdims=True)
        normal = ((groups - mean) / np.sqrt(variance + np.float32(_LEAST_VARIANCE))).reshape(out.shape)
        positive: Maps = np.maximum(normal * self._of[f"{name}.1.weight"] + self._of[f"{name}.1.bias"], 0)
        return positive

    def _convolve(self, maps: Maps, name: str, stride: int, dilation: int) -> Maps:
        """Return the sum of the shifted maps, each times the filter of that shift; zeros are beyond the edge."""
        weight, (height, width, channels) = self._of[f"{name}.weight"], maps.shape
        around = np.pad(maps, ((dilation, dilation), (dilation, dilation), (0, 0)))
        size = -(-height // stride), -(-width // stride)
        out = np.tile(self._of[f"{name}.bias"], (size[0] * size[1], 1))
        for i, j in np.ndindex(FILTER, FILTER):
            y, x = i * dilation, j * dilation
            shifted = around[y : y + height : stride, x : x + width : stride]
            out += shifted.reshape(-1, channels) @ weight[:, :, i, j].T
        return out.reshape(*size, -1)


def _doubled(maps: Maps) -> Maps:
    """Return maps of twice the size, interpolated between the cells' centres."""
    height, width, channels = maps.shape
    doubled = cv2.resize(maps, (2 * width, 2 * height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(doubled, np.float32).reshape(2 * height, 2 * width, channels)


def _shapes() -> dict[str, tuple[int, ...]]:
    """Return the shapes of the network's arrays by name."""
    shapes: dict[str, tuple[int, ...]] = {"last.weight": (1, UP[-1][1], FILTER, FILTER), "last.bias": (1,)}
    for part, plan in (("down", DOWN), ("up", UP)):
        for k, (come, leave, _, _) in enumerate(plan):
            shapes[f"{part}.{k}.0.weight"] = (leave, come, FILTER, FILTER)
            shapes |= dict.fromkeys((f"{part}.{k}.{each}" for each in ("0.bias", "1.weight", "1.bias")), (leave,))
    return shapes


_network_of = cache(RoadNetwork)


class LearntRoads(RoadFinder):
    """Finds roads by a network."""

    def __init__(self, weights: Path) -> None:
        """Read ``weights``, once in a process; see ``RoadNetwork``."""
        self._network = _network_of(weights)

    def probability(self, ground: SeenGround) -> NDArray[np.float32]:
        """See ``RoadFinder``."""
        height, width = ground.seen.shape
        rgb = (ground.rgb * ground.seen[..., None]).astype(np.float32) / np.float32(255)
        whole = np.pad(rgb, ((0, -height % STRIDE), (0, -width % STRIDE), (0, 0)))
        log_odds = self._network.log_odds(whole)[:height, :width]
        # Rounded, so that last bits, which differ between processors, seldom decide.
        probability: NDArray[np.float32] = np.round((0.5 + 0.5 * np.tanh(0.5 * log_odds)) * _LEVELS) / _LEVELS
        return probability
