"""Presets of ``fish-tank``."""

from __future__ import annotations

from dataclasses import dataclass, field

from scenarios.fish_tank.character import AYU, CROWD, ZEBRAFISH, Character
from scenarios.preset_checks import check_length, check_size
from sim.checks import check_types, check_within
from sim.shaders.water import Water
from sim.water_surface import Ripples

_LONGEST_S = 3600.0


@dataclass(frozen=True, slots=True)
class FishTank:
    """Configuration of an episode.

    Attributes:
        summary: one line.
        frame_count, rate_hz: number of frames, and frames per second.
        width_px, height_px: of each picture; it always shows the whole tank.
        closed_loop: True if commands steer the second camera, False if it stays.
        fish: number of fish.
        variety: 0 for fish that look alike, 1 for differences of size, shade and pattern as in a mixed stock.
        character: how they swim.
        glare: how much of the water mirrors lamps, 0 to 1, see ``room_lights``.
        lamp: brightness of the lamp that throws sharp shadows and caustics, 0 to 1.
        ripples: of the surface. water: what is in it.
    """

    summary: str
    frame_count: int = 900
    rate_hz: float = 30.0
    width_px: int = 640
    height_px: int = 480
    closed_loop: bool = False
    fish: int = 10
    variety: float = 0.6
    character: Character = ZEBRAFISH
    glare: float = 0.4
    lamp: float = 1.0
    ripples: Ripples = field(default_factory=Ripples)
    water: Water = field(default_factory=Water)

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        check_length(self, _LONGEST_S)
        check_within(self, "fish", 1, 150)
        check_within(self, "variety glare lamp", 0, 1)


PRESETS = {
    "standard": FishTank("ten zebrafish in clear, rippled water"),
    "hard": FishTank(
        "a hundred fish that look alike in murky water",
        frame_count=450,
        fish=100,
        variety=0.1,
        character=CROWD,
        glare=1.0,
        ripples=Ripples(slope_rms=0.03),
        water=Water(scattering_per_m=6.0),
    ),
    "quick": FishTank("five fish in small pictures", frame_count=200, width_px=320, height_px=240, fish=5),
    "paper-c": FishTank(
        "the paper's experiment: one slow fish in still water under soft light",
        fish=1,
        character=AYU,
        glare=0.0,
        lamp=0.0,
        ripples=Ripples(slope_rms=0.003),
    ),
}
