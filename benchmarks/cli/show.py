"""``frameout show``: make the page of a data set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import FILE, WithModules
from benchmarks.run.packages import needs_data
from benchmarks.run.result_folder import check_file
from trackers.atomic_file import write_atomic


@dataclass(frozen=True)
class Show(WithModules):
    """Make one offline HTML page about a data set: contact sheet, histograms, tables of what it holds and lacks.

    Attributes:
        directory: folder or URL written by `frameout generate`.
        out: file of the page (default: page.html in that folder).
    """

    directory: Annotated[str, tyro.conf.Positional]
    out: Annotated[Path | None, FILE] = None
    resumes = False

    def run(self) -> int:
        """Write it; return the exit status."""
        needs_data()
        # After the check, since they import these packages.
        from benchmarks.data.sets.data_set import DataSet
        from benchmarks.data.sets.page import PAGE, render_page
        from benchmarks.data.sets.places import put
        from benchmarks.data.sets.verifying import damage_told

        if self.out is not None:
            check_file(self.out, "out")
        data = DataSet(self.directory)
        with damage_told(data.root):
            page = render_page(data)
        data.close()
        if self.out is None:
            put(data.files, f"{data.root}/{PAGE}", page.encode())
            print(f"{self.directory.rstrip('/')}/{PAGE}")
        else:
            write_atomic(self.out, page)
            print(self.out)
        return 0
