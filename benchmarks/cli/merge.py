"""``frameout merge``: make one data set of what several jobs have made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from benchmarks.cli.arguments import ONE_NAME, WithModules
from benchmarks.contract.text import counted
from benchmarks.run.packages import needs_data
from benchmarks.show.progress import progress_bar
from sim.checks import check


@dataclass(frozen=True)
class Merge(WithModules):
    """Make a data set whole that several runs of `frameout generate` have made, with different --seeds.

    If all episodes are there it writes the list of files (manifest.parquet) and the data card, once. The bytes are
    those of a single run. Folders of which each holds some of the seeds become one with --out; on one disk that takes
    no room.

    Attributes:
        directories: folder or URL of the data set, or several folders of one description.
        out: folder of what becomes of several.
    """

    directories: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(help_behavior_hint="")]
    out: Annotated[str | None, ONE_NAME] = None
    resumes = True

    def run(self) -> int:
        """Do it; return the exit status."""
        needs_data()
        check("directories", bool(self.directories), "a data set, or several folders of one", "none")
        from benchmarks.cli.data_functions import merge

        with progress_bar("merge") as progress:
            made = merge(self.directories, self.out, progress)
        for data in made:
            print(f"{data.url}: {counted(len(data.seeds), 'episode')}, {len(data)} frames")
        return 0
