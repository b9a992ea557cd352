"""The room's light over the tank: a pair of tubes, a skylight and a small lamp, which differ from day to day."""

from __future__ import annotations

import numpy as np

from sim.shaders.water import Panel

_CEILING_M = 2.6
"""Height of the ceiling above the tank's floor."""


def room_lights(rng: np.random.Generator, glare: float, lamp: float) -> tuple[Panel, ...]:
    """Return the bright panels of one day.

    Args:
        glare: 0 for tubes and skylight so far aside that only steep ripples mirror them, 1 for a surface that mirrors
            them along the tank's short sides.
        lamp: brightness of the small lamp, which throws sharp shadows and caustics; 0 for none, 1 for the usual one.
    """
    side = 1.0 if rng.random() < 0.5 else -1.0
    aside_m = 0.4 * (1.0 - glare)
    tube_x_m, tube_y_m = aside_m + rng.uniform(0.6, 0.85, 2), rng.uniform(-0.2, 0.2, 2)
    tubes_nit, tubes_k = rng.uniform(5000.0, 9000.0), float(rng.choice((3000.0, 4000.0, 5000.0)))
    tubes = tuple(
        Panel(
            (float(sign * x_m), float(y_m), _CEILING_M),
            (0.0, 1.2, 0.0),
            (0.05, 0.0, 0.0),
            luminance_nit=float(tubes_nit),
            temperature_k=tubes_k,
        )
        for sign, x_m, y_m in zip((side, -side), tube_x_m, tube_y_m, strict=True)
    )
    skylight = Panel(
        (float(side * (aside_m + rng.uniform(0.9, 1.4))), float(rng.uniform(-1.2, 1.2)), _CEILING_M),
        (0.7, 0.0, 0.0),
        (0.0, 0.9, 0.0),
        luminance_nit=float(rng.uniform(600.0, 2500.0)),
        temperature_k=6500.0,
        panes=(2, 3),
        bar_share=0.12,
    )
    spot = Panel(
        (float(-side * rng.uniform(0.9, 1.3)), float(rng.uniform(-0.9, 0.9)), 1.9),
        (0.07, 0.0, 0.0),
        (0.0, 0.07, 0.0),
        luminance_nit=lamp * float(rng.uniform(2e5, 5e5)),
        temperature_k=tubes_k,
    )
    return (*tubes, skylight, spot)
