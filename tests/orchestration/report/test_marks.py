"""Pages say the same of every controller, and of one's own cell nothing that holds for the paper's only."""

import re
from pathlib import Path

import warmlink.orchestration.api as wl
from warmlink.orchestration.closed_loop.load import load_scenario, read_scenario
from warmlink.orchestration.products.compare import compare
from warmlink.orchestration.report.comparison import write_comparison


def test_no_compensation_beyond_tolerance_is_marked_as_any_controller(tmp_path: Path) -> None:
    comparison = compare(["lag"], ["stop_and_go"], ["nominal"])
    path = tmp_path / "report.html"
    write_comparison(comparison, path)
    for name in ("none", "lag"):
        assert comparison.row(name, "stop_and_go").beyond_tolerance
        assert re.search(
            rf"<tr><td>{name}</td>(<td>[^<]*</td>)*<td>beyond tolerance</td></tr>", path.read_text("utf-8")
        )


def test_what_is_said_of_a_duty_cycle_is_not_said_of_ones_own_link() -> None:
    given = (
        'duty = "windshield_wiper"\n[parameters]\n"link.length" = "800 mm"\n"link.tip_position" = "780 mm"\n'
    )
    about = read_scenario("mine", given).about
    assert about.startswith("Duty cycle windshield_wiper: ")
    for text in (about, load_scenario("windshield_wiper").about):
        assert "the link swings" not in text
        assert "the paper's moving case without its pad, whose link then moves" in " ".join(text.split())
    assert wl.run("windshield_wiper", stop="1 min").scenario.about == load_scenario("windshield_wiper").about
