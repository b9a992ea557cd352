"""Rows made from estimates are those of the run, without a tracker."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from benchmarks.contract.rows import FILE_NAME
from benchmarks.data.estimates.keeping import Estimates
from benchmarks.data.estimates.rejudging import Rejudged
from tests.benchmarks.data.estimates import masked, odd_fish
from tests.benchmarks.data.estimates.runs import TOWN, judged_again, rows_in
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run
from tests.fakes_scenario import FakeEpisode

FISH = Experiment(
    suite="fish",
    scenario="fish-tank-v1",
    presets=("glimpse",),
    trackers=("fake_wanders", "fake_gives_up", "fake_regrets"),
    seeds=range(3, 4),
    workers=0,
    modules=(odd_fish.__name__,),
    keeper=Estimates(),
)


@pytest.fixture
def copied(kept: Path, tmp_path: Path) -> Path:
    """A copy of the run, to be changed."""
    return Path(shutil.copytree(kept, tmp_path / "copied"))


def forbidden(*_: object, **__: object) -> Any:
    raise AssertionError("a tracker was made")


@pytest.fixture
def no_tracker(monkeypatch: pytest.MonkeyPatch) -> None:
    """No tracker runs."""
    monkeypatch.setattr("benchmarks.run.selection.Registered.create", forbidden)


@pytest.mark.usefixtures("no_tracker")
def test_rows_of_one_target_are_those_of_the_run(kept: Path, copied: Path) -> None:
    (copied / FILE_NAME).unlink()
    assert judged_again(copied) == Rejudged(same=0, new=10, moved=None)
    assert rows_in(copied) == rows_in(kept)
    failed = {row["tracker"]: row["value"] for row in rows_in(copied) if row["metric"] == "failed_at_frame"}
    assert failed == {"fake_raises": 20.0, "fake_half_nan": 20.0}
    assert judged_again(copied) == Rejudged(same=10, new=0, moved=None)


@pytest.mark.usefixtures("no_tracker")
def test_frames_may_come_from_a_data_set(kept: Path, copied: Path, town: str, monkeypatch: pytest.MonkeyPatch) -> None:
    step, stepped = FakeEpisode.step, []
    monkeypatch.setattr(FakeEpisode, "step", lambda self: stepped.append(self._frame) or step(self))
    (copied / FILE_NAME).unlink()
    judged_again(copied, town)
    assert rows_in(copied) == rows_in(kept)
    # The first frame alone is rendered, to see which channels a data set should have.
    assert set(stepped) == {0}


def test_rows_keep_the_time_limit_that_they_were_made_under(tmp_path: Path) -> None:
    run(replace(TOWN, trackers=("fake_still",), seeds=range(3, 4), limit_s=30.0), tmp_path)
    assert judged_again(tmp_path) == Rejudged(same=1, new=0, moved=None)
    assert {row["limit_s"] for row in rows_in(tmp_path)} == {30.0}


def test_rows_in_real_time_are_those_of_the_run(tmp_path: Path) -> None:
    # At a million pictures a second only those of the grace are seen; one of the trackers fails on frame 20.
    trackers = ("fake_still", "fake_knowing", "fake_raises")
    run(replace(TOWN, trackers=trackers, seeds=range(3, 4), real_time_hz=1e6), tmp_path)
    rows = rows_in(tmp_path)
    assert {row["real_time_hz"] for row in rows} == {1e6}
    seen = [row["value"] for row in rows if row["metric"] == "frames_seen"]
    assert len(seen) == 3
    assert max(seen) < 0.5
    (tmp_path / FILE_NAME).unlink()
    judged_again(tmp_path)
    assert rows_in(tmp_path) == rows


@pytest.mark.heavy
def test_in_closed_loop_the_camera_obeys_what_it_obeyed(tmp_path: Path) -> None:
    steered = replace(TOWN, presets=("brief-loop",), trackers=("fake_knowing", "fake_raises"), seeds=range(3, 4))
    run(steered, tmp_path)
    rows = rows_in(tmp_path)
    (tmp_path / FILE_NAME).unlink()
    judged_again(tmp_path)
    assert rows_in(tmp_path) == rows
    path = next((tmp_path / "estimates").glob("*fake_knowing*"))
    told = pq.read_table(path)["obeyed_forward_mps"].to_pylist()
    assert told[0] is None
    assert len(set(told[1:])) > 10


@pytest.mark.heavy
def test_rows_of_many_targets_are_those_of_the_run(tmp_path: Path) -> None:
    run(FISH, tmp_path)
    rows = rows_in(tmp_path)
    (tmp_path / FILE_NAME).unlink()
    judged_again(tmp_path)
    assert rows_in(tmp_path) == rows
    failed = {row["tracker"]: row["value"] for row in rows if row["metric"] == "failed_at_frame"}
    assert failed == {"fake_gives_up": 9.0, "fake_regrets": 16.0}
    table = pq.read_table(next((tmp_path / "estimates").glob("*fake_wanders*"))).to_pandas()
    assert set(table["answer"]) == {"at once", "hindsight"}
    at_once = table[table["answer"] == "at once"]
    # Frames without a track have one row, so that they are not missing.
    assert at_once.loc[at_once["track"].isna(), "frame"].tolist() == [1, 5, 9, 13]
    assert set(at_once["frame"]) == set(range(16))


def test_rows_that_come_out_otherwise_replace_the_old_ones(kept: Path, copied: Path) -> None:
    lines = [json.loads(line) for line in (copied / FILE_NAME).read_text().splitlines()]
    for row in lines:
        if (row["tracker"], row["seed"]) == ("fake_still", 4):
            row["editions"]["judge"] = "an old one"
            row["value"] = 7.0
    (copied / FILE_NAME).write_text("".join(json.dumps(row) + "\n" for row in lines))
    done = judged_again(copied)
    assert (done.same, done.new) == (9, 1)
    assert str(done.moved).endswith("records.outdated-1.jsonl")
    assert rows_in(copied) == rows_in(kept)


def test_rows_depend_on_what_was_said(kept: Path, copied: Path) -> None:
    path = next((copied / "estimates").glob("000003-fake_still-*"))
    table = pq.read_table(path)
    where = table.schema.names.index("position_px")
    moved = [[x + 100.0, y] for x, y in table["position_px"].to_pylist()]
    field = table.schema.field(where)
    pq.write_table(table.set_column(where, field, pa.array(moved, field.type)), path)
    done = judged_again(copied)
    assert (done.same, done.new) == (9, 1)
    assert rows_in(copied) != rows_in(kept)


def other_rows(folder: Path) -> None:
    path = folder / FILE_NAME
    path.write_text(path.read_text().replace('"suite": "frame-out"', '"suite": "fish"'))


def another_edition(folder: Path) -> None:
    path = folder / FILE_NAME
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    changed = [row | {"editions": row["editions"] | {"tracker": "another"}} for row in lines]
    path.write_text("".join(json.dumps(row) + "\n" for row in changed))


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (other_rows, r"expected estimates of a block of rows in records\.jsonl, got suite frame-out, fake-town-v1"),
        (
            another_edition,
            r"expected estimates of the editions that made the rows in .*, got another \['tracker'\]",
        ),
    ],
)
def test_what_does_not_fit_is_named_and_nothing_is_written(
    copied: Path, damage: Callable[[Path], None], said: str
) -> None:
    damage(copied)
    before = (copied / FILE_NAME).read_bytes()
    with pytest.raises(ValueError, match=said):
        judged_again(copied)
    assert (copied / FILE_NAME).read_bytes() == before


def test_estimates_on_frames_of_another_edition_are_refused(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("benchmarks.data.estimates.rejudging.preset_edition", lambda scenario, preset: "new")
    with pytest.raises(ValueError, match=r"expected estimates on frames of the scene's present edition, new, got"):
        judged_again(copied)


def test_a_data_set_of_other_seeds_or_of_a_set_path_is_refused(town: str, tmp_path: Path) -> None:
    run(replace(TOWN, trackers=("fake_still",), seeds=range(5, 6)), tmp_path / "seeds")
    with pytest.raises(ValueError, match="expected a seed of 3:5, which the data set has, got 5"):
        judged_again(tmp_path / "seeds", town)
    run(replace(TOWN, trackers=("fake_still",), presets=("brief-loop",), seeds=range(3, 4)), tmp_path / "loop")
    with pytest.raises(ValueError, match="expected estimates of preset brief, which the data set has, got brief-loop"):
        judged_again(tmp_path / "loop", town)
    steered = replace(TOWN, trackers=("fake_still",), controllers=("centre",), seeds=range(3, 4))
    run(steered, tmp_path / "steered")
    with pytest.raises(ValueError, match="expected a set path, as of stored pictures, got one steered by centre"):
        judged_again(tmp_path / "steered", town)


def test_masks_are_judged_again_as_they_were(brief: None, tmp_path: Path) -> None:
    run(replace(TOWN, trackers=("fake_masked", "fake_still"), modules=(*TOWN.modules, masked.__name__)), tmp_path)
    before = rows_in(tmp_path)
    scored = {(row["tracker"], row["metric"]): row["value"] for row in before}
    assert 0 < scored["fake_masked", "j_and_f"] < 1
    assert ("fake_still", "j_and_f") not in scored
    (tmp_path / FILE_NAME).unlink()
    judged_again(tmp_path)
    assert rows_in(tmp_path) == before
