"""The part of a diagnosis's page that shows when heat is missing."""

from __future__ import annotations

from collections.abc import Sequence

from warmlink.orchestration.diagnosis.answer.missing import MissingHeat
from warmlink.orchestration.report.figures import styled
from warmlink.orchestration.report.page import Section


def heat_sections(courses: Sequence[MissingHeat]) -> list[Section]:
    """Draw the missing heat of each run, with its 95 % band."""
    from plotly.graph_objects import Figure

    sections = []
    for each in courses:
        minutes, spread = each.time / 60, 1.96 * each.deviation
        figure = Figure()
        for values, fill in ((each.heat - spread, None), (each.heat + spread, "tonexty")):
            figure.add_scatter(x=minutes, y=values, fill=fill, line_width=0, showlegend=False)
        figure.add_scatter(x=minutes, y=each.heat, line_color="#3b6fb6", showlegend=False)
        figure.update_layout(xaxis_title="time [min]", yaxis_title="missing heat [W]")
        text = f"If all that is wrong were heat into the shaft, {each.sentence}"
        sections.append(Section(f"When heat is missing: {each.run}", text, figure=styled(figure, 320)))
    return sections
