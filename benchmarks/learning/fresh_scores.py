"""What tuned values are worth on fresh episodes, which decided nothing about them.

The score of a search is the best of many trials on few episodes, so it is partly luck; that of the check chose between
two settings. A file of tuned values therefore says on how many ``episodes`` they were searched for, and under ``fresh``
what they and the written ones score on others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

ScoresOn = Callable[[dict[str, dict[str, Any]], range], dict[str, float]]
"""Returns the score of each of the labelled settings on the episodes of these seeds."""
_FIRST_SEED, _FEWEST = 9_000, 8
NO_VALUES = "no values take the place of the written ones"


@dataclass(frozen=True)
class FreshScores:
    """Scores on fresh episodes, see ``tracker_tuning.score_of``.

    Attributes:
        seeds: of the episodes. written, tuned: score of the written values and of the tuned ones.
    """

    seeds: range
    written: float
    tuned: float


def fresh_scores(
    tuned: Mapping[str, Any],
    written: Mapping[str, Any],
    searched: range,
    scores_on: ScoresOn,
    count: int | None = None,
) -> FreshScores | None:
    """Return the scores on ``count`` episodes of each preset of the search, seed 9,000 and following.

    Args:
        tuned, written: values of the parameters. searched: seeds of the search.
        count: None = as many as the search had, at least 8.

    Returns:
        None without tuned values.
    """
    if not tuned:
        return None
    seeds = range(_FIRST_SEED, _FIRST_SEED + (count or max(len(searched), _FEWEST)))
    scores = scores_on({"written": dict(written), "tuned": {**written, **tuned}}, seeds)
    return FreshScores(seeds, scores["written"], scores["tuned"])


def fresh_entries(fresh: FreshScores | None) -> dict[str, Any]:
    """Return what a file of tuned values says of them: ``fresh``, or null and under ``no_fresh`` why."""
    if fresh is None:
        return {"fresh": None, "no_fresh": NO_VALUES}
    seeds = f"{fresh.seeds.start}:{fresh.seeds.stop}"
    return {"fresh": {"seeds": seeds, "written": round(fresh.written, 6), "tuned": round(fresh.tuned, 6)}}


def scored_anew(
    document: Mapping[str, Any],
    written: Mapping[str, Any],
    searched: range,
    scores_on: ScoresOn,
    count: int | None = None,
) -> dict[str, Any]:
    """Return a file of tuned values with the scores that its values have now, on the search's seeds and fresh ones.

    Scenes and trackers may have changed since the search: the scores of the check, which chose then, go. Without tuned
    values the best trial's are not known, so that all its scores stay.
    """
    tuned = document["parameters"]
    gone, scores = {"fresh", "no_fresh"}, {}
    if tuned:
        found = scores_on({"tuned": {**written, **tuned}, "written": dict(written)}, searched)
        scores = {"score": round(found["tuned"], 6), "default_score": round(found["written"], 6)}
        gone |= {"check_score", "check_default_score"}
    kept = {key: value for key, value in document.items() if key not in gone}
    episodes = len(document["preset"].split()) * len(searched)
    return {
        **kept,
        **scores,
        "episodes": episodes,
        **fresh_entries(fresh_scores(tuned, written, searched, scores_on, count)),
    }
