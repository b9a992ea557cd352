"""Episodes of a data set before they are opened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

from benchmarks.data.sets.data_set import stored_episode
from benchmarks.run.episodes import EpisodeSpec, Simulated
from scenarios.scenario import Episode
from scenarios.truth import TruthExtent


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


def stored_specs(url: str, episodes: Sequence[EpisodeSpec]) -> list[EpisodeSpec]:
    """Return the stored episodes of a data set in place of rendered ones."""
    rendered = [each for each in episodes if isinstance(each, Simulated)]
    return [Stored(**{each.name: getattr(one, each.name) for each in fields(one)}, url=url) for one in rendered]
