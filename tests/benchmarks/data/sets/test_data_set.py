"""Reading in any order, in other processes, and as tables."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.data_set import DataSet, stored_episode
from benchmarks.data.sets.verifying import problems
from scenarios.truth import check_truth
from tests.benchmarks.data.exports.painted_scene import PARKED_XYXY, painted_data_set
from tests.benchmarks.data.sets.hand_made import FRAMES, write_set
from tests.benchmarks.data.sets.small import made, tiny


def middle(frame):
    return frame.observation.image_rgb.sum(), frame.truth.box_xyxy[0]


def test_frames_of_the_set_are_those_of_its_episodes_in_order(data):
    assert len(data) == 24
    times = [frame.truth.time_s for frame in data]
    assert times == [frame.truth.time_s for seed in (3, 4) for frame in data.episode(seed)]
    np.testing.assert_array_equal(data[13].truth.T_world_object, data.episode(4).frame(1).truth.T_world_object)
    with pytest.raises(IndexError, match="frame: expected 0 to 23, got 24"):
        data[24]


def test_samples_travel_to_other_processes_and_read_what_is_asked_for(data):
    samples = data.samples(middle, channels=("image_rgb",))
    samples[5]
    copied = pickle.loads(pickle.dumps(samples))
    assert len(copied) == 24
    for k in (20, 5):
        assert copied[k][0] == samples[k][0]
        np.testing.assert_array_equal(copied[k][1], data[k].truth.box_xyxy[0])
    assert data.episode(3).frame(0, channels=()).truth.instance_map.size == 0


def test_tables_have_a_row_a_frame_and_a_row_an_object_with_units(data):
    frames, objects = data.table("frames"), data.table("objects")
    assert (frames.num_rows, objects.num_rows) == (24, 72)
    assert objects.schema.field("size_m").metadata[b"unit"] == b"m"
    table = objects.to_pandas()
    assert set(table["state"]) <= {"in", "partial", "out", "occluded"}
    first = table[(table["seed"] == 4) & (table["frame"] == 2) & (table["names"] == "target")]
    np.testing.assert_array_equal(first["box_xyxy"].iloc[0], data[14].truth.box_xyxy[0])


def test_what_is_no_data_set_is_named(tmp_path, data):
    with pytest.raises(ValueError, match=r"directory: expected a data set with a file dataset\.json, got none"):
        DataSet(str(tmp_path))
    (tmp_path / "dataset.json").write_text('{"format": 99}')
    with pytest.raises(ValueError, match="expected a data set of format 4, got format 99"):
        DataSet(str(tmp_path))
    with pytest.raises(ValueError, match="seed: expected one of the 2 that exist"):
        data.episode(7)
    with pytest.raises(ValueError, match="place: expected a folder or a URL"):
        DataSet("ftpx://nowhere/set")


def test_a_set_of_the_format_before_is_read_without_what_stands_about():
    """The episodes that canaries watch are of format 2."""
    old = DataSet(str(Path(__file__).parents[3] / "canaries/episodes/road-town"))
    assert old.tables == ("frames", "objects")
    truth = old.episode(0).frame(3).truth
    check_truth(truth)
    assert truth.standing_names == ()
    assert old.episode(0).visible_boxes_of(3, "standing").shape == (0, 4)
    np.testing.assert_allclose(truth.bounds_m[:, 1] - truth.bounds_m[:, 0], truth.size_m)
    with pytest.raises(ValueError, match="name: expected one of frames, objects, got 'standing'"):
        old.table("standing")


def test_what_stands_about_has_a_table_of_its_own(tmp_path):
    data = painted_data_set(tmp_path / "set", "parked")
    rows = data.table("standing").to_pandas()
    assert len(rows) == len(data)
    assert set(rows["standing_names"]) == {"parked-0"}
    assert all(list(box) == PARKED_XYXY.tolist() for box in rows["visible_box_xyxy"])
    assert data.table("objects").num_rows == 3 * len(data)
    assert not list(problems(data, lambda done, of: None))


def test_bytes_of_channels_are_those_of_their_values(hand_made: DataSet) -> None:
    stored = hand_made.stored_bytes()
    for channel in hand_made.request.channels:
        values = [hand_made.episode(seed).coded(k, channel) for seed in hand_made.seeds for k in range(FRAMES)]
        assert stored[channel] == sum(len(coded) for _, coded in filter(None, values)), channel
    paths = Path(hand_made.root).glob("episodes/*/*.parquet")
    assert stored["tables"] == sum(path.stat().st_size for path in paths)


def test_a_set_without_channels_has_tables_alone(tmp_path: Path) -> None:
    stored = write_set(tmp_path, (), frames=2).stored_bytes()
    assert list(stored) == ["tables"]
    assert stored["tables"] > 0


def test_many_episodes_are_read_and_few_kept(tmp_path: Path) -> None:
    many = made(tiny(seeds=(0, 8), frame_count=2), tmp_path / "set")
    held = many.episode(0)
    first = held.frame(0).truth.T_world_object
    for seed in many.seeds:
        many.episode(seed).frame(1)
    assert len(many._episodes) == 4
    np.testing.assert_array_equal(held.frame(0).truth.T_world_object, first)
    assert [frame.truth.frame for frame in many] == [0, 1] * 8


@pytest.mark.heavy
def test_threads_read_many_episodes_at_once(tmp_path: Path) -> None:
    many = made(tiny(seeds=(0, 8), frame_count=2), tmp_path / "set")
    order = np.random.default_rng(0).integers(0, len(many), 200).tolist()
    with ThreadPoolExecutor(8) as threads:
        frames = list(threads.map(many.__getitem__, order))
    assert [frame.truth.frame for frame in frames] == [index % 2 for index in order]


def test_channels_that_are_not_stored_are_named(data: DataSet) -> None:
    for wrong in ("depth", "seed"):
        with pytest.raises(ValueError, match=f"channels: expected some of image_rgb, .*, got {wrong}"):
            data.samples(lambda frame: frame, channels=(wrong,))[0]


def test_one_episode_is_read_without_the_others(data: DataSet, tmp_path: Path) -> None:
    frame = stored_episode(data.url, 4).frame(2)
    np.testing.assert_array_equal(frame.truth.T_world_object, data[14].truth.T_world_object)
    with pytest.raises(ValueError, match=r"seed: expected a whole episode in .*, got 9"):
        stored_episode(data.url, 9)
