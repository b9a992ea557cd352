"""Blobs on the ground, and the linker of the harbour's baselines."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW
from trackers.baselines.ground_linker import (
    EVIDENCE,
    Blob,
    BlobParameters,
    GroundLinker,
    LinkParameters,
    blobs_of,
    evidence_of,
)
from trackers.estimate_check import check_tracks
from trackers.site import placed

SITE = placed(SURVEY, CAMERA, VIEW.T_world_camera)
SHAPE = (CAMERA.height_px, CAMERA.width_px)


def box_of(place_m: tuple[float, float], width_m: float, height_m: float, base_m: float = 0.0) -> NDArray[np.int64]:
    """Return the box in the picture of a flat thing that stands at a place, at the height ``base_m``."""
    corners_m = np.array([[*place_m, base_m], [*place_m, base_m + height_m]]) + np.array(
        [[0, width_m / 2, 0], [0, -width_m / 2, 0]]
    )
    px, _ = VIEW.project(corners_m)
    return np.round([px[0, 0], px[1, 1], px[1, 0], px[0, 1]]).astype(int)


def found(*boxes: NDArray[np.int64], contrast: float = 8.0, **changes: float) -> list[Blob]:
    foreground = np.zeros(SHAPE, np.uint8)
    for x0, y0, x1, y1 in boxes:
        foreground[y0:y1, x0:x1] = 255
    parameters = BlobParameters(**changes)  # type: ignore[arg-type]
    return blobs_of(foreground, np.full(SHAPE, contrast, np.float32) * (foreground > 0), SITE, parameters)


@pytest.mark.parametrize(
    ("place_m", "base_m"), [((0.0, 0.0), 0.0), ((-10.0, 4.0), 0.0), ((30.0, -5.0), 0.0), ((-24.0, 4.0), -1.8)]
)
def test_a_blob_stands_half_its_width_behind_its_foot_with_its_size(
    place_m: tuple[float, float], base_m: float
) -> None:
    [blob] = found(box_of(place_m, 1.2, 1.7, base_m))
    # Half a pixel is up to 0.7 m along the line of sight here, and 0.09 m across it.
    assert abs(blob.place_m[0] - place_m[0] - 0.6) < 0.7
    assert abs(blob.place_m[1] - place_m[1]) < 0.1
    assert blob.place_m[2] == pytest.approx(base_m)
    np.testing.assert_allclose(blob.size_m, [1.2, 1.2, 1.7], atol=0.2)
    away_m = np.sqrt(np.diag(blob.covariance_m2))
    assert 3 * away_m[1] > abs(blob.place_m[1] - place_m[1])
    assert 3 * away_m[0] > abs(blob.place_m[0] - place_m[0] - 0.6)


def test_the_strength_is_that_of_a_matched_filter() -> None:
    box = box_of((0.0, 0.0), 1.0, 1.7)
    area = np.prod(box[2:] - box[:2])
    [blob] = found(box, contrast=5.0, closing_px=1)
    assert blob.strength == pytest.approx(5.0 * np.sqrt(area))


def test_what_stands_outside_the_volume_or_above_the_horizon_is_left_out() -> None:
    assert found(box_of((60.0, 0.0), 1.0, 1.7)) == []
    assert found(np.array([50, 0, 60, 3])) == []


def test_a_picture_that_differs_everywhere_has_no_blobs() -> None:
    whole = np.array([0, 0, CAMERA.width_px, CAMERA.height_px])
    assert found(whole) == []
    assert found() == []


def test_a_gap_in_a_body_is_closed() -> None:
    box = box_of((0.0, 0.0), 0.8, 1.8)
    middle = (box[1] + box[3]) // 2
    legs, head = box.copy(), box.copy()
    legs[1], head[3] = middle + 1, middle - 1
    assert len(found(legs, head, closing_px=1)) == 2
    assert len(found(legs, head, closing_px=5)) == 1


COVARIANCE_M2 = np.diag([0.6, 0.15]) ** 2
PARAMETERS = LinkParameters(start_speed_mps=1.5, acceleration_mps2=0.3, most_missed=3, least_hits=2)
WEIGHTS = np.linspace(-0.4, 0.5, len(EVIDENCE))


def blob(x_m: float, y_m: float, strength: float = 50.0, base_m: float = 0.0) -> Blob:
    [px], _ = VIEW.project(np.array([[x_m, y_m, base_m]]))
    box_xyxy = np.array([px[0] - 2, px[1] - 13, px[0] + 2, px[1]])
    return Blob(np.array([x_m, y_m, base_m]), COVARIANCE_M2, box_xyxy, np.array([0.5, 0.5, 1.7]), strength)


def test_two_people_who_pass_each_other_keep_their_identities() -> None:
    linker, rng = GroundLinker(PARAMETERS, VIEW, WEIGHTS), np.random.default_rng(0)
    met = []
    for k in range(20):
        places_m = [(0.0, -12 + 1.2 * k), (3.0, 12 - 1.2 * k)]
        noise = rng.multivariate_normal(np.zeros(2), COVARIANCE_M2, 2)
        order = rng.permutation(2)
        tracks = linker.follow([blob(*(places_m[i] + noise[i])) for i in order], 2.0 * k)
        check_tracks(tracks)
        met.append({each.identity: VIEW.place_of(each.estimate)[:2] for each in tracks})
    assert [set(each) for each in met[1:]] == [{0, 1}] * 19
    for k in (5, 19):
        y_m = [met[k][identity][1] for identity in (0, 1)]
        true_m = [-12 + 1.2 * k, 12 - 1.2 * k]
        start = met[1][0][1] > 0
        np.testing.assert_allclose(y_m, true_m[::-1] if start else true_m, atol=0.6)


def test_the_filter_is_nearer_to_the_truth_than_the_blobs() -> None:
    linker, rng = GroundLinker(PARAMETERS, VIEW, WEIGHTS), np.random.default_rng(1)
    errors_m = []
    for k in range(60):
        true_m = np.array([-10 + 0.3 * k, -9 + 0.3 * k])
        noise = rng.multivariate_normal(np.zeros(2), COVARIANCE_M2)
        for track in linker.follow([blob(*(true_m + noise))], 2.0 * k):
            errors_m.append([np.hypot(*(VIEW.place_of(track.estimate)[:2] - true_m)), np.hypot(*noise)])
    filtered_m, measured_m = np.mean(errors_m, axis=0)
    assert filtered_m < 0.9 * measured_m


def test_a_track_waits_for_its_object_and_then_ends() -> None:
    linker = GroundLinker(PARAMETERS, VIEW, WEIGHTS)
    assert linker.follow([blob(0, 0)], 0.0) == []
    [first] = linker.follow([blob(0, 0.5)], 2.0)
    for k in range(3):
        assert linker.follow([], 4.0 + 2.0 * k) == []
    [back] = linker.follow([blob(0, 2.5)], 10.0)
    assert back.identity == first.identity
    for k in range(4):
        linker.follow([], 12.0 + 2.0 * k)
    linker.follow([blob(0, 0)], 20.0)
    [new] = linker.follow([blob(0, 0)], 22.0)
    assert new.identity != first.identity


def test_an_object_far_away_is_another_one() -> None:
    linker = GroundLinker(PARAMETERS, VIEW, WEIGHTS)
    for k in range(4):
        linker.follow([blob(0, 0)], 2.0 * k)
    linker.follow([blob(0, 15)], 8.0)
    identities = [each.identity for each in linker.follow([blob(0, 15)], 10.0)]
    assert identities == [1]


def test_what_floats_is_told_where_it_floats() -> None:
    linker = GroundLinker(PARAMETERS, VIEW, WEIGHTS)
    for k in range(3):
        tracks = linker.follow([blob(-30.0, 2.0, base_m=-1.8)], 2.0 * k)
    np.testing.assert_allclose(VIEW.place_of(tracks[0].estimate), [-30.0, 2.0, -1.8 + 0.85], atol=1e-6)


def test_the_confidence_is_the_regression_on_the_evidence() -> None:
    linker = GroundLinker(PARAMETERS, VIEW, WEIGHTS)
    for k in range(5):
        tracks = linker.follow([blob(0, 1.5 * k), blob(9, -9, strength=9.0)], 2.0 * k)
    assert linker.evidence.shape == (2, len(EVIDENCE))
    for track, row in zip(tracks, linker.evidence, strict=True):
        assert track.confidence == pytest.approx(1.0 / (1.0 + np.exp(-row @ WEIGHTS)))
    moved, stayed = linker.evidence
    width = np.log(0.5 / 0.8)
    np.testing.assert_allclose(moved[:9], [1.0, np.log(50), 0, 0, 0, width, width**2, 0, np.log(5)])
    assert moved[9] == pytest.approx(np.log1p(6.0), abs=0.2)
    assert stayed[9] == pytest.approx(0.0, abs=1e-6)
    assert (moved[10], evidence_of(9.0, 0.5, 1.7, 1, 0.0, True)[10]) == (0.0, 1.0)


def test_evidence_is_finite_for_a_speck() -> None:
    assert np.isfinite(evidence_of(0.0, 0.5, 1.7, 1, 0.0, False)).all()


@pytest.mark.parametrize("time_s", [[0.0, 0.0, 0.0], [0.0, -50.0, 1e7]])
def test_odd_times_break_nothing(time_s: list[float]) -> None:
    linker = GroundLinker(PARAMETERS, VIEW, WEIGHTS)
    for each in time_s:
        check_tracks(linker.follow([blob(0, 0), blob(1, 1)], each))
