"""Scores of links over gaps: precision, share made, recall; by length, number of fish, crossing and confidence."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from benchmarks.contract.judging import Score
from benchmarks.judges.fish.links import Link, Outcome

SHARE = 0.9
"""Share of all gaps over which links are compared at the same number of links."""
_GROUPS: dict[str, Callable[[Link], bool]] = {
    "50": lambda link: link.gap.length_frames <= 50,
    "200": lambda link: link.gap.length_frames <= 200,
    "crossing_50": lambda link: link.gap.crosses and link.gap.length_frames <= 50,
    "touching_50": lambda link: not link.gap.crosses and link.gap.length_frames <= 50,
    "pair_50": lambda link: link.gap.fish_count <= 2 and link.gap.length_frames <= 50,
    "crowd_50": lambda link: link.gap.fish_count > 2 and link.gap.length_frames <= 50,
}
LENGTHS = ("50", "200")
"""Groups by length alone."""
GROUPS = tuple(_GROUPS)
"""Names of groups of gaps: at most 50 and 200 frames; of the former those in which centre lines cross or not, and with
two or more fish."""


def link_scores(links: Sequence[Link], ending: str = "", groups: Sequence[str] = GROUPS) -> Iterator[Score]:
    """Yield the scores of the ``groups`` of gaps; ``ending`` is added to the names.

    ``link_precision_GROUP``: right links of those made. ``link_rate_GROUP``: links made, of all gaps.
    ``link_recall_GROUP``: right links, of all gaps. ``link_precision_GROUP_of_90``: see ``precision_at``.
    """
    for name in groups:
        own = [link for link in links if _GROUPS[name](link)]
        outcomes = [link.outcome for link in own]
        right, wrong = outcomes.count(Outcome.RIGHT), outcomes.count(Outcome.WRONG)
        if right + wrong:
            yield Score(f"link_precision_{name}{ending}", right / (right + wrong), float(right + wrong))
        if own:
            count = float(len(own))
            yield Score(f"link_rate_{name}{ending}", (right + wrong) / count, count)
            yield Score(f"link_recall_{name}{ending}", right / count, count)
            yield Score(f"link_precision_{name}_of_90{ending}", precision_at(own), SHARE * count)


def link_events(links: Sequence[Link]) -> Iterator[Score]:
    """Yield for each gap ``link_made`` (1 or 0) and, if a link was made, ``link_right`` (1 or 0)."""
    for link in links:
        made = link.outcome != Outcome.ABSTAINED
        yield Score("link_made", float(made), event=link.gap)
        if made:
            yield Score("link_right", float(link.outcome == Outcome.RIGHT), event=link.gap)


def precision_at(links: Sequence[Link], share: float = SHARE) -> float:
    """Return how many of the most confident links, as many as ``share`` of all gaps, are right, as a share of them.

    So trackers that abstain more or less often are compared at the same share of links. One that makes fewer has the
    missing ones wrong. Among links of equal confidence none is preferred; a link without confidence has 0.
    """
    made = [link for link in links if link.outcome != Outcome.ABSTAINED]
    wanted = share * len(links)
    sure = np.array([np.nan_to_num(link.confidence) for link in made])
    right = np.array([link.outcome == Outcome.RIGHT for link in made], dtype=float)
    total, left = 0.0, wanted
    for level in np.unique(sure)[::-1]:
        alike = right[sure == level]
        taken = min(left, float(len(alike)))
        total += taken * float(alike.mean())
        left -= taken
    return total / wanted
