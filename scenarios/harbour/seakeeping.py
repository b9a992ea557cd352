"""How a boat heaves, rolls and pitches on the very waves that the picture shows.

The surface is ``Re sum A exp(i (k . x - w t))``, see ``sim.thermal.waves``. A hull at rest, of length L and beam B,
feels each wave averaged over its waterplane, as closed-form methods take it (Jensen, Mansour and Olsen, "Estimation of
ship motions using closed-form expressions", Ocean Engineering 31, 2004),

    S = A sin(k_x L / 2) / (k_x L / 2) sin(k_y B / 2) / (k_y B / 2)       k_x along the hull, k_y to its left
    heave = Re sum S,  pitch slope = Re sum i k_x S,  roll slope = Re sum i k_y S / (1 - r² - 2 i z r),  r = w / w_roll

Heave and pitch of a small boat follow without delay; roll is an oscillator of the period ``2 C B / sqrt(GM)`` with
``C = 0.373 + 0.023 B / d - 0.043 L / 100`` (IMO, 2008 IS Code, 2.3), here with a draught d of B / 4 and a metacentric
height GM of 0.25 B, and the damping z of hard-chined hulls at rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.conditions import Rocking
from sim.thermal.waves import SeaWaves

_GRAVITY_MPS2 = 9.81
_DAMPING = 0.12
_STRONGEST = 96
"""Components of the sea that move a boat; others are too short or too weak."""


def roll_period_s(length_m: float, beam_m: float) -> float:
    """Return the period at which a boat rolls on its own."""
    c = 0.373 + 0.023 * 4.0 - 0.043 * length_m / 100.0
    return float(2.0 * c * beam_m / np.sqrt(0.25 * beam_m))


def afloat_on(
    waves: SeaWaves,
    time_s: NDArray[np.float64],
    place_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
    length_m: float,
    beam_m: float,
) -> Rocking:
    """Return the motion at times (F,) of a boat at places (F, 2) with headings (F,)."""
    kx, ky, omega, amplitude = waves.strongest(_STRONGEST)
    c, s = np.cos(heading_rad)[:, None], np.sin(heading_rad)[:, None]
    along, left = kx * c + ky * s, ky * c - kx * s
    # NumPy's sinc has pi in it.
    felt = np.sinc(along * length_m / (2.0 * np.pi)) * np.sinc(left * beam_m / (2.0 * np.pi))
    phase = place_m[:, :1] * kx + place_m[:, 1:2] * ky - time_s[:, None] * omega
    wave = amplitude * np.exp(1j * phase) * felt
    ratio = omega * roll_period_s(length_m, beam_m) / (2.0 * np.pi)
    rolls = 1.0 / (1.0 - ratio**2 - 2j * _DAMPING * ratio)
    slopes = (1j * along * wave).sum(axis=1).real, (1j * left * wave * rolls).sum(axis=1).real
    # The bow rises where the surface does so ahead: pitch turns it down, roll its left side up.
    return Rocking(wave.sum(axis=1).real, np.arctan(slopes[1]), -np.arctan(slopes[0]))
