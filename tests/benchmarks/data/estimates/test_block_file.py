"""Files of estimates: the same bytes, whole or not at all, and said in one line if they are not."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from benchmarks.data.estimates import block_file
from benchmarks.data.estimates.block_file import TIMES, facts_in, facts_of, is_kept, path_of, read_block
from tests.benchmarks.data.estimates.runs import TOWN, rows_in
from tests.benchmarks.named import run_named as run


@pytest.fixture
def path(kept: Path, tmp_path: Path) -> Path:
    """A file of the tracker that fails, to be damaged."""
    return Path(shutil.copy(next((kept / "estimates").glob("000003-fake_raises-*")), tmp_path))


@pytest.mark.heavy
def test_a_file_says_how_the_run_went(path: Path) -> None:
    facts = facts_of(path)
    (run_,) = facts.runs
    assert (facts.heading["tracker"], facts.heading["role"], facts.key.seed) == ("fake_raises", "baseline", 3)
    assert (run_.failed_at_frame, run_.failed_in_the_end, run_.reason) == (20, 20, "RuntimeError: a bug")
    assert (facts.many, facts.frame_count, run_.revises, run_.bridges) == (False, 60, False, False)
    assert path.name == path_of(path.parent, facts.key).name
    assert not is_kept(path.parent, facts.key, facts.editions | {"tracker": "another"})
    assert not is_kept(path.parent, replace(facts.key, seed=9), facts.editions)


@pytest.mark.heavy
def test_two_runs_leave_the_same_but_for_times(kept: Path, tmp_path: Path) -> None:
    run(replace(TOWN, trackers=("fake_knowing",), seeds=range(3, 4)), tmp_path)
    (mine,) = (tmp_path / "estimates").iterdir()
    one, other = (pq.read_table(file) for file in (mine, kept / "estimates" / mine.name))
    assert one["cpu_s"].null_count == one["wall_s"].null_count == 1
    assert one.drop([*TIMES]).equals(other.drop([*TIMES]), check_metadata=True)


def test_a_file_that_was_cut_off_is_named_and_made_again(path: Path) -> None:
    facts = facts_of(path)
    path = path.rename(path_of(path.parent, facts.key))
    assert is_kept(path.parent, facts.key, facts.editions)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(ValueError, match=rf"{path.name}: expected a whole file of estimates, got ArrowInvalid"):
        facts_of(path)
    assert not is_kept(path.parent, facts.key, facts.editions)


def test_a_file_of_something_else_is_named(path: Path) -> None:
    pq.write_table(pa.table({"a": [1]}), path)
    with pytest.raises(ValueError, match="expected a whole file of estimates, got KeyError"):
        facts_of(path)


def other_format(table: pa.Table) -> pa.Table:
    told = table.schema.metadata.items()
    return table.replace_schema_metadata({key: value.replace(b'"format": 2', b'"format": 9') for key, value in told})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda table: table.drop(["frame"]), "expected the columns of estimates, got suite"),
        (other_format, "expected estimates of format 2, got format 9"),
    ],
)
def test_damaged_contents_are_named(path: Path, change: Callable[[pa.Table], pa.Table], said: str) -> None:
    pq.write_table(change(pq.read_table(path)), path)
    with pytest.raises(ValueError, match=said):
        read_block(path)


@pytest.mark.heavy
def test_the_documented_way_gives_the_error_of_each_tracker(
    kept: Path, town: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code = str(block_file.__doc__).split("::\n")[1].replace("\n    ", "\n")
    code = code.replace("results/mine", str(kept)).replace("sets/town", town)
    told: dict[str, object] = {"np": np}
    exec(code, told)
    printed = {line.split()[0]: float(line.split()[1]) for line in capsys.readouterr().out.splitlines()[1:6]}
    assert printed["fake_knowing"] < 5.0 < printed["fake_still"]
    both = told["both"]
    assert len(both) == len(TOWN.trackers) * 2 * 60  # type: ignore[arg-type]
    # The suite's own metric, of frames on which the whole car is in the picture, is the same.
    mine = both[(both["tracker"] == "fake_still") & (both["seed"] == 3)]  # type: ignore[index]
    error_px = mine.loc[mine["state"] == "in", "error_px"].mean()
    names = ("tracker", "seed", "metric")
    rows = [row for row in rows_in(kept) if [row[name] for name in names] == ["fake_still", 3, "centre_error_px"]]
    assert [row["value"] for row in rows] == [pytest.approx(error_px, rel=1e-5)]


def test_a_folder_without_estimates_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="estimates: expected files of `frameout bench --keep-estimates`, got none in"):
        facts_in(tmp_path)
