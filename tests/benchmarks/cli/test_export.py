"""``frameout export``."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.data.exports.exporter import formats
from benchmarks.data.sets.places import place_of
from tests.benchmarks.data.exports.painted_scene import painted_data_set, truths
from tests.benchmarks.no_room import no_room

MODULES = ["--modules", "tests.benchmarks.data.exports.painted_scene"]


def test_it_writes_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 1))
    out = tmp_path / "new" / "otb"
    assert main(["export", data.url, "--format", "otb", "--out", str(out), *MODULES]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert (out / "painted-v1-quick-000000" / "groundtruth_rect.txt").is_file()


def test_it_says_how_many_show_too_little(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 2))
    out = tmp_path / "yolo"
    options = ["--format", "yolo", "--out", str(out), "--classes", "kind", "--min-visible", "0.6", "--min-size", "3"]
    assert main(["export", data.url, *options, *MODULES]) == 0
    few = 0
    for truth in truths():
        for number, share in zip(truth.instance_id, truth.visible_fraction, strict=True):
            rows, columns = np.nonzero(truth.instance_map == number)
            few += bool(len(rows)) and bool(share < 0.6 or min(np.ptp(rows), np.ptp(columns)) + 1 < 3)
    assert few > 0
    said = f"{out}\n{2 * few} objects of single pictures left out or marked as ignored\n"
    assert capsys.readouterr().out == said
    assert '  1: "van"\n' in (out / "data.yaml").read_text()


def test_results_without_answers_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "records.jsonl").touch()
    assert main(["export", str(tmp_path), "--format", "vot", "--out", str(tmp_path / "out")]) == 2
    told = "error: directory: expected a data set, or results of `frameout bench --keep-estimates`, got results without"
    assert capsys.readouterr().err.startswith(told)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["{set}", "--format", "nix", "--out", "{out}"], "format: expected one of coco, "),
        (
            ["{set}", "--format", "otb", "--out", "{out}", "--min-visible", "0.1"],
            "min_visible min_size ignore_standing: expected none",
        ),
        (
            ["{set}", "--format", "coco", "--out", "{out}", "--min-visible", "5"],
            "min_visible: expected a share of 0 to",
        ),
        (
            ["{set}", "--format", "otb", "--out", "{set}"],
            "out: expected an empty folder or one that does not exist",
        ),
        (["{set}", "--format", "yolo", "--out", "{out}"], "data: expected episodes to train on and to validate on"),
        (
            ["{set}/nix", "--format", "otb", "--out", "{out}"],
            "directory: expected a data set with a file dataset.json, got none in ",
        ),
    ],
)
def test_wrong_arguments_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 1))
    given = [word.format(set=data.url, out=tmp_path / "out") for word in words]
    assert main(["export", *given, *MODULES]) == 2
    assert capsys.readouterr().err.startswith(f"error: {message}")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("pixels-00000.tar", lambda file: file.write_bytes(file.read_bytes()[:40_000])),
        ("pixels-00000.tar", Path.unlink),
        ("objects.parquet", Path.unlink),
        ("standing.parquet", Path.unlink),
        ("frames.parquet", lambda file: file.write_bytes(b"junk")),
        ("frames.parquet", lambda file: file.write_bytes(bytes(file.stat().st_size))),
        ("pixels-00000.tar", lambda file: file.write_bytes(bytes(file.stat().st_size))),
    ],
    ids=[
        "a part of a shard",
        "no shard",
        "no table",
        "no standing table",
        "no table but junk",
        "a table of zeros",
        "a shard of zeros",
    ],
)
def test_a_damaged_data_set_is_named_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, damage: Callable[[Path], object]
) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 1))
    damage(tmp_path / "set" / "episodes" / "000000" / name)
    assert main(["export", data.url, "--format", "coco", "--out", str(tmp_path / "out"), *MODULES]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: data: expected a whole data set (see frameout verify), got episode 0: {name}")
    assert not (tmp_path / "out").exists()


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("benchmarks.run.packages.find_spec", lambda name: None)
    assert main(["export", "set", "--format", "otb", "--out", "out"]) == 2
    assert (
        "packages: expected blosc2, fsspec, pyarrow, yaml to be installed (pip install 'frameout[data]')"
        in capsys.readouterr().err
    )


def test_the_help_lists_all_formats(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["export", "--help"])
    out = capsys.readouterr().out
    assert all(name in out for name in formats())
    assert "{None}" not in out


def test_a_full_disk_is_told_in_one_line_and_nothing_is_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 1))
    with no_room(3_000):
        assert main(["export", data.url, "--format", "webdataset", "--out", str(tmp_path / "out"), *MODULES]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"error: (.*: )?File too large; what was written before is kept", line)
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_an_incomplete_set_is_exported_on_demand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = painted_data_set(tmp_path / "set", seeds=(0, 2))
    shutil.rmtree(tmp_path / "set" / "episodes" / "000001")
    words = ["export", data.url, "--format", "otb", "--out", str(tmp_path / "out"), *MODULES]
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: data: expected all episodes (`frameout generate` makes those that are missing")
    assert main([*words, "--allow-incomplete"]) == 0
    assert (tmp_path / "out" / "list.txt").read_text() == "painted-v1-quick-000000\n"


def test_a_url_is_no_folder_of_this_machine(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    data = painted_data_set(tmp_path / "set", seeds=(0, 1))
    assert main(["export", data.url, "--format", "otb", "--out", "memory://from-a-command/otb", *MODULES]) == 0
    assert capsys.readouterr().out == "memory://from-a-command/otb\n"
    files, root = place_of("memory://from-a-command/otb")
    assert files.exists(f"{root}/painted-v1-quick-000000/groundtruth_rect.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]
