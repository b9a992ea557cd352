"""Every kind of damage is found, named by its episode, and made again."""

from __future__ import annotations

import shutil

import pytest

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.verifying import discard, problems
from tests.benchmarks.data.sets.small import made, tiny
from tests.benchmarks.data.sets.test_generating import digests


@pytest.fixture
def copy(data, tmp_path):
    shutil.copytree(data.root, tmp_path / "set")
    return tmp_path / "set"


def found(folder) -> list[str]:
    return [str(each) for each in problems(DataSet(str(folder)), lambda done, of: None)]


def test_a_whole_set_has_no_problem(data):
    assert found(data.root) == []


def test_a_changed_byte_is_found_and_made_again(copy, data):
    shard = copy / "episodes/000004/pixels-00000.tar"
    content = bytearray(shard.read_bytes())
    content[5000] ^= 1
    shard.write_bytes(content)
    assert found(copy) == ["episode 4: pixels-00000.tar: its contents are not those that were written"]
    discard(DataSet(str(copy)), [4])
    made(tiny(), copy)
    assert digests(copy) == digests(data.root)


def test_what_is_cut_off_or_missing_is_found(copy):
    table = copy / "episodes/000003/objects.parquet"
    table.write_bytes(table.read_bytes()[:-10])
    (copy / "episodes/000004/episode.json").unlink()
    first, second = found(copy)
    assert first.startswith("episode 3: objects.parquet: expected ")
    assert second == "episode 4: is missing, or was not written to its end"


def test_an_episode_in_place_of_another_and_a_changed_mark_are_found(copy):
    shutil.rmtree(copy / "episodes/000003")
    shutil.copytree(copy / "episodes/000004", copy / "episodes/000003")
    mark = copy / "episodes/000004/episode.json"
    mark.write_text(mark.read_text().replace('"rate_hz": 15.0', '"rate_hz": 30.0'))
    assert found(copy) == [
        "episode 3: its mark is that of episode 4",
        "episode 4: it is not the one that manifest.parquet lists",
    ]


def test_what_was_made_since_the_set_began_to_grow_is_whole(tmp_path):
    """The run that made it grow was killed: the manifest is that of before."""
    made(tiny(seeds=(3, 4)), tmp_path / "set")
    before = (tmp_path / "set/manifest.parquet").read_bytes()
    made(tiny(), tmp_path / "set")
    (tmp_path / "set/manifest.parquet").write_bytes(before)
    assert found(tmp_path / "set") == []
