"""Pictures on disk: those that are cut off."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.contract.judging import UnreadableSequence
from benchmarks.data.pictures import read_picture
from tests.benchmarks.data.written_sequences import true_boxes, write_pictures


@pytest.mark.parametrize("ending", ["jpg", "png", "webp", "bmp", "tif"])
def test_a_picture_that_is_cut_off_is_named(tmp_path: Path, ending: str) -> None:
    write_pictures(tmp_path / "Car1" / "img", list(true_boxes(2)), f"{{:04d}}.{ending}")
    path = tmp_path / "Car1" / "img" / f"0002.{ending}"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(UnreadableSequence, match=rf"^Car1/img/0002.{ending}: expected a whole picture, got \d+ bytes"):
        read_picture(path)
