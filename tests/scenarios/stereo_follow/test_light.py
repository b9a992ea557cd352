"""Changes of the light and their events: lamps are switched at the target's place, events begin and end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.stereo_follow.building import CORRIDOR_LIGHTS, HALL_LIGHTS, LIGHT_GROUPS, SKY, SUN, WINDOWS
from scenarios.stereo_follow.camera import SENSOR
from scenarios.stereo_follow.lighting import draw_light_plan
from scenarios.stereo_follow.presets import PRESETS, StereoFollow
from scenarios.stereo_follow.rig import LightEvents
from sim.sensors.config import Picture, SensorSettings

SEEDS = st.integers(0, 10_000)
RATE_HZ = 15.0


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, lamps=st.integers(0, 5), clouds=st.integers(0, 4))
def test_light_stays_within_its_strength_and_lamps_are_switched_where_the_target_is(seed, lamps, clouds):
    places = ("corridor",) * 110 + ("hall",) * 80 + ("door",) * 20 + ("yard",) * 90
    preset = StereoFollow("x", frame_count=len(places), lamp_events=lamps, clouds=clouds)
    light = draw_light_plan(preset, places, np.random.default_rng(seed))
    assert set(light.strengths) == set(LIGHT_GROUPS)
    assert len(light.switched) == len(places)
    for strength in light.strengths.values():
        assert strength.shape == (len(places),)
        assert -1e-9 <= strength.min() <= strength.max() <= 1 + 1e-9
    assert np.array_equal(light.strengths[SKY], light.strengths[WINDOWS])
    if not clouds:
        assert (light.strengths[SUN] == 1).all()
    if not lamps:
        assert light.switched == (None,) * len(places)
    for frame, event in enumerate(light.switched):
        if event is None or (frame > 0 and light.switched[frame - 1] == event):
            continue
        group = CORRIDOR_LIGHTS if places[frame] == "corridor" else HALL_LIGHTS
        strength = light.strengths[group]
        before, after = strength[max(frame - 4, 0)], strength[min(frame + 4, len(places) - 1)]
        assert places[frame] != "yard"
        # Between two events close together, the strengths depend on both.
        assert lamps > 1 or (before > 0.9, after < 0.4) == ((True, True) if event == "lamp off" else (False, False))


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, brightening_s=st.floats(0.2, 5.0))
def test_light_comes_back_as_slowly_as_told_and_goes_as_fast_as_ever(seed, brightening_s):
    places = ("corridor",) * 110 + ("hall",) * 80 + ("door",) * 20 + ("yard",) * 90
    sudden = StereoFollow("x", frame_count=len(places), lamp_events=3, clouds=3)
    slow = replace(sudden, brightening_s=brightening_s)
    fast, held = (draw_light_plan(preset, places, np.random.default_rng(seed)) for preset in (sudden, slow))
    for group, strength in held.strengths.items():
        assert (strength <= fast.strengths[group] + 1e-12).all()
        assert np.diff(np.log(strength)).max() <= 1.0 / (brightening_s * RATE_HZ) + 1e-9
        darker = np.flatnonzero(np.diff(fast.strengths[group]) < 0) + 1
        assert (strength[darker] <= fast.strengths[group][darker] + 1e-12).all()
    assert held.switched == fast.switched


def test_lamps_that_are_off_at_the_end_of_an_episode_stay_off():
    places = ("hall",) * 60
    ends = []
    for seed in range(60):
        light = draw_light_plan(PRESETS["quick"], places, np.random.default_rng(seed))
        strength = light.strengths[HALL_LIGHTS]
        if strength[-5] < 0.35:
            ends.append(strength[-1] < 0.5 and light.switched[-1] != "lamp on")
    assert len(ends) > 10
    assert np.mean(ends) > 0.9


class TestLightEvents:
    """Events on an invented path."""

    BRIGHT, DARK = 200, 20

    @staticmethod
    def events(places: Sequence[str], switched: Sequence[str | None] | None = None) -> LightEvents:
        return LightEvents(places, switched or (None,) * len(places), RATE_HZ)

    @staticmethod
    def picture(level: int) -> Picture:
        """Return a grey picture with settings for which a coat under 500 lx fills a fifth of the well."""
        nit = 0.3 * 500.0 / np.pi
        exposure_s = 0.2 * SENSOR.full_well_e / (SENSOR.electrons_per_nit_s * nit)
        return Picture(np.full((48, 64, 3), level, np.uint8), SensorSettings(exposure_s, 1.0))

    def test_a_steady_light_is_no_event(self):
        events = self.events(("hall",) * 40)
        assert {events.follow(k, self.picture(100), 500.0) for k in range(40)} == {None}

    def test_a_doorway_is_new_for_a_second_after_it_and_as_one_goes_in(self):
        events = self.events(("hall",) * 10 + ("door",) * 3 + ("yard",) * 40)
        found = [events.follow(k, self.picture(100), 500.0) for k in range(53)]
        assert found[:10] == [None] * 10
        assert set(found[10:24]) == {"doorway"}
        assert found[32:] == [None] * 21

    def test_shade_is_a_fall_within_a_second_and_slow_dusk_is_none(self):
        events = self.events(("yard",) * 60)
        lux = [9000.0] * 20 + [2000.0] * 40
        found = [events.follow(k, self.picture(60), value) for k, value in enumerate(lux)]
        assert found[19] is None
        assert set(found[20:35]) == {"shade"}
        assert found[-1] is None
        dusk = self.events(("yard",) * 120)
        assert {dusk.follow(k, self.picture(60), 9000.0 * 0.98**k) for k in range(120)} == {None}

    def test_back_light_begins_when_the_picture_gets_bright_around_him(self):
        events = self.events(("hall",) * 40)
        levels = [self.DARK] * 10 + [254] * 30
        found = [events.follow(k, self.picture(level), 500.0) for k, level in enumerate(levels)]
        assert found[9] is None
        assert set(found[10:25]) == {"back light"}
        assert found[26:] == [None] * 14

    def test_lamps_are_named_before_anything_else(self):
        switched = (None,) * 5 + ("lamp off",) * 15 + (None,) * 20
        events = self.events(("hall",) * 40, switched)
        lux = [500.0] * 5 + [50.0] * 35
        found = [events.follow(k, self.picture(100), value) for k, value in enumerate(lux)]
        assert set(found[5:20]) == {"lamp off"}
        # The fall due to the lamp is not shade when the lamp event ends.
        assert found[20:] == [None] * 20
