"""Crews: people aboard the boats that come to drawn harbours, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenario import HARBOUR, HarbourEpisode
from scenarios.objects import AWAY_M

SMALL = replace(
    PRESETS["swell"],
    width_px=192,
    height_px=144,
    background=2,
    frame_count=16,
    rate_hz=0.05,
    people=1,
    cars=0,
    cars_before=0,
)


@pytest.fixture(scope="module")
def episode() -> HarbourEpisode:
    made = HARBOUR.episode(SMALL, 4)
    assert isinstance(made, HarbourEpisode)
    return made


def test_they_stand_on_the_deck_of_boats_that_are_there(episode: HarbourEpisode) -> None:
    crews, intruders = episode._crews, episode._objects
    assert crews is not None
    assert {one.boat for one in crews._all} == {k for k, kind in enumerate(intruders.kinds) if kind == "boat"}
    assert len(crews.standing) >= 2
    seen = 0
    for frame in range(SMALL.frame_count):
        intruders.move_to(frame)
        crews.move_to(frame)
        for one in crews._all:
            poses = episode.world.poses[[body.index for body in one.bodies]]
            if not intruders.presence[frame, one.boat]:
                assert (poses[:, 2, 3] == AWAY_M).all()
                continue
            seen += 1
            aboard = np.linalg.inv(intruders.course[frame, one.boat]) @ poses
            half = 0.5 * intruders.size_m[one.boat]
            assert (np.abs(aboard[:, 0, 3]) < half[0]).all()
            assert (np.abs(aboard[:, 1, 3]) < half[1] + 0.1).all()
            # Feet are on a deck that lies above the water and below the rail.
            assert 0.2 < aboard[[9, 12], 2, 3].min() < 1.3
    assert seen > 3


def test_they_are_people_among_what_stands_about_and_warm(episode: HarbourEpisode) -> None:
    warmest = 0.0
    for _ in range(SMALL.frame_count):
        frame = episode.step()
        truth, counts = frame.truth, frame.observation.counts
        aboard = [k for k, name in enumerate(truth.standing_names) if name.startswith("crew-")]
        for k in aboard:
            assert truth.standing_kinds[k] == "person"
            rows, columns = np.nonzero(truth.instance_map == truth.standing_id[k])
            x_min, y_min, x_max, y_max = truth.standing_box_xyxy[k]
            assert ((columns + 1 > x_min) & (columns < x_max) & (rows + 1 > y_min) & (rows < y_max)).all()
            sea = counts[truth.instance_map == episode._clutter.sea.index]
            warmest = max(warmest, counts[rows, columns].max() - np.median(sea))
    # Six kelvins.
    assert warmest > 360


def test_no_crew_is_in_the_pictures_without_intruders(episode: HarbourEpisode) -> None:
    people = [k for k, body in enumerate(episode.world.bodies) if body.category == "person"]
    taken = []
    original = episode._clutter.move_to

    def watch(*arguments: object) -> None:
        original(*arguments)  # type: ignore[arg-type]
        taken.append((episode.world.poses[people, 2, 3] == AWAY_M).all())

    episode._clutter.move_to = watch  # type: ignore[method-assign,assignment]
    episode._empty_pictures()
    assert len(taken) == SMALL.background
    assert all(taken)


def test_the_one_site_of_standing_presets_has_none() -> None:
    assert HARBOUR.episode("quick[background=0,width_px=64,height_px=48]", 0)._crews is None
