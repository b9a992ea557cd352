"""The visit that the report shows: the first arrival that can be seen for long enough."""

from __future__ import annotations

from typing import Any

from benchmarks.show.suites.harbour import first_visit


def row(seed: int, first_frame: int, length_frames: int, metric: str = "found") -> dict[str, Any]:
    event = {"index": 0, "kind": "person", "first_frame": first_frame, "length_frames": length_frames}
    return {"metric": metric, "seed": seed, "event": event}


def test_the_first_arrival_is_shown() -> None:
    rows = [row(1, 3, 90), row(0, 0, 90), row(0, 5, 7), row(0, 4, 90, "found_unseen"), row(0, 40, 9), row(0, 30, 8)]
    found = first_visit(rows)
    assert found is not None
    assert (found.seed, found.frames, found.title) == (0, [33, 37], "A person comes")
    assert first_visit(rows[1:3]) is None
