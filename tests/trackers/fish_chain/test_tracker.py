"""The whole chain on drawn tanks: names are kept, answers keep their contract, odd pictures do no harm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from tests.trackers.fish_chain.drawn_tank import Tank
from tests.trackers.fish_chain.steady import Steady
from trackers.estimate_check import check_tracks
from trackers.fish_chain.fish import Fish
from trackers.fish_chain.tracker import Chain, ChainParameters
from trackers.registry import entry
from trackers.types import CameraModel, Observation, Track

FRAMES = 150


def identity_f1(answers: Sequence[Sequence[Track]], places: Sequence[np.ndarray], radius_px: float = 15.0) -> float:
    """Return IDF1 with a match within ``radius_px``: of the best assignment of identities to fish."""
    together: Counter[tuple[int, int]] = Counter()
    for tracks, fish in zip(answers, places, strict=True):
        for track in tracks:
            away = np.linalg.norm(fish - track.estimate.position_px, axis=1)
            together.update((track.identity, int(k)) for k in np.flatnonzero(away < radius_px))
    names = sorted({name for name, _ in together})
    table = np.array([[together[name, k] for k in range(len(places[0]))] for name in names])
    rows, columns = linear_sum_assignment(-table)
    return 2 * table[rows, columns].sum() / (sum(map(len, answers)) + sum(map(len, places)))


@lru_cache
def film(seed: int) -> tuple[Tank, list[Observation], list[Observation], list[np.ndarray]]:
    tank = Tank(count=6, seed=seed)
    background = tank.background(10)
    pictures, places = [], []
    for _ in range(FRAMES):
        pictures.append(tank.draw())
        places.append(tank.positions_px.copy())
    return tank, background, pictures, places


def run(chain: Chain, seed: int) -> tuple[list[list[Track]], list[list[Track]]]:
    tank, background, pictures, _ = film(seed)
    chain.start(background, tank.camera)
    answers = [chain.update(each) for each in pictures]
    for tracks in answers:
        check_tracks(tracks)
    revised = chain.revised()
    for tracks in revised:
        check_tracks(tracks)
    return answers, revised


@pytest.mark.heavy
@pytest.mark.parametrize("offline", [False, True])
def test_fish_keep_their_names(offline: bool) -> None:
    at_once, revised = [], []
    for seed in (0, 1):
        answers, later = run(Chain(ChainParameters(offline=offline), Steady()), seed)
        places = film(seed)[3]
        assert len(answers) == len(later) == FRAMES
        at_once.append(identity_f1(answers, places))
        revised.append(identity_f1(later, places))
    assert np.mean(revised) > 0.95
    assert np.mean(at_once) > 0.9


@pytest.mark.heavy
def test_posture_and_looks_help() -> None:
    scores = {}
    for name, changes in (("all", {}), ("places", {"use_appearance": False, "use_posture": False})):
        scores[name] = [
            identity_f1(run(Chain(ChainParameters(**changes), Steady()), seed)[1], film(seed)[3]) for seed in (0, 1, 2)
        ]
    assert np.mean(scores["all"]) > np.mean(scores["places"])


def told(tracks: Sequence[Track]) -> dict[int, tuple[float, ...]]:
    """Return what is said of a frame: by identity, place, box, heading and confidence."""
    said = {}
    for each in tracks:
        estimate = each.estimate
        assert estimate.box_xyxy is not None
        said[each.identity] = (*estimate.position_px, *estimate.box_xyxy, estimate.heading_rad or 0.0, each.confidence)
    return said


@pytest.mark.heavy
def test_the_past_is_not_changed_after_the_delay() -> None:
    """The answers of two runs, one of which goes on for longer, are the same but for the last frames."""
    tank, background, pictures, places = film(1)
    delay, gone = ChainParameters().delay, range(50, 95)
    hidden = []
    for k, picture in enumerate(pictures):
        image = picture.image_rgb.copy()
        if k in gone:
            x, y = places[k][0].astype(int)
            image[max(y - 25, 0) : y + 25, max(x - 25, 0) : x + 25] = pictures[0].image_rgb[:1, :1]
        hidden.append(replace(picture, image_rgb=image))
    runs = []
    for count in (80, 100, 120, FRAMES):
        chain = Chain(ChainParameters(), Steady())
        chain.start(background, tank.camera)
        for each in hidden[:count]:
            chain.update(each)
        runs.append((count, [told(tracks) for tracks in chain.revised()]))
    _, longest = runs[-1]
    for count, said in runs:
        assert len(said) == count
        assert said[: count - delay] == longest[: count - delay]
    assert any(first != second for (_, said) in runs[:-1] for first, second in zip(said, longest, strict=False))


@pytest.mark.heavy
def test_between_two_tracklets_a_fish_is_where_both_ends_say() -> None:
    """However long it is seen afterwards."""
    tank = Tank(count=1, seed=4, speed_px=1.5)
    background, pictures, places = tank.background(10), [], []
    for _ in range(220):
        pictures.append(tank.draw())
        places.append(tank.positions_px[0].copy())
    for k in range(60, 70):
        pictures[k] = background[0]
    for offline in (False, True):
        chain = Chain(ChainParameters(offline=offline, least_certainty=0.1), Steady())
        chain.start(background, tank.camera)
        for each in pictures:
            chain.update(each)
        answers = chain.revised()
        for k in range(60, 70):
            (track,) = answers[k]
            share = (k - 59) / 11
            between_px = places[59] + share * (places[70] - places[59])
            np.testing.assert_allclose(track.estimate.position_px, between_px, atol=3.0)


@pytest.mark.heavy
def test_offline_no_guess_from_while_the_pictures_came_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fish that came back within the delay had a guess, which the links of the whole video need not contain."""
    tank, background, pictures, _ = film(1)
    hidden = [background[0] if 80 <= k < 90 else picture for k, picture in enumerate(pictures[:100])]
    chain = Chain(ChainParameters(offline=True), Steady())
    chain.start(background, tank.camera)
    for each in hidden:
        chain.update(each)
    assert chain._guesses
    monkeypatch.setattr(chain, "_decide_all", lambda: [Fish([each]) for each in chain._tracklets])
    answers = chain.revised()
    assert len(answers) == 100
    assert not any(answers[85])


@pytest.mark.heavy
def test_a_high_limit_abstains() -> None:
    surely, always = (Chain(ChainParameters(made=made), Steady()) for made in (1.0, 0.0))
    run(surely, 1)
    run(always, 1)
    assert not any(each.made for each in surely.links)
    assert always.links
    assert all(each.made for each in always.links)
    assert all(0 <= each.probability <= 1 and each.last_frame < each.next_frame for each in always.links)


@pytest.mark.heavy
def test_the_same_pictures_get_the_same_answers() -> None:
    first, second = (run(Chain(ChainParameters(), Steady()), 0)[1] for _ in range(2))
    assert [[each.identity for each in tracks] for tracks in first] == [
        [each.identity for each in tracks] for tracks in second
    ]
    np.testing.assert_array_equal(first[-1][0].estimate.position_px, second[-1][0].estimate.position_px)


@pytest.mark.heavy
@pytest.mark.parametrize(
    "name",
    [
        "shoal_chain",
        "shoal_chain_tuned",
        "shoal_chain_offline",
        "shoal_chain_no_motion",
        "sort",
        "sort_appearance",
        "bytetrack",
        "ca_kalman",
    ],
)
def test_odd_pictures_do_no_harm(name: str) -> None:
    tracker = entry(name).create(np.random.default_rng(0))
    tank, _, pictures, _ = film(0)
    camera = CameraModel(16, 16, 10.0)
    tracker.start((), tank.camera)
    odd = [
        *pictures[:12],
        *(Observation(np.full((240, 320, 3), level, np.uint8), 1.0, tank.camera) for level in (0, 255)),
    ]
    odd += [Observation(np.zeros((16, 16, 3), np.uint8), 1.0, camera)] * 2 + tank.background(3) + pictures[12:40]
    for each in odd:
        check_tracks(tracker.update(each))
    if hasattr(tracker, "revised"):
        assert len(tracker.revised()) == len(odd)


def test_a_tank_without_fish_has_none() -> None:
    tank = Tank(count=0, seed=2)
    chain = Chain(ChainParameters(), Steady())
    chain.start((), tank.camera)
    assert not any(chain.update(tank.draw()) for _ in range(40))
    assert chain.revised() == [[]] * 40
