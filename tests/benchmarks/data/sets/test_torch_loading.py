"""Data sets in PyTorch's ``DataLoader``: workers of either kind, and which tensors share memory with what was read."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import write_episode
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request
from scenarios.scenario import Frame
from tests.benchmarks.data.sets.hand_made import HandMadeEpisode
from trackers.types import CameraCommand

pytest.importorskip("torch", reason="torch is not installed")
import torch
from torch.utils.data import DataLoader


class NoisyEpisode(HandMadeEpisode):
    """Pictures that do not compress, so that what is read of a file by mistake is another picture."""

    def step(self, command: CameraCommand | None = None) -> Frame:
        frame = super().step(command)
        picture = frame.observation.image_rgb
        noise = np.random.default_rng(self._frame).integers(0, 256, picture.shape, np.uint8)
        return Frame(replace(frame.observation, image_rgb=noise), frame.truth)


@pytest.fixture
def noisy(tmp_path: Path) -> DataSet:
    """Return a set of one episode of 30 frames."""
    request = Request("road-town-v2", "quick", (0, 1), ("image_rgb",))
    files, root = place_of(str(tmp_path))
    (tmp_path / REQUEST).write_text(request.as_json())
    write_episode(files, root, request, 0, NoisyEpisode())
    return DataSet(str(tmp_path))


def labelled(frame: Frame):
    """Return the picture, its labels, boxes and time."""
    picture, boxes = torch.tensor(frame.observation.image_rgb), torch.tensor(frame.truth.box_xyxy)
    return picture, torch.from_numpy(frame.truth.instance_map), boxes, frame.truth.time_s


def checksum(frame: Frame) -> int:
    return zlib.crc32(frame.observation.image_rgb)


def itself(frame: Frame) -> Frame:
    return frame


@pytest.mark.heavy
def test_two_spawned_workers_load_what_this_process_loads(data: DataSet) -> None:
    samples = data.samples(labelled, ("image_rgb", "instance_map"))
    here = list(DataLoader(samples, batch_size=5))
    there = list(DataLoader(samples, batch_size=5, num_workers=2, multiprocessing_context="spawn", timeout=120))
    assert here[0][0].shape == (5, 120, 160, 3)
    assert [len(batch[0]) for batch in there] == [5, 5, 5, 5, 4]
    for ours, theirs in zip(here, there, strict=True):
        for expected, found in zip(ours, theirs, strict=True):
            assert torch.equal(expected, found)
            # Batches come from workers through shared memory.
            assert found.is_shared()


def test_forked_workers_open_files_of_their_own_also_where_this_process_has_read(noisy: DataSet) -> None:
    samples = noisy.samples(checksum, ("image_rgb",))
    expected = [samples[k] for k in range(len(samples))]
    loader = DataLoader(
        samples, batch_size=1, collate_fn=list, num_workers=2, multiprocessing_context="fork", timeout=60
    )
    for _ in range(3):
        assert [found for batch in loader for found in batch] == expected


@pytest.mark.parametrize("channel", ["instance_map", "depth_m"])
def test_a_tensor_of_a_map_is_the_memory_that_was_read(data: DataSet, channel: str) -> None:
    read = getattr(data.samples(itself, (channel,))[7].truth, channel)
    tensor = torch.from_numpy(read)
    assert tensor.data_ptr() == read.ctypes.data
    tensor[0, 0] = 5
    assert read[0, 0] == 5


@pytest.fixture
def _each_warning() -> Iterator[None]:
    """Torch gives most warnings once a process."""
    torch.set_warn_always(True)
    yield
    torch.set_warn_always(False)


@pytest.mark.usefixtures("_each_warning")
@pytest.mark.parametrize("of", ["picture", "boxes"])
def test_pictures_and_truth_of_objects_cannot_be_written_to_and_torch_says_so(data: DataSet, of: str) -> None:
    frame = data.samples(itself, ("image_rgb",))[7]
    read = frame.observation.image_rgb if of == "picture" else frame.truth.box_xyxy
    assert not read.flags.writeable
    assert torch.tensor(read).data_ptr() != read.ctypes.data
    with pytest.warns(UserWarning, match="not writable"):
        assert torch.from_numpy(read).data_ptr() == read.ctypes.data
