"""What a file says is what a set is of; what is wrong in it is named before anything is made."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.data_functions import described, export, generate
from benchmarks.cli.main import main
from benchmarks.data.sets.data_set import DataSet, data_sets
from tests.benchmarks.data.sets.small import MODULES

GOOD = """
scenario: fake-town
preset: tiny
set: {frame_count: 4:6, rate_hz: 10}
episodes: 3
channels: [image_rgb, depth_m]
pictures: jpeg-60
splits: {train: 0.5, val: 0.5}
classes: [car]
negatives: 0.25
"""
PARTS = """
preset: tiny
set: {frame_count: 2, rate_hz: 10}
channels: none
parts:
  few: {scenario: fake-town, seeds: 5}
  more: {scenario: fake-town, seeds: 1:3, set: {rate_hz: 20}, channels: [image_rgb]}
"""


def written(folder: Path, text: str) -> Path:
    (folder / "set.yaml").write_text(text)
    return folder / "set.yaml"


def test_a_file_says_what_a_set_is_of_and_the_set_keeps_it(tmp_path: Path) -> None:
    request = described(written(tmp_path, GOOD))[""]
    assert request.preset == "tiny[frame_count=4:6,rate_hz=10]"
    assert (request.seeds, request.channels, request.pictures) == ((0, 3), ("image_rgb", "depth_m"), "jpeg-60")
    assert (request.splits, request.classes, request.negatives) == ({"train": 0.5, "val": 0.5}, ("car",), 0.25)
    (data,) = generate(tmp_path / "set.yaml", tmp_path / "set", workers=0, modules=MODULES)
    assert data.request == request
    assert DataSet(data.url).request == request
    assert data.splits == {"train": (0,), "val": (1, 2)} or set(data.splits) == {"train", "val"}


def test_a_description_in_python_and_options_are_the_same_as_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = described(written(tmp_path, GOOD))
    said: dict[str, Any] = {
        "scenario": "fake-town",
        "preset": "tiny",
        "set": {"frame_count": "4:6", "rate_hz": 10},
        "seeds": range(3),
        "channels": ["image_rgb", "depth_m"],
        "pictures": "jpeg-60",
        "splits": {"train": 0.5, "val": 0.5},
        "classes": ["car"],
        "negatives": 0.25,
    }
    assert described(said) == asked
    words = "fake-town --preset tiny --set frame_count=4:6 --set rate_hz=10 --seeds 0:3 --channels image_rgb depth_m"
    words += " --pictures jpeg-60 --splits train=0.5 val=0.5 --classes car --negatives 0.25 --dry-run --out x"
    told = []
    for line in (words, f"--config {tmp_path / 'set.yaml'} --out x --dry-run"):
        assert main(["generate", *line.split(), "--modules", *MODULES]) == 0
        told.append(capsys.readouterr().out.partition("KiB")[0])
    assert told[0] == told[1] != ""
    assert not (tmp_path / "x").exists()


def test_parts_have_what_they_share_and_what_is_their_own(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told: list[tuple[int, int]] = []
    made = generate(
        written(tmp_path, PARTS), tmp_path / "set", workers=0, modules=MODULES, progress=lambda *now: told.append(now)
    )
    assert {of for _, of in told} == {3}, "progress is that of the whole set"
    assert sorted(told) == told
    assert told[-1] == (3, 3)
    few, more = made
    assert (few.request.preset, few.request.seeds, few.request.channels) == (
        "tiny[frame_count=2,rate_hz=10]",
        (5, 6),
        (),
    )
    assert (more.request.preset, more.request.channels) == ("tiny[frame_count=2,rate_hz=20]", ("image_rgb",))
    assert [data.url for data in data_sets(str(tmp_path / "set"))] == [
        str(tmp_path / "set/few"),
        str(tmp_path / "set/more"),
    ]
    with pytest.raises(ValueError, match=r"directory: expected one part of a set, .*/few or .*/more, got"):
        DataSet(str(tmp_path / "set"))
    assert main(["verify", str(tmp_path / "set"), "--modules", *MODULES]) == 0
    assert capsys.readouterr().out.count("all whole") == 2
    config = ["--config", str(tmp_path / "set.yaml"), "--out", str(tmp_path / "set")]
    assert main(["generate", *config, "--workers", "0", "--modules", *MODULES]) == 0
    *parts, last = capsys.readouterr().out.splitlines()
    assert len(parts) == 2
    assert all(re.fullmatch(r".*/set/(few|more): [12] episodes?, [24] frames, .* GiB", line) for line in parts)
    assert re.fullmatch(r".*/set: 2 parts, \d+ s", last)
    with pytest.raises(ValueError, match="out: expected a set of the parts one, got"):
        generate(
            {"parts": {"one": {"scenario": "fake-town", "preset": "tiny", "seeds": 1}}},
            tmp_path / "set",
            modules=MODULES,
        )


def test_all_parts_are_exported_or_none(tmp_path: Path) -> None:
    said = {"preset": "tiny", "set": {"frame_count": 2}, "seeds": 1, "scenario": "fake-town"}
    parts = {"one": {"channels": ["image_rgb", "depth_m"]}, "two": {"channels": ["image_rgb"]}}
    generate(said | {"parts": parts}, f"{tmp_path}/set/", workers=0, modules=MODULES)
    with pytest.raises(ValueError, match=r"parts\.two\.data: expected the channels image_rgb, depth_m for kitti-depth"):
        export(f"{tmp_path}/set/", "kitti-depth", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]
    export(f"{tmp_path}/set/", "otb", tmp_path / "out")
    assert [(tmp_path / "out" / name / "README.md").is_file() for name in parts] == [True, True]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scenario: nowhere\nseeds: 1", "scenario: expected one of .*; got 'nowhere'"),
        ("preset: tiny\nseeds: 1", r"scenario: expected a catalogue id \(frameout list\), got none"),
        ("scenario: fake-town\npreset: huge\nseeds: 1", "preset: expected one of tiny, .*; got 'huge'"),
        ("scenario: fake-town", "seeds: expected either seeds or episodes, got none"),
        ("scenario: fake-town\nseeds: 1\nepisodes: 3", "seeds: expected either seeds or episodes, got both"),
        ("scenario: fake-town\nseeds: 5:2", "seeds: expected A:B with 0 <= A < B, or one seed, got '5:2'"),
        ("scenario: fake-town\nepisodes: few", "episodes: expected a whole number > 0, got 'few'"),
        ("scenario: fake-town\nseeds: 1\nset: {speed: 3}", r"set: expected one of frame_count, .*; got 'speed'"),
        ("scenario: fake-town\nseeds: 1\nset: {rate_hz: }", "set rate_hz: expected a value, got ''"),
        (
            "scenario: fake-town\nseeds: 1\nset: {rate_hz: uniform(3,5)}",
            r"set: expected a field's name \(a value with commas .*, got '5\)'",
        ),
        ("scenario: fake-town\nseeds: 1\nchanels: [a]", r"key: expected one of .*; got 'chanels' \(did you mean chan"),
        ("scenario: fake-town\nseeds: 1\nchannels: [depth]", "channels: expected some of image_rgb, .*, got 'depth'"),
        ("scenario: fake-town\nseeds: 1\npictures: gif", "pictures: expected one of .*, got 'gif'"),
        ("scenario: fake-town\nseeds: 1\nsplits: {train: most}", "splits train: expected a number, got 'most'"),
        ("scenario: fake-town\nseeds: 1\nsplits: [0.8, 0.2]", "splits: expected names with values, got"),
        ("scenario: fake-town\nseeds: 1\nsplits: {train: 0.9}", "splits: expected shares that sum to 1, got 0.9"),
        ("scenario: fake-town\nseeds: 1\nclasses: [boat]", "classes: expected one of .*; got 'boat'"),
        ("scenario: fake-town\nseeds: 1\nnegatives: 10", "negatives: expected a share of 0 to 1, got 10"),
        ("scenario: fake-town\nseeds: 1\nrenderer: x", "renderer: expected one of raster, pybullet; got 'x'"),
        ("scenario: fake-town\nscenario: fake-town", "line 1: expected each key once, got 'scenario' twice"),
        ("scenario: [", "expected YAML, got "),
        ("- town", "expected keys with values, e.g. scenario: road-town, got "),
        ("parts: {}", "parts: expected one or more, got none"),
        ("parts: {a/b: {scenario: fake-town}}", r"parts\.a/b\.name: expected a word, as of a folder, got 'a/b'"),
        ("parts: {one: {scenario: fake-town, seeds: 2:1}}", r"parts\.one\.seeds: expected A:B"),
    ],
)
def test_what_is_wrong_is_named_in_one_line_with_its_file(
    text: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if text.startswith("scenario: fake-town") and "preset" not in text:
        text = f"preset: tiny\n{text}"
    path, out = written(tmp_path, text), tmp_path / "set"
    assert main(["generate", "--config", str(path), "--out", str(out), "--workers", "0", "--modules", *MODULES]) == 2
    told = capsys.readouterr().err.splitlines()
    assert re.match(rf"error: {re.escape(str(path))}: {message}", told[-1]), told
    assert not out.exists()


def test_a_file_says_all_and_what_cannot_be_read_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(written(tmp_path, GOOD))
    for words, message in (
        ([path, "--preset", "tiny"], "config: expected a file that says all, got .* with --preset"),
        ([path, "--set", "rate_hz=3"], "config: expected a file that says all, got .* with --set"),
        ([path, "--seeds", "9:12"], "seeds: expected some that the set has, 0:3, got"),
        ([str(tmp_path / "none.yaml")], "config: expected a file that can be read, got .*: No such file"),
    ):
        out = ["--out", str(tmp_path / "set"), "--modules", *MODULES]
        assert main(["generate", "--config", *words, *out]) == 2
        assert re.match(f"error: {message}", capsys.readouterr().err)
