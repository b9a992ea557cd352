"""How the suite ``frame-out`` is shown."""

from __future__ import annotations

from benchmarks.show.frame_out.figures import figures
from benchmarks.show.frame_out.picture import show_frame_out
from benchmarks.show.showing import Showing

SHOWING = Showing(
    heading="What happens outside the picture",
    figures=figures,
    picture=show_frame_out,
    oracles="Oracles know the map and the car's state at the exit, and get no picture until the car is back: "
    "what they miss is hardly predictable.",
    remarks={
        "hold": "Why can hold be ahead of particle filters? It looks at every picture anew, around the place in the "
        "picture where it matched last, and takes what is most like the car there. The filters as written look where "
        "their particles are, and nothing in them searches the whole picture: one that is off the car when it leaves "
        "is hardly ever on it when it is back. Nor does hold know where the car is meanwhile: see the error outside.",
    },
)
