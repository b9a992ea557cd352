"""Checks that presets of all scenes share: size, number and rate of the pictures."""

from __future__ import annotations

from typing import Any

from sim.checks import check

MOST_FRAMES = 100_000
"""Most pictures of an episode: it is planned as a whole, and its poses stand in memory."""
_SLOWEST_HZ, _FASTEST_HZ = 0.01, 1000.0


def check_size(preset: Any) -> None:
    """Raise ValueError for a ``width_px`` or a ``height_px`` that is not drawn."""
    for name in ("width_px", "height_px"):
        value = getattr(preset, name)
        check(name, 32 <= value <= 4096, "a whole number from 32 to 4096", value)


def check_length(preset: Any, longest_s: float) -> None:
    """Raise ValueError for a ``frame_count`` or a ``rate_hz`` that no episode has, or that last too long together.

    Args:
        longest_s: the time for which the scene goes on, seconds.
    """
    frames, rate, slowest = preset.frame_count, preset.rate_hz, max(_SLOWEST_HZ, 2.0 / longest_s)
    check("rate_hz", slowest <= rate <= _FASTEST_HZ, f"a number in [{slowest:.3g}, {_FASTEST_HZ:g}]", rate)
    most = min(MOST_FRAMES, int(longest_s * rate))
    why = f", as an episode lasts {longest_s:g} s at the most" if most < MOST_FRAMES else ""
    check("frame_count", 2 <= frames <= most, f"a whole number in [2, {most}]{why}", frames)
