"""Data sets in PyTorch's ``DataLoader``: workers of either kind, and which tensors share memory with what was read."""

from __future__ import annotations

import pytest

from benchmarks.data.sets.data_set import DataSet
from scenarios.scenario import Frame

pytest.importorskip("torch", reason="torch is not installed")
import torch
from torch.utils.data import DataLoader


def labelled(frame: Frame):
    """Return the picture, its labels, boxes and time."""
    picture, boxes = torch.tensor(frame.observation.image_rgb), torch.tensor(frame.truth.box_xyxy)
    return picture, torch.from_numpy(frame.truth.instance_map), boxes, frame.truth.time_s


def itself(frame: Frame) -> Frame:
    return frame


@pytest.mark.heavy
@pytest.mark.parametrize("context", ["spawn", "fork"])
def test_two_workers_load_what_this_process_loads(data: DataSet, context: str) -> None:
    samples = data.samples(labelled, ("image_rgb", "instance_map"))
    here = list(DataLoader(samples, batch_size=5))
    there = list(DataLoader(samples, batch_size=5, num_workers=2, multiprocessing_context=context, timeout=120))
    assert here[0][0].shape == (5, 120, 160, 3)
    assert [len(batch[0]) for batch in there] == [5, 5, 5, 5, 4]
    for ours, theirs in zip(here, there, strict=True):
        for expected, found in zip(ours, theirs, strict=True):
            assert torch.equal(expected, found)
            # Batches come from workers through shared memory.
            assert found.is_shared()


@pytest.mark.parametrize("channel", ["instance_map", "depth_m"])
def test_a_tensor_of_a_map_is_the_memory_that_was_read(data: DataSet, channel: str) -> None:
    read = getattr(data.samples(itself, (channel,))[7].truth, channel)
    tensor = torch.from_numpy(read)
    assert tensor.data_ptr() == read.ctypes.data
    tensor[0, 0] = 5
    assert read[0, 0] == 5


@pytest.mark.parametrize("of", ["picture", "boxes"])
def test_pictures_and_truth_of_objects_cannot_be_written_to(data: DataSet, of: str) -> None:
    frame = data.samples(itself, ("image_rgb",))[7]
    read = frame.observation.image_rgb if of == "picture" else frame.truth.box_xyxy
    assert not read.flags.writeable
    assert torch.tensor(read).data_ptr() != read.ctypes.data
