"""The growth by thermometers, on a machine of other structure: written as an FMU that any tool can run."""

from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

from benchmarks.strange_machine import Demand, Machine
from warmlink.orchestration.diagnosis.diagnose import diagnose_experiment, read
from warmlink.orchestration.fmu_store import FmuStore
from warmlink.orchestration.report.diagnosis import VIRTUAL, write_diagnosis


@pytest.mark.platform
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_what_thermometers_tell_of_the_growth_is_written_as_an_fmu_and_holds_on_an_unseen_duty_cycle(
    tmp_path: Path,
) -> None:
    machine = Machine(1)
    # Hot workpieces, which no input tells of and thermometers do.
    work = [Demand(1500, 3.4, 2.5, workpiece=0.06 * (i % 3 == 1)) for i in range(9)]
    log = (
        machine.run([each for one in work for each in (one, Demand(600))], 1)
        .log()
        .drop(columns="growth [um]")
        .iloc[::60]
    )
    found = diagnose_experiment(read([log]))
    files = write_diagnosis(found, tmp_path / "out", FmuStore("native"))
    assert VIRTUAL in files
    unseen = (
        machine.run([Demand(3600, 3.0, 2.2, workpiece=0.06), Demand(1800), Demand(3600, 3.6, 2.0)], 2)
        .log()
        .iloc[::60]
    )
    named = {name.partition(" ")[0]: name for name in unseen}
    taken = [
        each.name
        for each in read_model_description(str(files[VIRTUAL])).modelVariables
        if each.causality == "input"
    ]
    assert any(name.endswith("_temperature") and name in named for name in taken)
    columns = [
        unseen[named[name]].to_numpy() + 273.15 * name.endswith("temperature")
        if name in named
        else 0.0 * time
        for time in [unseen["time [s]"].to_numpy()]
        for name in taken
    ]
    rows = np.array(
        list(zip(unseen["time [s]"], *columns, strict=True)),
        dtype=[("time", float), *((n, float) for n in taken)],
    )
    told = simulate_fmu(
        str(files[VIRTUAL]),
        start_time=rows["time"][0],
        stop_time=rows["time"][-1],
        output_interval=60.0,
        input=rows,
        output=["elongation"],
    )
    growth = np.interp(told["time"], unseen["time [s]"], unseen["growth [um]"])
    error = 1e6 * told["elongation"] - growth
    assert np.sqrt(np.mean(error[1:] ** 2)) < 0.12 * np.sqrt(np.mean(growth**2))
