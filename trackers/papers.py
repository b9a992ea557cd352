"""The four papers whose methods are here as written: the one place that holds their references.

All are in Japanese. Fields that the copies at hand do not show are empty, and ``Paper.reference`` names them.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Paper:
    """A paper, as far as its copy shows.

    Attributes:
        letter: its name in this project, A to D. package: the package of ``trackers`` with its methods as written.
        about: one line.
        authors: names; () = not on the copy. title: "" = not on the copy.
        venue: series, number and page; "" = not on the copy. date: year, or day; "" = not on the copy.
    """

    letter: str
    package: str
    about: str
    authors: tuple[str, ...] = ()
    title: str = ""
    venue: str = ""
    date: str = ""

    @property
    def name(self) -> str:
        """``paper A``."""
        return f"paper {self.letter}"

    def reference(self) -> str:
        """Return the reference in one line, with what is missing."""
        parts = [", ".join(self.authors), f"“{self.title}”" if self.title else "", self.venue, self.date]
        known = ". ".join(filter(None, parts))
        missing = [
            words
            for words, value in {"authors": self.authors, "title": self.title, "place": self.venue}.items()
            if not value
        ]
        lacks = f"Not on the copy at hand: {', '.join(missing)}." if missing else ""
        return " ".join(filter(None, [f"{known}." if known else "", lacks]))


PAPERS = {
    each.letter: each
    for each in (
        Paper(
            "A",
            "road_shape",
            "a car seen from above, tracked through frame-outs",
            ("Ryuji Nawata", "Norikazu Ikoma", "Hideaki Kawano", "Hiroshi Maeda"),
            "Robust visual tracking using background information in dynamic image including out-of-field-of-view",
            "IPSJ SIG Technical Report, Vol. 2010-CVIM-171 No. 10, Information Processing Society of Japan",
            "18 March 2010",
        ),
        Paper(
            "B",
            "light_adaptive_stereo",
            "a person followed with a stereo camera under changing light, by the camera's own settings",
        ),
        Paper(
            "C",
            "gap_kalman",
            "lost pieces of the track of a fish, bridged by a Kalman filter",
            venue="85th National Convention of the Information Processing Society of Japan, 5ZG-07, p. 4-527",
            date="2023",
        ),
        # The address was found by the abstract; what we have of that page names neither authors nor title.
        Paper(
            "D",
            "eigen_swarm",
            "intruders before a thermal camera, by eigenspaces and sets of particles",
            venue="Vol. 49 (the copy does not name the journal), "
            "https://ypir.lib.yamaguchi-u.ac.jp/on/journals/on000001/v/49/item/557",
        ),
    )
}
"""Letter -> paper."""


def paper_of(module: str) -> Paper | None:
    """Return the paper whose method a module defines, by its package; None for any other module."""
    return next((each for each in PAPERS.values() if module.startswith(f"trackers.{each.package}.")), None)
