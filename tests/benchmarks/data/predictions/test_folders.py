"""Which trackers folders hold, and where their files may be."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.data.predictions.folders import find_folders


def _write(root: Path, *paths: str) -> None:
    for path in paths:
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text("1\n")


@pytest.mark.parametrize("place", ["a.txt", "data/a.txt", "a/a_001.txt", "baseline/a/a_001.txt"])
def test_a_folder_is_a_tracker_or_holds_trackers(tmp_path: Path, place: str) -> None:
    _write(tmp_path, f"mine/{place}", f"yours/{place}", "README.txt", "mine/notes.txt")
    both = find_folders([tmp_path], None, "a".__eq__, "a")
    assert [each.path.name for each in both] == ["mine", "yours"]
    (mine,) = find_folders([tmp_path / "mine"], None, "a".__eq__, "a")
    assert mine.sequences["a"] == tmp_path / "mine" / place
    assert [
        each.path.name for each in find_folders([tmp_path / "yours", tmp_path / "mine"], None, "a".__eq__, "a")
    ] == ["yours", "mine"]


def test_what_is_no_tracker_is_refused(tmp_path: Path) -> None:
    _write(tmp_path, "mine/b.txt", "others/mine/a.txt", "json/1.json", "json/2.json")
    with pytest.raises(ValueError, match=r"predictions: expected folders that exist, got 'nix'"):
        find_folders([Path("nix")], None, "a".__eq__, "a")
    with pytest.raises(ValueError, match=r"predictions: expected NAME\.txt, data/NAME\.txt.*, got b\.txt"):
        find_folders([tmp_path / "mine"], None, "a".__eq__, "a")
    with pytest.raises(ValueError, match=r"json: expected one JSON file of results, got 2 of them"):
        find_folders([tmp_path / "json"], tmp_path / "instances.json", "a".__eq__, "a")


def test_json_that_others_keep_beside_text_is_left_alone(tmp_path: Path) -> None:
    _write(tmp_path, "mine/a.txt", "mine/config.json", "mine/summary.json")
    (mine,) = find_folders([tmp_path / "mine"], None, "a".__eq__, "a")
    assert mine.sequences == {"a": tmp_path / "mine" / "a.txt"}
