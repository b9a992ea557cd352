"""Where a swinging camera will look: a small network over its latest tilts, learnt by ``python -m tools learn-swings``.

A *tilt* is the tangent of the optical axis' angle from where it points in still air: ahead and right, over the height.
The forecast turns with the tilts and is mirrored with them: the network sees them in axes along the latest tilt and
answers twice, for them and for their mirror image. Tilts of zero are expected to stay so.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.records import record_kernel

FORECAST_FILE = "swing_forecast.json"
HISTORY = 12
"""Number of changes of the tilt that the network sees, ``step_s`` apart."""
TILTS = 32
"""Number of tilts that are kept."""
_STEEPEST = 3.0
"""Limit of tilts; an axis near the horizon has no other."""
_CHANGE_SCALE = 5.0
LEAST_LOG, MOST_LOG = -6.0, 2.0
"""Limits of the logarithm of a standard deviation."""

TILT_FIELDS: list[Any] = [("tilt", "f8", (TILTS, 2)), ("tilt_s", "f8", (TILTS,)), ("tilts", "f8")]
"""What is kept from picture to picture: the latest tilts and their times, the latest first, and their number."""


class SwingForecast(NamedTuple):
    """The network: two layers of tanh units, then at each time the change of the tilt, along and across, and the
    logarithm of its standard deviation.

    Attributes:
        step_s: time between the tilts that it sees. at_s: (K,) times ahead at which it answers.
        weights_1, bias_1, weights_2, bias_2, weights_3, bias_3: (out, in) and (out,) of its layers.
    """

    step_s: float
    at_s: NDArray[np.float64]
    weights_1: NDArray[np.float64]
    bias_1: NDArray[np.float64]
    weights_2: NDArray[np.float64]
    bias_2: NDArray[np.float64]
    weights_3: NDArray[np.float64]
    bias_3: NDArray[np.float64]


@cache
def swing_forecast() -> SwingForecast:
    """Return the network that is shipped."""
    return read_forecast(json.loads(resources.files("trackers.controllers").joinpath(FORECAST_FILE).read_text()))


def read_forecast(content: dict[str, Any]) -> SwingForecast:
    """Return the network of a file's content."""
    numbers = {name: np.array(content[name], dtype=float) for name in SwingForecast._fields[1:]}
    return SwingForecast(float(content["step_s"]), **numbers)


@record_kernel()
def keep_tilt(memory: Any, ahead: float, right: float, time_s: float) -> None:
    """Add the tilt of a picture to a memory with ``TILT_FIELDS``."""
    for k in range(TILTS - 1, 0, -1):
        memory.tilt_s[k] = memory.tilt_s[k - 1]
        memory.tilt[k, 0], memory.tilt[k, 1] = memory.tilt[k - 1, 0], memory.tilt[k - 1, 1]
    memory.tilt_s[0] = time_s
    memory.tilt[0, 0] = min(max(ahead, -_STEEPEST), _STEEPEST)
    memory.tilt[0, 1] = min(max(right, -_STEEPEST), _STEEPEST)
    memory.tilts = min(memory.tilts + 1.0, TILTS)


@record_kernel()
def kept_tilts(memory: Any, step_s: float, out: NDArray[np.float64]) -> None:
    """Write the tilts of now, of ``step_s`` ago and so on to ``out`` (N, 2), interpolated; the oldest one before it."""
    after = 0
    for k in range(len(out)):
        time_s = memory.tilt_s[0] - k * step_s
        while after + 1 < memory.tilts and memory.tilt_s[after + 1] > time_s:
            after += 1
        before = after + 1 if after + 1 < memory.tilts else after
        span_s = memory.tilt_s[after] - memory.tilt_s[before]
        share = min((memory.tilt_s[after] - time_s) / span_s, 1.0) if span_s > 0.0 else 0.0
        for axis in range(2):
            out[k, axis] = memory.tilt[after, axis] + share * (memory.tilt[before, axis] - memory.tilt[after, axis])


@record_kernel()
def inputs_of(tilts: NDArray[np.float64], out: NDArray[np.float64]) -> tuple[float, float]:
    """Write what the network sees of tilts (HISTORY + 1, 2), the latest first: its size, then changes, latest first,
    along it and across it, to the right. Return cosine and sine of its direction.
    """
    far = np.hypot(tilts[0, 0], tilts[0, 1])
    c, s = (tilts[0, 0] / far, tilts[0, 1] / far) if far > 0.0 else (1.0, 0.0)
    out[0] = far
    for k in range(HISTORY):
        ahead, right = tilts[k, 0] - tilts[k + 1, 0], tilts[k, 1] - tilts[k + 1, 1]
        out[1 + 2 * k] = _CHANGE_SCALE * (c * ahead + s * right)
        out[2 + 2 * k] = _CHANGE_SCALE * (c * right - s * ahead)
    return c, s


@record_kernel()
def foresee(
    tilts: NDArray[np.float64],
    network: SwingForecast,
    times_s: NDArray[np.float64],
    out: NDArray[np.float64],
    spreads: NDArray[np.float64],
) -> None:
    """Write expected tilts (T, 2) to ``out`` and their standard deviations (T,), an axis each, to ``spreads``.

    Args:
        tilts: (HISTORY + 1, 2) latest tilts, ``step_s`` apart, the latest first.
        times_s: (T,) times ahead, ascending; what is expected of the last one at which the network answers holds on.
    """
    seen = np.zeros(1 + 2 * HISTORY)
    still = _answer(network, seen)
    c, s = inputs_of(tilts, seen)
    answer = _answer(network, seen)
    seen[2::2] *= -1.0
    mirrored = _answer(network, seen)
    places, last = network.at_s, len(network.at_s) - 1
    k = 0
    for t in range(len(times_s)):
        time_s = min(times_s[t], places[last])
        while k < last and places[k] < time_s:
            k += 1
        before_s = places[k - 1] if k > 0 else 0.0
        share = (time_s - before_s) / (places[k] - before_s)
        along = across = spread = 0.0
        for knot, weight in ((k - 1, 1.0 - share), (k, share)):
            if knot >= 0:
                along += weight * (0.5 * (answer[knot, 0] + mirrored[knot, 0]) - still[knot, 0])
                across += weight * 0.5 * (answer[knot, 1] - mirrored[knot, 1])
                spread += weight * 0.5 * (answer[knot, 2] + mirrored[knot, 2])
        out[t, 0] = min(max(tilts[0, 0] + c * along - s * across, -_STEEPEST), _STEEPEST)
        out[t, 1] = min(max(tilts[0, 1] + s * along + c * across, -_STEEPEST), _STEEPEST)
        spreads[t] = spread


@record_kernel()
def _answer(network: SwingForecast, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the network's answer (K, 3): changes of the tilt along and across, and their standard deviation."""
    first = _layer(network.weights_1, network.bias_1, seen, True)
    second = _layer(network.weights_2, network.bias_2, first, True)
    answer = _layer(network.weights_3, network.bias_3, second, False).reshape(-1, 3)
    for k in range(len(answer)):
        answer[k, 2] = np.exp(min(max(answer[k, 2], LEAST_LOG), MOST_LOG))
    return answer


@record_kernel()
def _layer(
    weights: NDArray[np.float64], bias: NDArray[np.float64], given: NDArray[np.float64], bends: bool
) -> NDArray[np.float64]:
    out = np.zeros(len(bias))
    for row in range(len(bias)):
        total = bias[row]
        for column in range(len(given)):
            total += weights[row, column] * given[column]
        out[row] = np.tanh(total) if bends else total
    return out
