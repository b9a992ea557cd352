"""Pictures without targets are stored once a day, read back with each of its episodes, and left out if not wanted."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.data.sets.benchmark import benchmark_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, forecast
from benchmarks.data.sets.request import Request
from benchmarks.data.sets.verifying import discard, problems
from tests.benchmarks.data.same import assert_same
from tests.benchmarks.data.sets.small import made
from tests.benchmarks.data.sets.test_generating import digests

pytestmark = pytest.mark.heavy
ASKED = Request(
    "harbour-v1",
    "quick[background=3,episodes_a_day=2,frame_count=2,width_px=96,height_px=72]",
    (3, 6),
    ("image_rgb", "counts", "instance_map", "depth_m"),
)
HERE = Workers(0)


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> DataSet:
    return made(ASKED, tmp_path_factory.mktemp("days") / "set", HERE)


def test_a_day_has_its_pictures_once_and_each_episode_its_own_start(data):
    folders = sorted(each.rsplit("/", 1)[1] for each in data.files.ls(f"{data.root}/backgrounds", detail=False))
    assert folders == ["000002", "000004"]
    for seed in range(*ASKED.seeds):
        live = ASKED.episode(seed)
        assert_same(data.episode(seed).start, live.start, f"start of {seed}")
        assert len(live.start.background) == 3
    assert not list(data.files.glob(f"{data.root}/episodes/*/background*"))


def test_episodes_of_a_day_differ_in_who_comes_and_in_noise(data):
    first, second = (data.episode(seed) for seed in (4, 5))
    assert_same(first.start.background, second.start.background, "background")
    one, other = first.frame(1), second.frame(1)
    assert not np.array_equal(one.observation.counts, other.observation.counts)
    assert one.truth.names != other.truth.names or not np.array_equal(one.truth.size_m, other.truth.size_m)
    assert (one.truth.tide_m, one.truth.wave_height_m) == (other.truth.tide_m, other.truth.wave_height_m)
    assert data.episode(3).frame(1).truth.tide_m != one.truth.tide_m


def test_left_out_pictures_change_no_frame_and_no_bench_takes_them_for_the_whole(data, tmp_path):
    without = made(replace(ASKED, background=False), tmp_path / "set", HERE)
    assert not (tmp_path / "set/backgrounds").exists()
    assert without.episode(4).start.background == ()
    for k in range(2):
        assert_same(without.episode(4).frame(k), data.episode(4).frame(k), f"frame {k}")
    with pytest.raises(ValueError, match=r"data: expected a set with background pictures, got one .* --no-background"):
        benchmark_of(str(tmp_path / "set"))


def test_damaged_pictures_are_found_once_and_made_again(data, tmp_path):
    copy = tmp_path / "set"
    shutil.copytree(data.root, copy)
    shard = copy / "backgrounds/000004/background-00000.tar"
    shard.write_bytes(shard.read_bytes()[:-512])
    found = list(problems(DataSet(str(copy)), lambda done, of: None))
    assert [problem.seed for problem in found] == [4, 5]
    assert found[0].what.startswith("its background 000004: background-00000.tar: expected ")
    discard(DataSet(str(copy)), [problem.seed for problem in found])
    made(ASKED, copy, HERE)
    assert digests(copy) == digests(data.root)


def test_a_forecast_counts_days(data):
    one_a_day = replace(ASKED, preset="quick[background=3,frame_count=2,width_px=96,height_px=72]")
    assert 0.55 < forecast(ASKED, frames=1).bytes / forecast(one_a_day, frames=1).bytes < 0.95
    alone = forecast(replace(ASKED, background=False), frames=1).bytes
    both = forecast(ASKED, frames=1).bytes
    stored = sum(data.files.du(f"{data.root}/backgrounds/{day}") for day in ("000002", "000004"))
    assert both - alone == pytest.approx(stored, rel=0.1)


def test_episodes_of_a_day_with_other_drawn_values_have_their_own_pictures():
    drawn = replace(ASKED, preset="quick[background=3,buoys=0:2,episodes_a_day=2]", seeds=(0, 40))
    days = [drawn.day_of(seed) for seed in range(40)]
    presets = [drawn.configuration(seed) for seed in range(40)]
    for seed, day in enumerate(days):
        assert day in (seed, seed - seed % 2)
        assert presets[day] == presets[seed]
    assert len({*days}) > 20
