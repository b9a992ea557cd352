"""The suite ``many``: are all targets followed, each under one identity, by their boxes?

Scenes and trackers are those of other suites; it also judges real sequences with boxes of many targets.
"""

from __future__ import annotations

from benchmarks.contract.judging import OnSequences
from benchmarks.contract.suite import Scene, Suite, register_suite
from benchmarks.judges.identities import identity_metrics, track_scores
from benchmarks.judges.many.first_boxes import FIRST_BOXES
from benchmarks.judges.many.judge import ManyJudge
from benchmarks.judges.tracker_speed import SPEED

_HEADLINE = ("hota", "idf1", "mota", "identity_switches", "frames_per_s")
_COMPARED = ("hota", "idf1", "mota")
_SEEN = "frames of targets of which some is seen, and of tracks with a box"
MANY = Suite(
    name="many",
    summary="many targets: is each followed under one identity, by its box, as MOT Challenge scores it?",
    scenes=(
        Scene("fish-tank", "fish", ("shoal_chain", "sort", "sort_appearance", "bytetrack", "first_boxes")),
        Scene("harbour", "harbour", ("harbour_watch", "eigen_swarm", "harbour_mog2", "harbour_posts", "first_boxes")),
    ),
    preset="standard",
    quick_preset="quick",
    judge=ManyJudge,
    metrics=(*identity_metrics("no overlap", "an overlap (IoU) of a half", _SEEN, track_scores), *SPEED),
    headline=_HEADLINE,
    compared=_COMPARED,
    tuned_for={"hota": 1.0, "idf1": 1.0},
    references=(FIRST_BOXES,),
    silence="no track",
    controller=None,
    follows_many=True,
    on_sequences=OnSequences(judge=ManyJudge, headline=_HEADLINE, compared=_COMPARED, silence="no track"),
)
register_suite(MANY)
