"""Data sets on which benchmarks run in place of rendered episodes; their scores are the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from benchmarks.data.sets.channels import LOSSY, NORMALS, PICTURES, coding_of
from benchmarks.data.sets.data_set import DataSet, stored_episode
from benchmarks.data.sets.request import Request, existing_channels
from benchmarks.run.editions import package_versions, preset_edition
from benchmarks.run.episodes import EpisodeSpec, Simulated
from scenarios.scenario import Episode
from scenarios.truth import TruthExtent
from sim.checks import check


def benchmark_of(data: str) -> Request:
    """Return what a data set is of, if scores on it are those of the rendered benchmark.

    Raises:
        ValueError: for a data set that is lossy, incomplete, or of another edition.
    """
    stored = DataSet(data)
    request = stored.request
    check("data", request.background, "a set with background pictures", "one that was made with --no-background")
    lossy = [c for c in PICTURES if c in request.channels and coding_of(c, request.pictures) == LOSSY]
    check("data", not lossy, "pictures without loss", f"{request.pictures} for {', '.join(lossy)}")
    gone = sorted(set(range(*request.seeds)) - set(stored.seeds))
    check("data", not gone, "a whole data set", f"one without {len(gone)} episodes; `frameout generate` makes them")
    # No judge reads normals; of the others, each may be read by one.
    missing = [each for each in existing_channels(request) if each not in (*request.channels, NORMALS)]
    check("data", not missing, "a set with all channels", f"one without {', '.join(missing)}")
    made, now = request.scene, preset_edition(request.scenario, request.preset)
    check("data", made == now, f"one of the scene's present edition, {now}", f"one of {made}")
    differ = [name for name, version in package_versions().items() if request.packages.get(name, version) != version]
    check("data", not differ, "one made with the installed packages", f"one with another {', '.join(differ)}")
    return request


@dataclass(frozen=True)
class Stored(Simulated):
    """See ``EpisodeSpec``: a rendered episode that a data set holds.

    Attributes:
        url: folder or URL of the data set.
    """

    url: str = ""

    def open(self, truth: TruthExtent) -> Episode:
        """See ``EpisodeSpec``."""
        return stored_episode(self.url, self.seed)


def stored_specs(url: str, rendered: Sequence[Any]) -> list[EpisodeSpec]:
    """Return the stored episodes of a data set in place of ``Simulated`` ones."""
    return [Stored(**{each.name: getattr(one, each.name) for each in fields(one)}, url=url) for one in rendered]
