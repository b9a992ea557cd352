"""One self-contained HTML page about a data set: what it is, what it looks like, what its objects do."""

from __future__ import annotations

import base64
import io

import cv2
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from benchmarks.data.sets.card import about, card_tables
from benchmarks.data.sets.contact_sheet import LEGEND, contact_sheet
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.statistics import Statistics, statistics
from benchmarks.show.page import page_environment, page_style
from benchmarks.show.plots import drawn_as
from scenarios import catalog

PAGE = "page.html"
"""Name of the page in a data set's folder."""
_BINS = 32


def render_page(data: DataSet) -> str:
    """Return the page. Raises ValueError if the data set has no episode."""
    held = statistics(data)
    request, scenario = data.request, catalog.scenario(data.request.scenario)
    pictures = []
    if request.channels:
        sheet = cv2.imencode(".jpg", cv2.cvtColor(contact_sheet(data), cv2.COLOR_RGB2BGR))[1].tobytes()
        pictures.append((f"Frames with boxes ({LEGEND}), and the channels of one frame", _data_url("jpeg", sheet)))
    pictures.append(("Shares of frame-outs by length, of objects by size and by what is seen", _histograms(held)))
    return (
        page_environment(__file__)
        .get_template("page.html.jinja")
        .render(
            style=Markup(page_style()),
            heading=f"{request.scenario} · {request.preset}",
            summary=scenario.summary,
            preset=scenario.presets[request.preset].summary,
            about=[sentence.replace("`", "") for sentence in about(data)],
            pictures=pictures,
            tables=card_tables(data, held),
        )
    )


def _data_url(kind: str, content: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def _histograms(held: Statistics) -> str:
    """Draw the lengths of frame-outs, the sizes and the visible fractions of objects, in shares of each group."""
    told = (
        (held.frame_outs, "frames", "frames out of the picture"),
        (held.sizes, "side_px", "side of the visible box, px"),
        (held.sizes, "visible_fraction", "visible fraction"),
    )
    with drawn_as("statistics"):
        figure = Figure(figsize=(12, 3.4), layout="constrained")
        for axes, (table, name, label) in zip(figure.subplots(1, len(told)), told, strict=True):
            values = {group: each.dropna() for group, each in table.groupby("group", observed=True)[name]}
            values = {str(group): each for group, each in values.items() if len(each)}
            axes.hist(
                list(values.values()),
                _BINS,
                weights=[np.full(len(each), 100 / len(each)) for each in values.values()],
                histtype="stepfilled",
                alpha=0.4,
                label=list(values),
            )
            axes.set(xlabel=label, ylabel="%")
            if values:
                axes.legend(frameon=False)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=110)
    return _data_url("png", buffer.getvalue())
