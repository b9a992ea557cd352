"""The labels of the stills are sound, pictures are the ones that were labelled, and boxes shrink with their picture."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from http.client import IncompleteRead
from pathlib import Path

import cv2
import numpy as np
import pytest

pytest.importorskip("torch", reason="torch is not installed")
pytest.importorskip("pycocotools", reason="pycocotools is not installed")
import real_stills
from detections import average_precision
from real_stills import MOST, Still, by_chance, resized, stills


def still(folder: Path, **changes: object) -> Still:
    """Return a still of one bright car on dark ground, in a file of the folder, and one unclear."""
    picture = np.full((200, 300, 3), 40, np.uint8)
    picture[80:120, 100:200] = 220
    content = cv2.imencode(".png", picture)[1].tobytes()
    (folder / "still.png").write_bytes(content)
    digest = hashlib.sha256(content).hexdigest()
    one = Still("still.png", (folder / "gone.png").as_uri(), "CC0", digest, 100, [[100, 80, 200, 120]], [[0, 0, 9, 9]])
    return replace(one, **changes)  # type: ignore[arg-type]


def test_labels_are_boxes_as_long_as_cars_and_of_each_car_one() -> None:
    assert 20 <= sum(len(each.cars) for each in stills()) <= 100
    for each in stills():
        assert each.url.startswith("https://")
        assert each.licence
        boxes = each.boxes
        sides = boxes[:, 2:4] - boxes[:, :2]
        assert (boxes[:, :4] >= 0).all()
        assert (sides > 0).all()
        lengths = sides[boxes[:, 4] == 1].max(axis=1) / each.car_px
        assert ((lengths > 0.6) & (lengths < 1.4)).all()
        assert average_precision([(boxes, boxes)]) == pytest.approx(1.0)


def test_a_picture_of_the_folder_is_the_one_that_was_labelled(tmp_path: Path) -> None:
    assert still(tmp_path).picture(tmp_path).shape == (200, 300, 3)
    with pytest.raises(ValueError, match=r"pictures: expected .*still\.png as it was labelled"):
        still(tmp_path, sha256="0" * 64).picture(tmp_path)


def test_a_missing_picture_is_fetched_once_or_named(tmp_path: Path) -> None:
    here, folder = still(tmp_path), tmp_path / "pictures"
    with pytest.raises(ValueError, match=r"pictures: expected .*pictures/still\.png, or an answer from file://"):
        here.picture(folder)
    reached = replace(here, url=(tmp_path / "still.png").as_uri())
    fetched = reached.picture(folder)
    assert (folder / "still.png").exists()
    np.testing.assert_array_equal(here.picture(folder), fetched)


def test_another_picture_or_a_part_of_one_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "pictures"
    reached = still(tmp_path, url=(tmp_path / "still.png").as_uri())
    with pytest.raises(ValueError, match=r"pictures: expected file://.*still\.png as it was labelled"):
        replace(reached, sha256="0" * 64).picture(folder)

    def cut(*_: object, **__: object) -> None:
        raise IncompleteRead(b"half", 4)

    with monkeypatch.context() as patched:
        patched.setattr(real_stills, "urlopen", cut)
        with pytest.raises(ValueError, match=r"or an answer from file://.*IncompleteRead"):
            reached.picture(folder)
    assert not folder.exists()
    assert reached.picture(folder).shape == (200, 300, 3)


@pytest.mark.parametrize("scale", [0.25, 0.24, 0.173])
def test_boxes_stay_on_their_cars(tmp_path: Path, scale: float) -> None:
    one = still(tmp_path)
    small, boxes = resized(one.picture(tmp_path), one.boxes, scale)
    assert small.shape[:2] == (round(200 * scale), round(300 * scale))
    rows, columns = np.nonzero(small[:, :, 0] > 130)
    seen = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
    np.testing.assert_allclose(boxes[0, :4], seen, atol=0.6)
    np.testing.assert_array_equal(boxes[:, 4], [1, 0])


def test_chance_finds_next_to_nothing() -> None:
    rng = np.random.default_rng(0)
    shape = (1700, 1700, 3)
    found = [(each.boxes, by_chance(each, shape, rng)) for each in stills()]
    assert all(len(boxes) == MOST for _, boxes in found)
    assert average_precision(found) < 0.02
