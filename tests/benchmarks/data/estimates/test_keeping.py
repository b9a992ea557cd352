"""What a run keeps, when it makes an episode again for it, and what it does without."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from benchmarks.contract.rows import read_blocks
from benchmarks.judges.tracker_speed import TIMES
from tests.benchmarks.data.estimates.runs import TOWN, rows_in
from tests.benchmarks.named import run_named as run

STILL = replace(TOWN, trackers=("fake_still",))


@pytest.mark.heavy
def test_rows_do_not_depend_on_whether_estimates_are_kept(kept: Path, tmp_path: Path) -> None:
    run(replace(TOWN, keeper=None), tmp_path)
    assert not (tmp_path / "estimates").exists()
    one, other = ([row for row in rows_in(path) if row["metric"] not in TIMES] for path in (kept, tmp_path))
    assert one == other


def test_blocks_without_estimates_are_made_again(tmp_path: Path) -> None:
    run(replace(STILL, keeper=None), tmp_path)
    outcome = run(STILL, tmp_path)
    assert (outcome.resumed, outcome.episodes) == (0, 2)
    files = sorted((tmp_path / "estimates").iterdir())
    whole = [path.read_bytes() for path in files]
    files[0].unlink()
    files[1].write_bytes(whole[1][:-100])
    outcome = run(replace(STILL, seeds=range(3, 5)), tmp_path)
    assert (outcome.resumed, outcome.episodes) == (0, 2)
    assert run(STILL, tmp_path).resumed == 2
    assert len(read_blocks(tmp_path)) == 2
    assert [pq.read_table(path).num_rows for path in files] == [60, 60]


def test_nothing_is_left_of_a_file_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("benchmarks.data.estimates.block_file.pq.write_table", full)
    with pytest.raises(OSError, match="No space left on device"):
        run(STILL, tmp_path)
    assert list((tmp_path / "estimates").iterdir()) == []
    assert not (tmp_path / "records.jsonl").exists()
