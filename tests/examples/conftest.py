"""What tests of the examples that train share: one thread, and a small set."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, generate
from benchmarks.data.sets.request import Request


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Let PyTorch take one: small pictures gain nothing by more, and tests run side by side."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="session")
def town(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """Return a set of one short episode of small pictures."""
    preset = "quick[frame_count=128,height_px=120,rate_hz=3,width_px=160]"
    request = Request("road-town-v2", preset, (3, 4), ("image_rgb", "instance_map", "semantic_map"))
    return generate(request, str(tmp_path_factory.mktemp("town")), Workers(0), lambda done, of: None)
