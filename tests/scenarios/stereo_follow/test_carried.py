"""People with things of one's own in the hand and on the back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from benchmarks.run.editions import preset_edition
from scenarios.stereo_follow.carried import Carried, draw_carried, laden_size_m, loads_of, without_backpack
from scenarios.stereo_follow.plan import TARGET, make_plan
from scenarios.stereo_follow.presets import NOTHING, PRESETS
from scenarios.stereo_follow.scenario import STEREO_FOLLOW, People
from sim.meshes.person import person_size_m, standing_m
from sim.meshes.person_parts import PersonLook
from sim.meshes.population import draw_person
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, skeleton
from sim.rng import generator
from sim.world import World

QUICK = PRESETS["quick"]
LOOKS = [PersonLook(), *(draw_person(generator(seed, "looks"), children=0.5) for seed in range(6))]


def box(path: Path, size_m: tuple[float, float, float]) -> str:
    shape = trimesh.creation.box(size_m)
    shape.visual.face_colors = (200, 30, 20, 255)
    shape.export(path)
    return str(path)


def corners(load, look: PersonLook, phase_rad: float, speed_mps: float) -> NDArray[np.float64]:
    bones = skeleton(look.stature_m, look.build, look.figure)
    T = load.pose(np.eye(4), part_poses(bones, np.eye(4), phase_rad, speed_mps))
    return load.mesh.vertices_m @ T[:3, :3].T + T[:3, 3]


@pytest.mark.parametrize("look", LOOKS, ids=range(len(LOOKS)))
@pytest.mark.parametrize("height_m", [0.3, 1.1])
def test_a_thing_in_the_hand_hangs_beside_the_body_and_off_the_ground(tmp_path: Path, look, height_m: float):
    (load,) = loads_of(look, Carried(hand=box(tmp_path / "case.ply", (0.5, 0.16, height_m))))
    body = standing_m(look)
    here = corners(load, look, 0.0, 0.0)
    hand = body["right_forearm"][body["right_forearm"][:, 2].argmin()]
    assert here[:, 2].min() > 0.05
    assert here[:, 2].min() < hand[2] < here[:, 2].max() + 0.06 * look.stature_m
    assert np.abs(here[:, :2].mean(axis=0) - hand[:2]).max() < 0.15
    beside = np.concatenate([body[name] for name in ("pelvis", "right_thigh", "right_shin")])
    beside = beside[(beside[:, 2] > here[:, 2].min()) & (beside[:, 2] < here[:, 2].max())]
    assert here[:, 1].max() < beside[:, 1].min()
    # Upright on every step, and off the ground; it goes with the hand.
    ahead = []
    for phase_rad in np.linspace(0.0, 2 * np.pi, 8, endpoint=False):
        there = corners(load, look, phase_rad, 1.4)
        np.testing.assert_allclose(np.ptp(there, axis=0), np.ptp(here, axis=0), atol=1e-6)
        assert there[:, 2].min() > 0.02
        ahead.append(there[:, 0].mean())
    assert np.ptp(ahead) > 0.1 * look.stature_m


@pytest.mark.parametrize("look", LOOKS, ids=range(len(LOOKS)))
def test_a_thing_on_the_back_leans_on_it(tmp_path: Path, look):
    carried = Carried(back=box(tmp_path / "pack.ply", (0.2, 0.3, 0.4)))
    look = without_backpack(replace(look, backpack_rgb=(1, 2, 3)), carried)
    assert look.backpack_rgb is None
    (load,) = loads_of(look, carried)
    here, torso = corners(load, look, 0.0, 0.0), standing_m(look)["torso"]
    assert abs(here[:, 2].mean() - torso[:, 2].mean()) < 0.1 * look.stature_m
    behind = torso[(torso[:, 2] > here[:, 2].min()) & (torso[:, 2] < here[:, 2].max())][:, 0].min()
    assert -0.15 < here[:, 0].max() - behind < 0.03
    assert laden_size_m(look, [load])[0] > person_size_m(look)[0] + 0.05


def test_who_carries_is_said(tmp_path: Path):
    case = box(tmp_path / "case.ply", (0.4, 0.15, 0.3))
    preset = replace(QUICK, hand_models=(case, NOTHING, NOTHING))
    drawn = {
        who: draw_carried(replace(preset, carriers=who), 3000, generator(1, "x")) for who in ("all", "target", "others")
    }
    assert 900 < sum(each.hand == case for each in drawn["all"]) < 1100
    assert all(each.back == NOTHING for each in drawn["all"])
    assert drawn["others"] == [Carried(), *drawn["all"][1:]]
    assert drawn["target"] == [drawn["all"][0], *[Carried()] * 2999]
    assert set(draw_carried(QUICK, 9, generator(1, "x"))) == {Carried()}


def test_bounds_and_ids_of_people_include_what_they_carry(tmp_path: Path):
    case, pack = box(tmp_path / "case.ply", (0.5, 0.16, 0.3)), box(tmp_path / "pack.ply", (0.3, 0.3, 0.4))
    preset = replace(QUICK, hand_models=(case,), back_models=(pack,), frame_count=20)
    plan, usual = (make_plan(each, 3, closed_loop=False) for each in (preset, replace(preset, carriers="others")))
    laden, free = People(World(), plan), People(World(), usual)
    assert len(laden.parts[TARGET]) == len(PART_NAMES) + 2
    assert len(free.parts[TARGET]) == len(PART_NAMES)
    for people in (laden, free):
        people.move_to(7)
    np.testing.assert_array_equal(laden.part_poses[TARGET][:-2], free.part_poses[TARGET])
    np.testing.assert_array_equal(laden.chests_m(), free.chests_m())
    bounds = laden.bounds_m()[TARGET]
    for body, T in zip(laden.parts[TARGET], laden.part_poses[TARGET], strict=True):
        T = np.linalg.inv(laden.T_world_object[TARGET]) @ T
        points = body.mesh.vertices_m @ T[:3, :3].T + T[:3, 3]
        assert (points > bounds[0] - 1e-6).all()
        assert (points < bounds[1] + 1e-6).all()
    assert bounds[0, 1] < free.bounds_m()[TARGET, 0, 1] - 0.02
    ids = np.array([[body.index for body in laden.parts[TARGET]]], np.int32)
    laden.merge(ids)
    assert (ids == laden.instance_id[TARGET]).all()


def test_what_is_no_thing_to_carry_is_refused_and_a_missing_file_is_read_as_a_name(tmp_path: Path):
    house = box(tmp_path / "house.ply", (8.0, 5.0, 3.0))
    with pytest.raises(ValueError, match=r"longest side of 0.05 to 1.2 m, got 8 x 5 x 3 m"):
        replace(QUICK, hand_models=(house,))
    with pytest.raises(ValueError, match="back_models: expected one of nothing; got 'case'"):
        replace(QUICK, back_models=("case",))
    gone = replace(QUICK, hand_models=(NOTHING, str(tmp_path / "gone.glb")))
    with pytest.raises(ValueError, match="a file that exists"):
        draw_carried(gone, 1, generator(1, "x"))
    name = f"quick[hand_models=[{box(tmp_path / 'case.ply', (0.4, 0.1, 0.3))}]]"
    before = preset_edition("stereo-follow-v2", name)
    assert before.startswith(preset_edition("stereo-follow-v2", "quick"))
    box(tmp_path / "case.ply", (0.4, 0.1, 0.2))
    assert preset_edition("stereo-follow-v2", name) != before


@pytest.mark.heavy
def test_pictures_show_the_thing_as_its_carrier(tmp_path: Path):
    """Where the picture shows the thing alone, the target's id is, and the box is around it."""
    case = box(tmp_path / "case.ply", (0.5, 0.16, 0.4))
    frames = {}
    for who in ("target", "others"):
        name = f"quick[hand_models=[{case}],carriers={who},crossers=0,walkers=0,standers=0,oncomers=0,followers=0]"
        episode = STEREO_FOLLOW.episode(name, 4)
        frames[who] = [episode.step() for _ in range(4)]
        episode.close()
    for laden, free in zip(frames["target"], frames["others"], strict=True):
        own, usual = (frame.truth.instance_map == frame.truth.instance_id[0] for frame in (laden, free))
        added = own & ~usual
        assert (own | ~usual).all()
        rgb = laden.observation.image_rgb[added].astype(float)
        assert added.sum() > 30
        assert (rgb[:, 0] > 1.3 * rgb[:, 2]).mean() > 0.7
        rows, columns = np.nonzero(own)
        left, top, right, bottom = laden.truth.box_xyxy[0]
        assert left <= columns.min() + 1
        assert right >= columns.max()
        assert top <= rows.min() + 1
        assert bottom >= rows.max()
        assert laden.truth.visible_fraction[0] > 0.95
