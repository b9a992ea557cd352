"""Shards as any program reads them, and by the places that were told."""

from __future__ import annotations

import hashlib
import tarfile

from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.sets.episode_writer import ShardWriter

VALUES = {f"{k:06d}.depth_m.b2nd": bytes([k]) * (400 * k) for k in range(9)}


def written(folder, shard_bytes=2**20):
    writer = ShardWriter(LocalFileSystem(), str(folder), "pixels", shard_bytes)
    places = {name: writer.add(name, value) for name, value in VALUES.items()}
    writer.finish()
    return {shard: file.mark for shard, file in writer.written.items()}, places


def test_values_lie_at_their_places_and_under_their_names(tmp_path):
    marks, places = written(tmp_path, shard_bytes=4000)
    assert len(marks) > 2
    for name, value in VALUES.items():
        place = places[name]
        path = tmp_path / f"pixels-{place.shard:05d}.tar"
        assert path.read_bytes()[place.offset : place.offset + place.bytes] == value
        with tarfile.open(path) as tar:
            assert tar.extractfile(name).read() == value
            assert tar.getmember(name).mtime == 0


def test_marks_are_those_of_the_files(tmp_path):
    marks, _ = written(tmp_path)
    assert list(marks) == ["pixels-00000.tar"]
    content = (tmp_path / "pixels-00000.tar").read_bytes()
    assert marks["pixels-00000.tar"] == {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
