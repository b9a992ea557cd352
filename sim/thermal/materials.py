"""Materials of surfaces out of doors, by what determines their temperature.

Emissivities in 8 to 14 µm are those of the ECOSTRESS library (Meerdink et al. 2019) and of common tables of thermal
cameras; solar absorptivities are of ASHRAE's and Duffie and Beckman's tables. The layer that follows the day's cycle
has the areal heat capacity ``density * specific heat * thickness``, with the thickness of the sheet, or for thick
bodies the depth to which the day's wave reaches. ``coupling`` is the conductance to what lies behind that layer, which
keeps the day's mean temperature (``behind`` = ``mean``) or that of the air (``air``), or of a heated room (``room``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sim.checks import check_types, check_within


@dataclass(frozen=True, slots=True)
class Material:
    """A surface layer.

    Attributes:
        emissivity: in 8 to 14 µm, 0 to 1.
        absorptivity: of sunlight, 0 to 1.
        capacity_j_m2k: heat that warms a square metre by 1 K.
        coupling_w_m2k: conductance to what lies behind.
        behind: what that is.
    """

    emissivity: float
    absorptivity: float
    capacity_j_m2k: float
    coupling_w_m2k: float
    behind: Literal["mean", "air", "room"] = "mean"

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "emissivity absorptivity", 0, 1)
        check_within(self, "capacity_j_m2k", 0, above=True)
        check_within(self, "coupling_w_m2k", 0)


def _sheet(kg_m3: float, j_kgk: float, thickness_m: float) -> float:
    return kg_m3 * j_kgk * thickness_m


MATERIALS: dict[str, Material] = {
    "concrete": Material(0.94, 0.65, _sheet(2300, 880, 0.08), 9.0),
    "asphalt": Material(0.95, 0.90, _sheet(2240, 920, 0.07), 8.0),
    "gravel": Material(0.93, 0.70, _sheet(1600, 840, 0.05), 4.0),
    "grass": Material(0.97, 0.75, _sheet(300, 3000, 0.02), 3.0),
    "brick": Material(0.93, 0.65, _sheet(1800, 840, 0.07), 4.0),
    "granite": Material(0.92, 0.60, _sheet(2650, 790, 0.10), 12.0),
    "timber": Material(0.91, 0.60, _sheet(550, 1700, 0.025), 2.0, "air"),
    "painted steel": Material(0.93, 0.50, _sheet(7850, 490, 0.003), 5.0, "air"),
    "dark paint": Material(0.94, 0.90, _sheet(7850, 490, 0.0012), 4.0, "air"),
    "white paint": Material(0.92, 0.25, _sheet(7850, 490, 0.0012), 4.0, "air"),
    "bare metal": Material(0.25, 0.40, _sheet(2700, 900, 0.002), 5.0, "air"),
    "roof sheet": Material(0.88, 0.60, _sheet(7850, 490, 0.0007), 1.2, "air"),
    "roof felt": Material(0.93, 0.90, _sheet(1100, 1400, 0.012), 0.6, "room"),
    "fibreglass": Material(0.92, 0.30, _sheet(1700, 1000, 0.008), 3.0, "air"),
    "glass": Material(0.84, 0.15, _sheet(2500, 840, 0.004), 5.5, "room"),
    "car glass": Material(0.84, 0.40, _sheet(2500, 840, 0.004), 5.0, "air"),
    "rubber": Material(0.94, 0.92, _sheet(1100, 1900, 0.012), 2.0, "air"),
    "rope": Material(0.92, 0.60, _sheet(600, 1400, 0.015), 6.0, "air"),
    "canvas": Material(0.92, 0.55, _sheet(500, 1400, 0.001), 3.0, "air"),
    "feathers": Material(0.97, 0.50, _sheet(100, 1500, 0.01), 1.5, "air"),
}
"""By name."""
