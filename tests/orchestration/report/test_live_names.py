"""Names that a user's files give, on a page: they are text, whatever they look like."""

import importlib.util
import json
import shlex
from pathlib import Path

import pytest

from tests.browser import Browser
from warmlink.orchestration.command_line.pages import live
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.system.assemble import assemble
from warmlink.orchestration.system.write import write_ssp

SINGLE_QUOTE = "'\\''"
"""How a shell reads a quote within quotes."""

NAMES = "<img src=x onerror=globalThis.ran=1>\"&'`$(x)", "</script><script>globalThis.ran=2</script>"
"""Names of instances that a page, a file or a shell would take for something else."""

OWN_LAW = '''
from warmlink.controllers.own import Law
class score(Law):
    """<img src=x onerror=globalThis.ran=3>"""
    def correction(self, x, u, p, time):
        return 1e-7 * (u.base_temperature - 295.15)
'''


def test_names_of_a_users_files_are_text_everywhere(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip('ziglang is not installed: pip install "warmlink[live]"')
    monkeypatch.chdir(tmp_path)
    kinds = FmuStore("native").files(["LagCompensator", "MotorHeatSource", "ThermalLink"])
    motor, link = NAMES
    fmus = {"compensator": kinds["LagCompensator"], "link": kinds["ThermalLink"]}
    fmus |= {motor: kinds["MotorHeatSource"], link: kinds["ThermalLink"]}
    wires = [(f"{motor}.heat_flow", f"{link}.heat_flow")]
    wires += [(f"{link}.base_temperature", f"{motor}.link_base_temperature")]
    write_ssp(assemble("own", fmus, wires), tmp_path / "own.ssp")
    inputs = [f"{motor}.speed", f"{link}.speed", "compensator.speed"]
    lines = {"title": NAMES[0], "system": "own.ssp", "duty": "windshield_wiper", "stop_time": "5 min"}
    lines |= {"controller": "law.py:score"}
    roles = {"speed": inputs, "torque": [f"{motor}.torque"], "score": "link.elongation"}
    text = [f"{key} = {json.dumps(value)}" for key, value in lines.items()]
    text += ["[roles]", *(f"{key} = {json.dumps(value)}" for key, value in roles.items())]
    (tmp_path / "my_cell.toml").write_text("\n".join(text))
    (tmp_path / "law.py").write_text(OWN_LAW)
    live("my_cell.toml", controller=["law.py:score"])
    script = """
        const name = [...at("sliders").children].find((row) => row.id.startsWith("<img")).id;
        put({ [name]: String(1.1 * fields(name)[0].value) });
        at("search").value = "<img";
        showSliders();
        await new Promise((drawn) => setTimeout(drawn, 300));
        const read = new DOMParser().parseFromString(parameterSet(), "text/xml").querySelector("Parameter");
        const result = { name, ran: globalThis.ran ?? 0, made: document.querySelectorAll("img").length,
          read: read?.getAttribute("name"), command: commands()[0], lead: at("lead").textContent };
    """
    found = browser.browse(tmp_path / "my_cell.html", script)
    assert (found["ran"], found["made"]) == (0, 0)
    assert found["read"] == found["name"]
    setting = shlex.split(found["command"])[4]
    assert setting.startswith(found["name"] + "=")
    assert f"'{setting.replace(chr(39), SINGLE_QUOTE)}'" in found["command"], "a shell runs nothing of it"
    assert "score" in found["lead"]
