"""Files of background models: there and back, and what they refuse."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import save_file

from tests.trackers.drawn_harbour import CAMERA, VIEW, looking
from trackers.site import SiteView
from trackers.site_model_file import Form, load_model, save_model

ARRAYS = {"mean": np.arange(12, dtype=np.float32).reshape(3, 4), "first": np.array([0, 2, 5])}
FORMS = {"mean": Form("float32", ("rows", 4)), "first": Form("int64", ("rows",))}
T = VIEW.T_world_camera


def test_arrays_come_back_as_they_were(tmp_path: Path) -> None:
    path = save_model(tmp_path / "quay", "watch-1", VIEW, ARRAYS)
    assert path.name == "quay.safetensors"
    loaded = load_model(tmp_path / "quay", "watch-1", VIEW, FORMS)
    assert set(loaded) == set(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(loaded[name], array)
        assert loaded[name].dtype == array.dtype


def test_a_second_survey_of_the_same_camera_is_taken_for_it(tmp_path: Path) -> None:
    save_model(tmp_path / "quay", "watch-1", VIEW, ARRAYS)
    surveyed = SiteView(CAMERA, looking(np.array([-100.05, 0.05, 20.0]), np.array([0.0, 0.08, 0.0])))
    assert load_model(tmp_path / "quay", "watch-1", surveyed, FORMS)


@pytest.mark.parametrize(
    ("view", "message"),
    [
        (SiteView(replace(CAMERA, width_px=384), T), "width_px 384 here and 192 there"),
        (SiteView(replace(CAMERA, height_px=288), T), "height_px 288 here and 144 there"),
        (SiteView(replace(CAMERA, focal_px=700.0), T), "focal_px 700 here and 770 there"),
        (SiteView(replace(CAMERA, band="colour"), T), "band colour here and thermal there"),
        (SiteView(CAMERA, looking(np.array([-100.0, 2.0, 20.0]), np.array([0.0, 2, 0]))), r"place_m 2\.00 m away"),
        (SiteView(CAMERA, looking(VIEW.place_m, np.array([0.0, 1, 0]))), r"T_world_camera turned by 0\.57 degrees"),
    ],
)
def test_the_model_of_another_camera_is_refused_by_name(tmp_path: Path, view: SiteView, message: str) -> None:
    path = save_model(tmp_path / "quay", "watch-1", VIEW, ARRAYS)
    with pytest.raises(ValueError, match=rf"model: expected one of this camera, got '{path}', of another: {message}$"):
        load_model(path, "watch-1", view, FORMS)


def plain(path: Path, **metadata: str) -> None:
    save_file(dict[str, NDArray[Any]](ARRAYS), path, metadata=metadata or None)


def test_what_is_no_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="model: expected a file that can be read"):
        load_model(tmp_path / "missing", "watch-1", VIEW, FORMS)
    (tmp_path / "torn.safetensors").write_bytes(b"\x80\x04torn")
    plain(tmp_path / "bare.safetensors")
    plain(tmp_path / "odd.safetensors", model="[1, 2]")
    plain(tmp_path / "partial.safetensors", model='{"kind": "watch-1"}')
    for name in ("torn", "bare", "odd", "partial"):
        with pytest.raises(ValueError, match=f"model: expected a background model, got .*{name}"):
            load_model(tmp_path / name, "watch-1", VIEW, FORMS)
    save_model(tmp_path / "other", "watch-2", VIEW, ARRAYS)
    with pytest.raises(ValueError, match=r"model: expected one of watch-1, got .*, one of watch-2"):
        load_model(tmp_path / "other", "watch-1", VIEW, FORMS)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"first": None}, r"model: expected the arrays \['first', 'mean'\], got '.*' with \['mean'\]"),
        ({"other": np.zeros(2)}, "model: expected the arrays .*, got .* 'other'"),
        ({"first": np.array([0, 2])}, r"model: expected first of int64 \(3,\), got '.*' with int64 \(2,\)"),
        ({"first": np.array([0.0, 2.0, 5.0])}, r"model: expected first of int64 \(3,\), got '.*' with float64 \(3,\)"),
        ({"mean": np.zeros((3, 5), np.float32)}, r"model: expected mean of float32 \(3, 4\), got .*\(3, 5\)"),
        ({"mean": np.zeros(12, np.float32)}, r"model: expected mean of float32 \(12, 4\), got .*\(12,\)"),
        ({"mean": np.full((3, 4), np.nan, np.float32)}, "model: expected finite numbers in mean, got .* with others"),
    ],
)
def test_arrays_of_another_form_are_refused_by_name(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    arrays = {name: array for name, array in (ARRAYS | changes).items() if array is not None}
    path = save_model(tmp_path / "quay", "watch-1", VIEW, arrays)
    with pytest.raises(ValueError, match=message):
        load_model(path, "watch-1", VIEW, FORMS)
