"""``frameout verify``: is a data set whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from benchmarks.cli.arguments import WithModules
from benchmarks.contract.text import counted, ranges_text
from benchmarks.run.packages import needs_data
from benchmarks.show.progress import progress_bar


@dataclass(frozen=True)
class Verify(WithModules):
    """Compare the files of a data set with their checksums. Exit status 1 if an episode is damaged or missing.

    Attributes:
        directory: folder or URL of the data set, or of one of several parts.
        discard: remove damaged episodes, so that the command that made the data set makes them again.
    """

    directory: Annotated[str, tyro.conf.Positional]
    discard: bool = False
    resumes = False

    def run(self) -> int:
        """Check it; return the exit status."""
        needs_data()
        from benchmarks.data.sets.data_set import data_sets
        from benchmarks.data.sets.verifying import discard, problems

        status = 0
        for data in data_sets(self.directory):
            with progress_bar(f"verify {data.url}") as progress:
                found = list(problems(data, progress))
            for problem in found:
                print(problem)
            if not found:
                print(f"{data.url}: {counted(len(data.seeds), 'episode')}, {len(data)} frames, all whole")
                if not data.is_listed:
                    print(f"to be listed: frameout merge {data.url}")
                for seed, why in data.left_out.items():
                    print(f"left out: seed {seed}: {why}")
                continue
            status = 1
            seeds = [problem.seed for problem in found]
            if self.discard:
                discard(data, seeds)
                print("removed; the command that made the data set makes them again")
            else:
                print(f"{data.url}: to be made again: seeds {ranges_text(seeds)} (--discard removes them)")
        return status
