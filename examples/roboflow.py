# /// script
# dependencies = ["trackers==2.6.0"]
# ///
"""SORT, ByteTrack and OC-SORT of roboflow's package ``trackers``, as published, on the detections of our own ``sort``.

Its import name is that of one of our packages, so it runs in a process with an environment of its own, made on first
use, which takes boxes and returns identities::

    frameout bench fish --modules examples/roboflow.py --preset quick --seeds 0:2 --out results/roboflow \\
        --trackers roboflow_sort roboflow_bytetrack roboflow_ocsort sort bytetrack
"""

import os
import sys
from pathlib import Path

import numpy as np

KINDS = {"roboflow_sort": "SORTTracker", "roboflow_bytetrack": "ByteTrackTracker", "roboflow_ocsort": "OCSORTTracker"}


class Identities:
    """In the other process: names boxes, each x_min, y_min, x_max, y_max and score."""

    def __init__(self, parameters, rng):
        import trackers

        self._tracker = getattr(trackers, sys.argv[1])()

    def start(self, background, camera):
        """Begin a video."""

    def update(self, boxes):
        """Return pairs (K, 2) of the place of a box among those of a picture (N, 5), and its identity."""
        import supervision

        found = {"confidence": boxes[:, 4], "data": {"place": np.arange(len(boxes))}}
        tracked = self._tracker.update(supervision.Detections(boxes[:, :4].copy(), **found))
        if not len(tracked) or tracked.tracker_id is None:
            return np.empty((0, 2), int)
        pairs = np.column_stack([tracked.data["place"], tracked.tracker_id])
        return pairs[pairs[:, 1] >= 0]


def offer():
    """Register a tracker for each of ``KINDS``."""
    from trackers.baselines.sort import FollowsDetections, track_of
    from trackers.clients.environments import made_environment
    from trackers.clients.remote import Program, remote_tracker
    from trackers.registry import NoParameters, register

    class Roboflow(FollowsDetections):
        Parameters = NoParameters
        kind = ""

        def _begin(self, background):
            super()._begin(background)
            program = Program((str(made_environment(Path(__file__))), __file__, self.kind))
            self._remote = remote_tracker(program, {}, np.random.default_rng(0))

        @property
        def elsewhere_cpu_s(self):
            return self._remote.elsewhere_cpu_s

        def follow(self, detections):
            boxes = np.array([[*each.box_xyxy, each.score] for each in detections], float).reshape(-1, 5)
            return [track_of(int(each), detections[place]) for place, each in self._remote.update(boxes)]

    for name, kind in KINDS.items():
        how = {"role": "external", "summary": f"{kind} of roboflow's trackers on our detections", "suites": ("fish",)}
        register(name, **how)(type(name, (Roboflow,), {"kind": kind}))


if "FRAMEOUT_PIPE" in os.environ:
    from frameout_client import serve

    serve(Identities)
else:
    offer()
