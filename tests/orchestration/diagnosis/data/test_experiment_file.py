"""What an experiment file says is used, or it is said that it is not: labels, bounds, `adapt`."""

from pathlib import Path

import numpy as np
import pytest

from warmlink.fmus.errors import InputError
from warmlink.orchestration.diagnosis.answer.profile import calibration
from warmlink.orchestration.diagnosis.data.experiment import calibrating
from warmlink.orchestration.diagnosis.data.experiment_file import PER_RUN
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.diagnosis.fit.fitting import Fitter
from warmlink.orchestration.diagnosis.fit.noise import NoiseModel
from warmlink.orchestration.diagnosis.fit.problem import Problem
from warmlink.orchestration.diagnosis.practice.hidden_terms import hidden_term
from warmlink.orchestration.diagnosis.practice.hide import hide, write_csv
from warmlink.orchestration.scenarios.duties.duty import Segment

START = '"motor.initial_winding_temperature" = { min = "0 degC", max = "90 degC", start = "%s" }'


def motor(folder: Path, *runs: str, rest: str = "") -> Path:
    """An experiment on a motor by itself: a winding of 60 J/K before a shaft of 400 J/K, both warm."""
    time = np.arange(0.0, 1800.0, 10.0)
    power, winding, shaft, read_out = 20.0, 45.0, 38.0, []
    for t in np.arange(0.0, 1800.0):
        if t % 10 == 0:
            read_out.append((winding, shaft))
        between = 2.0 * (winding - shaft)
        winding += ((power if t < 900 else 0.0) - between) / 60
        shaft += (between - 0.6 * (shaft - 22)) / 400
    random = np.random.default_rng(len(runs))
    for name in ("a", "b"):
        readings = np.array(read_out) + random.normal(0, 0.05, (time.size, 2))
        columns = {
            "time [s]": time,
            "current [A]": np.where(time < 900, np.sqrt(power), 0.0),
            "ambient_temperature [degC]": np.full(time.size, 22.0),
            "wind [degC]": readings[:, 0],
            "body [degC]": readings[:, 1],
        }
        write_csv(columns, folder / f"{name}.csv")
    text = 'system = "BenchMotor"\n'
    text += "".join(
        f'[[run]]\ndata = "{run}.csv"\n{more}\n' for run, _, more in (r.partition(":") for r in runs)
    )
    text += '[channels]\nwind = "motor.winding_temperature"\nbody = "motor.shaft_temperature"\n'
    text += '[known]\n"motor.joint_conductance" = "0 W/K"\n"motor.winding_resistance" = "1 Ohm"\n'
    text += '"motor.winding_temperature_coefficient" = "0 1/K"\n"motor.winding_heat_capacity" = "60 J/K"\n'
    text += '"motor.shaft_heat_capacity" = "400 J/K"\n"motor.winding_conductance" = "2 W/K"\n'
    text += '"motor.housing_conductance" = "0.6 W/K"\n"motor.initial_shaft_temperature" = "38 degC"\n'
    path = folder / "motor.toml"
    path.write_text(text + rest)
    return path


def test_a_cause_may_differ_from_run_to_run_without_a_label(tmp_path: Path) -> None:
    experiment = read([motor(tmp_path, "a", "b", rest='[causes]\nper = ["run"]\n')])
    assert experiment.cause_labels == (PER_RUN,)


def test_a_temperature_is_told_in_the_unit_of_its_bounds(tmp_path: Path) -> None:
    rest = "[calibrate]\n" + START % "22 degC"
    found = diagnose_experiment(calibrating(read([motor(tmp_path, "a", rest=rest)])))
    (start,) = calibration(found)
    assert (start.unit, start.value) == ("degC", pytest.approx(45.0, abs=0.2))
    assert start.low95 < start.value < start.high95
    with pytest.raises(InputError, match="start 95 degC lies outside 0 degC to 90 degC"):
        read([motor(tmp_path, "a", rest="[calibrate]\n" + START % "95 degC")])


@pytest.mark.parametrize(
    ("run", "more", "said"),
    [
        ('b:adapt = "5 min"', "", "b: adapt = 300 s changes nothing, as the whole run is fitted"),
        ('b:adapt = "5 min"\nheldout = true', "", "b: adapt = 300 s changes nothing, as no number"),
        ('b:adapt = "5 min"\nheldout = true', 'per = "run", ', ""),
    ],
)
def test_an_adaption_that_changes_nothing_is_said(tmp_path: Path, run: str, more: str, said: str) -> None:
    rest = "[calibrate]\n" + (START % "22 degC").replace("{ ", "{ " + more)
    remarks = diagnose_experiment(calibrating(read([motor(tmp_path, "a", run, rest=rest)]))).remarks
    told = [each for each in remarks if "adapt" in each]
    assert [each.startswith(said) for each in told] == [True] * bool(said)


def test_a_run_adapts_its_start_whether_that_is_an_offset_or_a_value(tmp_path: Path) -> None:
    """The start of the held-out run is 23 K warmer than the one that is given."""
    fitted = "[calibrate]\n" + (START % "22 degC").replace("{ ", '{ per = "run", ')
    free = '[calibrate]\n"motor.housing_conductance" = { min = "0.1 W/K", max = "3 W/K", start = "1 W/K" }\n'
    for rest in (fitted, free):  # in the second case both starts are off by what the first readings say
        runs = "a", 'b:adapt = "5 min"\nheldout = true'
        found = diagnose_experiment(calibrating(read([motor(tmp_path, *runs, rest=rest)])))
        assert found.held_out[0] is not None
        assert found.held_out[0].in_noise < 2


TERM = """
[term.gear]
heat = "a * speed / w * lag(speed / w, tau)"
into = "shaft"
parameters = { a = "0.1 W", w = "1 rad/s", tau = "5 min" }
[calibrate]
"gear.a" = { min = "0 W", max = "20 W" }
"""


def test_a_term_of_one_s_own_is_part_of_the_model(tmp_path: Path) -> None:
    """Its parameters are known, or calibrated, as those of any part."""
    hidden = "shaft: 2 * speed * lag(speed, 300)"
    duty = [Segment(1200.0, 2.0), Segment(1200.0)]
    write_csv(hide({}, duty, terms=[hidden_term(hidden)]), tmp_path / "run.csv")
    path = tmp_path / "experiment.toml"
    path.write_text('system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n' + TERM)
    experiment = calibrating(read([path]))
    assert not experiment.rig.in_loop
    problem = Problem(experiment)
    noise = [NoiseModel(0.4e-6 if name.endswith("elongation") else 0.08) for name in problem.variables]
    fit = Fitter(problem, noise).fit(())
    ((number, value),) = fit.values.items()
    assert number.variable == "gear.a"
    assert abs(value - 2.0) < 3 * float(fit.covariance()[0, 0]) ** 0.5 < 0.3


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('heat = "a * max(speed"', "is no expression"),
        ('heat = "a * gear_speed"', "gear_speed is neither"),
        ('heat = "a"\ncolour = 3', "colour is not known"),
        ('heat = "a * speed"', "heat is in W"),
        ('heat = "a"\ninto = "nowhere"', "nowhere"),
    ],
)
def test_a_term_that_is_none_is_refused(entry: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("time [s],speed [rad/s],tip_temperature [degC]\n0,1,20\n")
    into = "" if "into" in entry else 'into = "shaft"\n'
    path = tmp_path / "experiment.toml"
    told = f'[term.gear]\n{entry}\n{into}parameters = {{ a = "1 W" }}\n'
    path.write_text(f'system = "WarmupCell"\n[[run]]\ndata = "run.csv"\n{told}')
    with pytest.raises(InputError) as refused:
        read([path])
    assert said in str(refused.value)
    assert "experiment.toml: term" in str(refused.value)
