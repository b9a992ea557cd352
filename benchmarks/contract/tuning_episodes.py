"""The development episodes on which the methods of a scene are tuned."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TuningEpisodes:
    """Development episodes on which parameters are tuned, the same for all methods of a scene.

    Attributes:
        preset: of the scenario. seeds: of the episodes that score a setting.
        fresh: number of the episodes after them that check the best setting, in each preset of ``fresh_presets``.
        fresh_presets: presets where values that are good on ``preset`` may be bad: longer episodes, more targets;
            () = ``preset``.
    """

    preset: str = "standard"
    seeds: range = range(300, 304)
    fresh: int = 4
    fresh_presets: tuple[str, ...] = ()


DEFAULT_EPISODES = TuningEpisodes()
