"""What holds for every format: the same bytes, wholly or not at all, pictures as they are stored."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.exports.exporter import Exporter, export, export_format, formats
from benchmarks.data.sets.channels import CODINGS
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.run import packages
from tests.benchmarks.data.exports.painted_scene import FRAMES, painted_data_set, picture
from tests.benchmarks.data.sets.hub_head import head_of


def contents(folder: Path) -> dict[str, bytes]:
    """Return the content of each file, by its place."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


# Rerun's own software gives rows identities by the clock; their values are compared in ``test_rerun``.
@pytest.mark.parametrize("name", [name for name in formats() if name != "rerun"])
def test_the_same_data_set_gives_the_same_bytes(
    data: DataSet, exported: Callable[[str], Path], tmp_path: Path, name: str
) -> None:
    export(DataSet(data.url), name, tmp_path / "again")
    assert contents(tmp_path / "again") == contents(exported(name))
    assert (
        f"# {name}\n\nEpisodes of painted-v1, preset quick, of the seeds 3–4."
        in (tmp_path / "again" / "README.md").read_text()
    )


@pytest.mark.parametrize(
    ("name", "held", "tasks"),
    [
        ("otb", set(), None),
        ("mot", set(), ["object-detection"]),
        ("coco", set(), ["object-detection", "image-segmentation"]),
        ("kitti-depth", {"depth_m"}, ["depth-estimation"]),
        ("kitti-flow", {"flow_px"}, None),
        ("webdataset", {"depth_m", "flow_px"}, ["object-detection", "image-segmentation", "depth-estimation"]),
    ],
)
def test_a_readme_names_what_its_format_holds(
    exported: Callable[[str], Path], name: str, held: set[str], tasks: list[str] | None
) -> None:
    readme = exported(name) / "README.md"
    text = readme.read_text()
    assert {each for each in ("depth_m", "flow_px", "normal_world") if f"`{each}`" in text} == held
    assert head_of(readme).get("task_categories") == tasks
    assert "below `--min-visible 0" not in text
    assert text.endswith("\n")


@pytest.mark.parametrize(
    "name", [name for name in formats() if name.startswith(("hub", "kitti", "rerun", "webdataset", "yolo"))]
)
def test_after_a_failure_nothing_is_left(
    data: DataSet, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the way, in the second episode."""
    picture, asked = StoredEpisode.coded, list[int]()

    def fail(episode: StoredEpisode, index: int, channel: str) -> Any:
        asked.append(index)
        if episode.seed == 4 and index > 2:
            raise RuntimeError("stop")
        return picture(episode, index, channel)

    monkeypatch.setattr(StoredEpisode, "coded", fail)
    with pytest.raises(RuntimeError, match="stop"):
        export(data, name, tmp_path / "out")
    assert len(asked) > FRAMES
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("pixels-00000.tar", lambda file: file.write_bytes(file.read_bytes()[:40_000])),
        # It decodes.
        ("objects.parquet", lambda file: shutil.copy(file.parents[1] / "000003" / file.name, file)),
    ],
)
def test_a_changed_byte_is_found(data: DataSet, tmp_path: Path, name: str, damage: Callable[[Path], object]) -> None:
    shutil.copytree(data.url, tmp_path / "set")
    damage(tmp_path / "set" / "episodes" / "000004" / name)
    with pytest.raises(ValueError, match=rf"data: expected a whole data set .*, got episode 4: {name}: "):
        export(DataSet(str(tmp_path / "set")), "coco", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


@pytest.mark.parametrize(("pictures", "coding"), [("png", "png"), ("jpeg", "jpeg"), ("jpeg-80", "jpeg")])
def test_stored_pictures_are_copied_unchanged(tmp_path: Path, pictures: str, coding: str) -> None:
    data = painted_data_set(tmp_path / "set", pictures=pictures, seeds=(3, 4))
    export(data, "otb", tmp_path / "out")
    ending = CODINGS[coding].extension
    for k in range(FRAMES):
        content = (tmp_path / "out" / "painted-v1-quick-000003" / "img" / f"{k + 1:04d}.{ending}").read_bytes()
        assert data.episode(3).coded(k, "image_rgb") == (coding, content)
        if pictures == "png":
            np.testing.assert_array_equal(CODINGS[coding].decode(content), picture(3, k))


def test_what_is_there_is_kept(data: DataSet, tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("mine")
    (tmp_path / "file").write_text("mine")
    (tmp_path / "nested" / "empty").mkdir(parents=True)
    for name in ("full", "file", "nested"):
        with pytest.raises(ValueError, match=r"out: expected an empty folder or one that does not exist, got '.*"):
            export(data, "otb", tmp_path / name)
    assert (tmp_path / "full" / "mine").read_text() == (tmp_path / "file").read_text() == "mine"
    (tmp_path / "empty").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "empty")
    export(data, "otb", tmp_path / "link")
    assert (tmp_path / "empty" / "README.md").is_file()
    with pytest.raises(ValueError, match="out: expected a folder inside of a disk"):
        export(data, "otb", Path("/"))
    assert (tmp_path / "empty" / "list.txt").is_file()
    with pytest.raises(ValueError, match="out: expected a folder that can be written, got '/proc'"):
        export(data, "otb", Path("/proc/nix"))


def test_a_format_that_writes_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="write_episode: expected such a method of class Nothing, got none"):
        export_format("nothing")(type("Nothing", (Exporter,), {"__doc__": "Nothing."}))


def test_a_missing_package_an_unknown_format_and_an_empty_set_are_named(
    monkeypatch: pytest.MonkeyPatch, data: DataSet, tmp_path: Path
) -> None:
    assert all("http" in str(each.__doc__) for each in formats().values())
    with pytest.raises(ValueError, match=r"format: expected one of coco, .*, yolo-seg; got 'nix'"):
        export(data, "nix", tmp_path / "out")
    (tmp_path / "dataset.json").write_bytes((Path(data.url) / "dataset.json").read_bytes())
    with pytest.raises(ValueError, match=r"data: expected a data set with episodes, got .* without any"):
        export(DataSet(str(tmp_path)), "otb", tmp_path / "out")
    monkeypatch.setattr(packages, "find_spec", lambda name: None)
    message = r"packages: expected pycocotools to be installed \(pip install 'frameout\[data\]'\), got none"
    with pytest.raises(ValueError, match=message):
        export(data, "coco", tmp_path / "out")


def test_an_incomplete_data_set_says_so(data: DataSet, tmp_path: Path) -> None:
    shutil.copytree(data.url, tmp_path / "set")
    shutil.rmtree(tmp_path / "set" / "episodes" / "000004")
    export(DataSet(str(tmp_path / "set")), "otb", tmp_path / "out", allow_incomplete=True)
    assert (tmp_path / "out" / "list.txt").read_text().split() == ["painted-v1-quick-000003"]
    told = "of the seeds 3. Missing, though asked for: the seeds 4."
    assert told in (tmp_path / "out" / "README.md").read_text()


@pytest.mark.parametrize("name", ["otb", "coco", "webdataset"])
def test_a_store_gets_the_files_of_a_folder(data: DataSet, exported: Callable[[str], Path], name: str) -> None:
    files, root = place_of(f"memory://exports/{name}")
    export(data, name, f"memory://exports/{name}")
    sent = {path.removeprefix(f"{root}/"): files.cat_file(path) for path in files.find(root)}
    assert sent == contents(exported(name))
    with pytest.raises(ValueError, match=r"out: expected an empty folder .*, got 'memory://"):
        export(data, name, f"memory://exports/{name}")


@pytest.mark.parametrize("out", ["memory://exports/broken", "memory://emptybucket"])
def test_a_failure_on_the_way_to_a_store_removes_what_was_sent_alone(
    data: DataSet, monkeypatch: pytest.MonkeyPatch, out: str
) -> None:
    files, root = place_of(out)
    files.makedirs(root, exist_ok=True)
    put, sent = type(files).put_file, []

    def fail(self: Any, source: str, target: str, **others: Any) -> None:
        if target.endswith("README.md"):
            self.pipe_file(f"{root}/theirs.txt", b"theirs")
            raise OSError("connection lost")
        put(self, source, target, **others)
        sent.append(target)

    with monkeypatch.context() as patch:
        patch.setattr(type(files), "put_file", fail)
        message = rf"out: expected a store that can be reached, got '{out}' \(connection lost\)"
        with pytest.raises(ValueError, match=message):
            export(data, "otb", out)
    # README.md is the last, so that a reader who finds it finds all.
    assert len(sent) > FRAMES
    assert files.find(root) == [f"{root}/theirs.txt"]
    files.rm_file(f"{root}/theirs.txt")
    assert files.isdir(root)
    export(data, "otb", out)
    assert files.exists(f"{root}/README.md")
