"""Our gap method: windows, regressions, steady swimming."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.gaps import Bridge, Piece, Surroundings, check_bridge
from trackers.swimmer.features import PAST, Pasts, Recording, features, whole_past
from trackers.swimmer.method import SwimGaps, steady_way
from trackers.swimmer.regression import Regression, Samples, first_fit, fitted

SIDE_PX = np.array([600.0, 400.0])
BOUNDS = np.array([0.0, 0.0, *SIDE_PX])


def swims(frames: int, count: int, seed: int, *, persistence: float = 15.0) -> list[Piece]:
    """Return tracks whose velocity decays to nothing and which are drawn to the middle of the tank."""
    rng = np.random.default_rng(seed)
    kept = np.exp(-1 / persistence)
    x, v = rng.uniform(0.2, 0.8, (count, 2)) * SIDE_PX, np.zeros((count, 2))
    way = np.zeros((frames, count, 2))
    for t in range(frames):
        v = kept * v + 0.8 * rng.normal(size=(count, 2)) - 0.0005 * (x - SIDE_PX / 2)
        x = x + v
        way[t] = x
    return [Piece(0, way[:, n], 1 / 30) for n in range(count)]


def cut(piece: Piece, first: int, end: int) -> Piece:
    return Piece(first, piece.position_px[first:end], piece.interval_s)


def mean_error_px(method: SwimGaps, pieces: list[Piece], ahead: int) -> float:
    errors = []
    for piece in pieces:
        for t in range(PAST, len(piece.position_px) - ahead, 50):
            bridge = method.extrapolate(cut(piece, t - PAST, t), ahead, Surroundings(BOUNDS))
            errors.append(np.hypot(*(bridge.position_px[-1] - piece.position_px[t + ahead - 1])))
    return float(np.mean(errors))


def same(a: Bridge, b: Bridge, sign: np.ndarray, shift: np.ndarray) -> None:
    np.testing.assert_allclose(a.position_px * sign + shift, b.position_px, atol=1e-6)
    np.testing.assert_allclose(a.covariance_px, b.covariance_px, rtol=1e-6)


@pytest.mark.parametrize("sign", [(-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_a_mirrored_tank_gives_mirrored_answers(sign: tuple[float, float]) -> None:
    method = SwimGaps()
    (piece,) = swims(300, 1, 0)
    heading = np.linspace(0.0, 1.0, 300)
    line = piece.position_px[:, None] + np.array([[5.0, 1.0], [0.0, 0.0], [-4.0, 3.0]])
    flip, shift = np.array(sign), np.where(np.array(sign) < 0, SIDE_PX, 0.0)
    turned = np.arctan2(flip[1] * np.sin(heading), flip[0] * np.cos(heading))
    mirrored = Piece(0, piece.position_px * flip + shift, 1 / 30, turned, line * flip + shift)
    whole = Piece(0, piece.position_px, 1 / 30, heading, line)

    def part(of: Piece, first: int, end: int) -> Piece:
        assert of.heading_rad is not None
        assert of.centre_line_px is not None
        where = slice(first, end)
        return Piece(first, of.position_px[where], 1 / 30, of.heading_rad[where], of.centre_line_px[where])

    around = Surroundings(BOUNDS)
    a, b = (method.extrapolate(part(each, 0, 100), 120, around) for each in (whole, mirrored))
    same(a, b, flip, shift)
    a, b = (method.interpolate(part(each, 0, 100), part(each, 150, 300), around) for each in (whole, mirrored))
    same(a, b, flip, shift)


def test_time_reversed_is_the_same_way_between() -> None:
    method = SwimGaps()
    (piece,) = swims(300, 1, 4)
    back = Piece(0, piece.position_px[::-1].copy(), 1 / 30)
    forth = method.interpolate(cut(piece, 0, 120), cut(piece, 180, 300), Surroundings(BOUNDS))
    reverse = method.interpolate(cut(back, 0, 120), cut(back, 180, 300), Surroundings(BOUNDS))
    np.testing.assert_allclose(forth.position_px, reverse.position_px[::-1], atol=1e-6)


@pytest.mark.heavy
def test_what_is_learnt_helps_and_the_region_holds_its_share() -> None:
    method, known = SwimGaps(), swims(4000, 4, 1)
    new = swims(2000, 4, 2)
    before = mean_error_px(method, new, 50)
    method.learn(known)
    assert mean_error_px(method, new, 50) < 0.97 * before
    inside = []
    for piece in new:
        for t in range(PAST, 1900, 20):
            bridge = method.extrapolate(cut(piece, t - PAST, t), 50, Surroundings(BOUNDS))
            error = bridge.position_px[-1] - piece.position_px[t + 49]
            inside.append(error @ np.linalg.solve(bridge.covariance_px[-1], error) < -2 * np.log(0.05))
    assert 0.91 < np.mean(inside) < 0.985


def test_learning_again_from_nothing_forgets() -> None:
    method, fresh = SwimGaps(), SwimGaps()
    (piece,) = swims(1500, 1, 3)
    past = cut(piece, 0, 100)
    first = fresh.extrapolate(past, 100, Surroundings(BOUNDS)).position_px
    method.learn([piece])
    assert np.abs(method.extrapolate(past, 100, Surroundings(BOUNDS)).position_px - first).max() > 1.0
    method.learn([])
    np.testing.assert_array_equal(method.extrapolate(past, 100, Surroundings(BOUNDS)).position_px, first)


def test_posture_counts_only_where_it_is_allowed() -> None:
    (piece,) = swims(100, 1, 5)
    seen = Piece(0, piece.position_px, 1 / 30, np.full(100, 2.0))
    around = Surroundings(BOUNDS)
    without = SwimGaps(posture=False).extrapolate(seen, 30, around).position_px
    np.testing.assert_array_equal(without, SwimGaps().extrapolate(piece, 30, around).position_px)
    assert np.abs(without - SwimGaps().extrapolate(seen, 30, around).position_px).max() > 0.1


@pytest.mark.heavy
@settings(max_examples=40, deadline=None)
@given(st.integers(1, 130), st.integers(1, 130), st.integers(1, 250), st.data())
def test_every_piece_with_a_measurement_is_answered(before: int, after: int, count: int, data: st.DataObject) -> None:
    rng = np.random.default_rng(data.draw(st.integers(0, 9)))
    scale = data.draw(st.sampled_from([0.0, 1e-3, 5.0]))
    x = 100.0 + np.cumsum(scale * rng.normal(size=(before + count + after, 2)), axis=0)
    known = rng.random(len(x)) < data.draw(st.sampled_from([0.1, 0.7, 1.0]))
    known[[0, -1]] = True
    x[~known] = np.nan
    past, future = Piece(3, x[:before], 1 / 30), Piece(3 + before + count, x[before + count :], 1 / 30)
    around = Surroundings(data.draw(st.sampled_from([None, BOUNDS, np.array([90.0, 90.0, 90.0, 90.0])])))
    method = SwimGaps()
    check_bridge(method.extrapolate(past, count, around), count)
    check_bridge(method.interpolate(past, future, around), count)


def test_a_still_fish_stays_where_it_is_between_two_pieces() -> None:
    still = np.tile([300.0, 200.0], (100, 1))
    bridge = SwimGaps().interpolate(Piece(0, still, 1 / 30), Piece(130, still, 1 / 30), Surroundings(BOUNDS))
    np.testing.assert_allclose(bridge.position_px, still[:30], atol=1.0)


def test_pieces_with_holes_and_jumps_are_learnt_from() -> None:
    pieces = swims(900, 2, 6)
    pieces[0].position_px[300:320] = np.nan
    pieces[1].position_px[500:] += 200.0
    windows = Recording([*pieces, Piece(4, np.full((5, 2), np.nan), 1 / 30)]).windows(50, 0)
    steps = np.linalg.norm(np.diff(np.concatenate([windows.pasts.position_px, windows.gap_px], axis=1), axis=1), axis=2)
    assert 50 < len(steps) < 2 * 75
    assert steps.max() < 20.0
    SwimGaps().learn(pieces)


def test_a_short_past_is_continued_backwards() -> None:
    x = np.array([[0.0, 0.0], [np.nan, np.nan], [2.0, 1.0], [np.nan, np.nan]])
    past, pause = whole_past(Piece(0, x, 1.0))
    assert pause == 1
    np.testing.assert_allclose(past, np.arange(3.0 - PAST, 3.0)[:, None] * [1.0, 0.5])


def test_a_past_without_measurement_is_refused() -> None:
    with pytest.raises(ValueError, match="past: expected at least one measured position, got none"):
        SwimGaps().extrapolate(Piece(0, np.full((4, 2), np.nan), 1 / 30), 3, Surroundings(BOUNDS))


def test_the_weights_minimise_the_mean_distance() -> None:
    rng = np.random.default_rng(7)
    F = rng.normal(size=(400, 2, 3))
    step = F @ [1.0, -2.0, 0.5] + 0.1 * rng.normal(size=(400, 2))
    step[::10] += 20.0
    ones = np.ones(400)
    samples = Samples(F, step, ones[:, None], ones, np.arange(400) % 2 == 0, 400.0)
    found = first_fit(samples)
    np.testing.assert_allclose(found.weights, [1.0, -2.0, 0.5], atol=0.05)
    error = np.linalg.norm(step - found.step(F), axis=1)
    assert np.mean(error <= found.radius(samples.scales)) == pytest.approx(0.95, abs=0.01)
    # The prior holds without samples to speak of, and gives way to many.
    prior = Regression(np.array([3.0, 0.0, 0.0]), np.array([1.0]))
    few = Samples(F[:2], step[:2], ones[:2, None], ones[:2] * 1e-3, np.array([True, False]), 1e-3)
    np.testing.assert_allclose(fitted(few, prior).weights, prior.weights, atol=0.05)
    np.testing.assert_allclose(fitted(samples, prior).weights, [1.0, -2.0, 0.5], atol=0.15)


def test_features_of_either_axis_are_the_same() -> None:
    (piece,) = swims(PAST, 1, 8)
    x = piece.position_px[None]
    square = np.array([[0.0, 0.0, 600.0, 600.0]])
    a = features(Pasts(x, square, np.full((1, 2), 200.0), np.zeros((1, 3))), np.array([20.0]))
    b = features(Pasts(x[..., ::-1], square, np.full((1, 2), 200.0), np.zeros((1, 3))), np.array([20.0]))
    np.testing.assert_allclose(a, b[:, :, ::-1], atol=1e-12)


def test_one_that_does_not_learn_stays_as_shipped() -> None:
    around, seen = Surroundings(BOUNDS), swims(100, 1, 5)[0]
    fresh, fixed, taught = SwimGaps(), SwimGaps(learns=False), SwimGaps()
    for method in (fixed, taught):
        method.learn(swims(3000, 3, 4))
    ways = [method.extrapolate(seen, 50, around).position_px for method in (fresh, fixed, taught)]
    np.testing.assert_array_equal(ways[0], ways[1])
    assert np.abs(ways[2] - ways[0]).max() > 1.0


AHEAD = np.arange(1.0, 201.0)


def curve(t: NDArray[np.float64], speed_px: float, bend_px: float) -> NDArray[np.float64]:
    """Return places (T, 2) at constant speed along x, and off it by ``bend_px`` 100 frames from frame 0."""
    return np.stack([50.0 + speed_px * t, 80.0 + bend_px * (t / 100.0) ** 2], axis=1)


def past(speed_px: float, bend_px: float, noise_px: float, seed: int) -> NDArray[np.float64]:
    x = curve(np.arange(-99.0, 1.0), speed_px, bend_px)
    return x + noise_px * np.random.default_rng(seed).normal(size=x.shape)


def test_a_straight_way_goes_on() -> None:
    way = steady_way(past(0.15, 0.0, 0.0, 0), AHEAD, 0.1)
    np.testing.assert_allclose(way.place_px, curve(AHEAD, 0.15, 0.0), atol=1e-6)
    assert way.weight == pytest.approx(1.0)


def test_a_bend_goes_on() -> None:
    way = steady_way(past(0.15, 0.5, 0.0, 0), AHEAD, 0.1)
    error_px = np.linalg.norm(way.place_px - curve(AHEAD, 0.15, 0.5), axis=1)
    # Without the bend it would be 4.
    assert error_px[-1] == pytest.approx(0.0, abs=0.2)
    assert way.weight > 0.99


@given(st.floats(-np.pi, np.pi), st.booleans(), st.integers(0, 100))
def test_it_turns_and_mirrors_with_the_past(angle: float, mirrored: bool, seed: int) -> None:
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    x = past(0.3, 0.8, 0.3, seed)
    first, second = steady_way(x, AHEAD, 0.3), steady_way(x @ turn.T, AHEAD, 0.3)
    np.testing.assert_allclose(second.place_px, first.place_px @ turn.T, atol=1e-6)
    np.testing.assert_allclose(second.radius_px, first.radius_px, rtol=1e-6)
    assert second.weight == pytest.approx(first.weight)


def test_with_noise_it_errs_less_than_constant_acceleration_and_its_region_holds() -> None:
    errors_px, accelerated_px, inside = [], [], []
    t = np.arange(-99.0, 1.0)
    for seed in range(200):
        x = past(0.15, 0.3, 0.3, seed)
        way = steady_way(x, AHEAD, 0.3)
        true = curve(AHEAD, 0.15, 0.3)[[49, 199]]
        errors_px.append(np.linalg.norm(way.place_px[[49, 199]] - true, axis=1))
        parabola = np.polynomial.polynomial.polyfit(t, x, 2)
        ahead = np.polynomial.polynomial.polyval(AHEAD[[49, 199]], parabola).T
        accelerated_px.append(np.linalg.norm(ahead - true, axis=1))
        inside.append(errors_px[-1] <= way.radius_px[[49, 199]])
        assert way.weight > 0.9
    assert (np.mean(errors_px, axis=0) < 0.85 * np.mean(accelerated_px, axis=0)).all()
    assert (np.mean(inside, axis=0) > 0.9).all()


def test_a_fish_that_turns_and_darts_is_not_steady() -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        heading = np.cumsum(0.15 * rng.normal(size=100))
        steps = 3.0 * np.exp(0.5 * rng.normal(size=100))[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        assert steady_way(np.cumsum(steps, axis=0), AHEAD, 0.3).weight < 0.1
