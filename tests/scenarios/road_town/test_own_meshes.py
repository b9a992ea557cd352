"""A town with vehicles and buildings from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh

from benchmarks.cli.main import main
from benchmarks.run.editions import preset_edition
from scenarios.road_town.canvas import rectangle
from scenarios.road_town.plan import TARGET, draw_layout, make_plan
from scenarios.road_town.road_map import road_area
from scenarios.road_town.scenario import ROAD_TOWN, kind_of_town
from sim.meshes.file import mesh_of_file
from tests.sim.meshes.test_file import ANY, lorry


def test_files_drive_and_stand_where_a_preset_names_them(tmp_path: Path):
    cart, church = lorry(tmp_path / "cart.glb"), tmp_path / "church.stl"
    trimesh.creation.box((26.0, 11.0, 18.0)).export(church)
    values = f"vehicles=[sedan,{cart}],target_vehicle={cart}@kind=lorry,building_models=[house,house,{church}]"
    name = f"quick[{values},frame_count=100]"
    preset = ROAD_TOWN.configuration(name, 0)
    plan = make_plan(preset, 3, closed_loop=False)
    np.testing.assert_allclose(plan.sizes_m[TARGET], (8.0, 2.5, 3.0), atol=1e-5)
    assert {look.model for look in plan.looks[1:]} == {"sedan", cart}
    own = [each for each in plan.layout.buildings if each.model != "house"]
    assert 5 <= len(own) <= 38
    assert len(plan.layout.buildings) > len(own)
    roads = road_area(draw_layout(preset, 3).graph)
    for each in own:
        outline = shapely.Polygon(rectangle(np.array(each.centre_m), each.size_m[:2], each.yaw_rad))
        assert outline.distance(roads) > 1.0
    episode = ROAD_TOWN.episode(name, 0)
    truth = episode.step().truth
    assert truth.kinds[truth.index_of("target")] == "lorry"
    assert {ROAD_TOWN.classes[kind] for kind in truth.kinds} == {"car", "lorry"}
    assert any(body.mesh is mesh_of_file(str(church), ANY) for body in episode.world.bodies)
    episode.close()
    assert kind_of_town(preset) != kind_of_town(ROAD_TOWN.configuration("quick", 0))


def test_a_stored_set_is_read_where_its_meshes_are_not_but_none_is_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    gone = tmp_path / "gone.glb"
    for values in (f"vehicles=[sedan,{gone}]", f"target_vehicle={gone}", f"building_models=[house,{gone}]"):
        name = f"quick[{values},frame_count=100]"
        ROAD_TOWN.configuration(name, 0)
        said = f"mesh: expected a file that exists, got {gone}"
        with pytest.raises(ValueError, match=said):
            ROAD_TOWN.episode(name, 0)
        for command in ("bench frame-out --trackers hold --seeds 0:1", "generate road-town --seeds 0"):
            assert main([*command.split(), "--preset", name, "--out", str(tmp_path / "out")]) == 2
            assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_rows_know_a_file_by_its_content(tmp_path: Path):
    file = lorry(tmp_path / "cart.glb")
    name = f"quick[vehicles=choice([sedan],[sedan,{file}@yaw=180])]"
    usual, first = preset_edition("road-town-v2", "quick"), preset_edition("road-town-v2", name)
    assert first.startswith(f"{usual} ")
    assert preset_edition("road-town-v2", "quick[traffic_cars=3]") == usual
    trimesh.creation.box((2.0, 2.0, 6.0)).export(file)
    assert preset_edition("road-town-v2", name) != first
