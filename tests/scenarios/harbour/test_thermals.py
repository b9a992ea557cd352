"""Temperatures that a shader gets, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.harbour.clutter import Clutter
from scenarios.harbour.conditions import draw_conditions, draw_waves
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.plan import draw_plan
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenery import build_scenery
from scenarios.harbour.thermals import Thermals
from scenarios.harbour.warmth import heated_k
from sim.rng import generator
from sim.shaders.thermal.shader import ThermalShader
from sim.world import Body, World

QUICK = PRESETS["quick"]
TIME_S = np.arange(QUICK.frame_count) / QUICK.rate_hz


def test_what_an_engine_heats_changes_on_every_frame_and_stone_in_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    shaded: dict[int, NDArray[np.float64]] = {}
    own = ThermalShader.set_parts

    def recorded(self: ThermalShader, bodies: Body | Sequence[Body], *kelvins: NDArray[np.float64]) -> None:
        own(self, bodies, *kelvins)
        shaded.update({each.index: kelvins[0] for each in ([bodies] if isinstance(bodies, Body) else bodies)})

    monkeypatch.setattr(ThermalShader, "set_parts", recorded)
    world, conditions, plan = World(), draw_conditions(QUICK, generator(3, "a")), draw_plan(QUICK, generator(3, "b"))
    scenery = build_scenery(world, generator(3, "c")).surfaces
    clutter = Clutter(world, plan, conditions, generator(3, "d"))
    intruders = Intruders(world, plan, conditions, TIME_S, generator(3, "e"))
    thermals = Thermals(
        world, conditions, scenery, clutter, intruders, QUICK.rate_hz, draw_waves(conditions, generator(3, "f"))
    )
    stone, checked = [], 0
    excess = {k: heated_k(visit.kind, TIME_S, visit.engine_s) for k, visit in enumerate(plan.visits) if visit.engine_s}
    assert {intruders.kinds[k] for k in excess} == {"car", "boat"}
    before: dict[int, NDArray[np.float64]] = {}
    for frame in range(QUICK.frame_count):
        thermals.show_frame(frame)
        stone.append(shaded[scenery[1].body.index])
        for k, heat in excess.items():
            now = shaded.get(int(intruders.instance_id[k]))
            if not intruders.presence[frame, k] or now is None:
                continue
            if frame % 15 and intruders.presence[frame - 1, k]:
                np.testing.assert_allclose(now - before[k], heat[frame] - heat[frame - 1], atol=1e-9)
                assert np.ptp(now - before[k]) > 1e-3
                checked += 1
            before[k] = now
    assert checked > 30
    changes = np.abs(np.diff(stone, axis=0)).max(axis=1)
    assert set(np.flatnonzero(changes) + 1) == {15, 30, 45}
    assert changes.max() < 0.06
