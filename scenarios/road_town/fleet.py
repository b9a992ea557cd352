"""Which vehicles drive in a town, and in which paint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenarios.road_town.canvas import Rgb, draw_paint
from sim.meshes.vehicle import VehicleClass, class_of

SHARES: dict[str, float] = {"lorry": 0.3, "flatbed": 0.2, "tanker": 0.1, "bus": 0.3, "coach": 0.15, "motorbike": 0.45}
"""How often a model is drawn, of 1 for a car: beside the six cars a fifth are others.

Chosen, so that most episodes hold some of each class. On the roads of Great Britain lorries are about 5 % of the
traffic, buses and motorbikes 1 % each (Department for Transport, road traffic estimates, 2022).
"""
CRUISES_AT: dict[VehicleClass, float] = {"car": 1.0, "lorry": 0.85, "bus": 0.85, "motorbike": 1.0}
"""Speed on a free straight, as a share of a car's; chosen."""
_PAINTS: dict[VehicleClass, tuple[Rgb, ...]] = {
    "lorry": (
        (228, 228, 224),
        (176, 24, 26),
        (28, 62, 150),
        (222, 176, 32),
        (24, 92, 58),
        (92, 95, 99),
        (60, 120, 180),
    ),
    "bus": ((196, 30, 32), (222, 176, 32), (40, 96, 160), (60, 128, 72), (228, 228, 224), (208, 92, 24), (96, 60, 110)),
    "motorbike": ((26, 26, 29), (176, 24, 26), (28, 62, 150), (60, 140, 60), (208, 92, 24)),
}
"""Paints of others than cars, each as likely; a livery's further colours follow from them."""


def draw_model(models: Sequence[str], rng: np.random.Generator) -> str:
    """Draw one of ``models`` by its share."""
    shares = np.array([SHARES.get(model, 1.0) for model in models])
    if (shares == shares[0]).all():
        return models[int(rng.integers(len(models)))]
    return models[int(rng.choice(len(models), p=shares / shares.sum()))]


def livery(model: str, paint_rgb: Rgb, rng: np.random.Generator, unlike: Rgb | None = None) -> Rgb:
    """Return the paint for a model: a car's own, else one drawn for its class, other than ``unlike``."""
    paints = [paint for paint in _PAINTS.get(class_of(model), ()) if paint != unlike]
    return paints[int(rng.integers(len(paints)))] if paints else paint_rgb


def draw_car(models: Sequence[str], rng: np.random.Generator) -> tuple[str, Rgb]:
    """Draw a vehicle: its model and paint."""
    model, paint = draw_model(models, rng), draw_paint(rng)
    return model, livery(model, paint, rng)
