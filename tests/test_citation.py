"""CITATION.cff says what the package and the references say."""

from __future__ import annotations

import tomllib
from pathlib import Path

import yaml

from trackers.papers import PAPERS

ROOT = Path(__file__).parents[1]


def test_the_citation_is_of_this_package_and_of_the_papers_that_are_known_in_full() -> None:
    """Its form was checked by cffconvert, which asks for an older jsonschema than others here."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert {"cff-version", "message", "title", "authors"} <= cited.keys()
    assert (cited["version"], cited["license"]) == (project["version"], project["license"])
    assert cited["abstract"] == project["description"]
    known = [paper for paper in PAPERS.values() if paper.authors and paper.title and paper.venue]
    assert [each["title"] for each in cited["references"]] == [paper.title for paper in known]
    for reference, paper in zip(cited["references"], known, strict=True):
        names = [f"{author['given-names']} {author['family-names']}" for author in reference["authors"]]
        assert tuple(names) == paper.authors
        assert reference["number"] in paper.venue
        assert reference["date-released"][:4] == paper.date[-4:]
