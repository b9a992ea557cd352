"""Long lists in one JSON file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.data.exports.json_lists import JsonLists


def test_lists_come_together(tmp_path: Path) -> None:
    with JsonLists(tmp_path / "a.json", ("one", "two", "none"), {"info": {"x": float("nan")}}) as lists:
        for k in range(3):
            lists.add("two", {"k": k, "list": [float("inf"), 0.5]})
            lists.add("one", {"é": (k,)})
    assert json.loads((tmp_path / "a.json").read_text()) == {
        "info": {"x": None},
        "one": [{"é": [k]} for k in range(3)],
        "two": [{"k": k, "list": [None, 0.5]} for k in range(3)],
        "none": [],
    }
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_a_failure_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="stop"), JsonLists(tmp_path / "a.json", ("one",), {"info": 1}):
        raise RuntimeError("stop")
    assert not list(tmp_path.iterdir())
