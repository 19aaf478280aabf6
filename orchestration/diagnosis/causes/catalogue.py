"""The form of a cause, and the catalogue: every TOML file in this folder."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, get_args

from warmlink.fmus.plugins import plugins
from warmlink.orchestration.text_files import read_toml
from warmlink.orchestration.written.entries import Flag, Names, Number, OneOf, Text
from warmlink.orchestration.written.tables import Table, read_table

_Instrument = Literal["temperature sensor", "camera", "reading", "declared reading"]
Kind = Literal["plant", "input", "place", _Instrument, "record", "simulation"]


@dataclass(frozen=True)
class Cause(Table):
    """Something that may be missing from or wrong in the model.

    Attributes
    ----------
    name : as in the results, which add the channel after a colon where the cause belongs to an instrument
    sentence : what happens, for a technician
    frees : variables that take one common value, as `link.emissivity`; for the cause of an instrument the
        name within the instrument, as `lag`
    lower, upper : physical bounds in SI units
    looks_like, check : what it looks like in the data, and what to check on the machine
    neutral : value that changes nothing; None: the nominal value
    shown_unit : unit in which people read the value
    relative : whether the bounds are factors on the nominal value
    added : whether the value is added to each variable's own, so that the bounds are differences
    grouped : whether it may hold for the columns of one logger alone
    material : whether it is a property of the material, or a law of nature, that is the same in all runs
    each_run : whether every run has a value of its own
    covers : causes whose joint effect this one has, so that none of them is sought beside it
    twin_of : cause from which no log tells it: it is not sought, and stands beside that one where the value
        that was found is within its own bounds
    covariate : input whose column the cause needs
    at_work : whether it may change while a machine is at work, so that `watch` looks for it
    usual : whether a plain calibration of a machine, which looks for no cause, fits it
    unsought : whether that alone fits it: it is no candidate of a search, and not watched for
    declared : whether a person declared it, so that it frees exactly the variables that it names
    kind : what it belongs to; a cause of kind "simulation" is checked before all others, and not fitted
    """

    name: Annotated[str, Text("radiation")]
    sentence: Annotated[str, Text("The link's surface radiates heat.")]
    frees: Annotated[tuple[str, ...], Names("link.emissivity")]
    lower: Annotated[float, Number("bound")]
    upper: Annotated[float, Number("bound")]
    looks_like: Annotated[str, Text("the link is cooler than simulated")]
    check: Annotated[str, Text("Look at the surface.")]
    neutral: Annotated[float | None, Number("neutral value")] = None
    shown_unit: Annotated[str, Text("W/K")] = ""
    relative: Annotated[bool, Flag()] = False
    added: Annotated[bool, Flag()] = False
    grouped: Annotated[bool, Flag()] = False
    material: Annotated[bool, Flag()] = False
    each_run: Annotated[bool, Flag()] = False
    covers: Annotated[tuple[str, ...], Names("coulomb_friction")] = ()
    twin_of: Annotated[str, Text("coulomb_friction")] = ""
    covariate: Annotated[str | None, Text("neighbour_temperature")] = None
    at_work: Annotated[bool, Flag()] = False
    usual: Annotated[bool, Flag()] = False
    unsought: Annotated[bool, Flag()] = False
    declared: Annotated[bool, Flag()] = False
    kind: Annotated[Kind, OneOf(get_args(Kind))] = "plant"


@cache
def catalogue() -> tuple[Cause, ...]:
    """Every cause declared in this folder, by name, and those that other packages add.

    Raises InputError if a file of a package declares none, or has the name of another cause.
    """
    found = {path.stem: read_cause(path) for path in sorted(Path(__file__).parent.glob("*.toml"))}
    for each in plugins("causes"):
        for path in sorted(Path(each.load().__file__).parent.glob("*.toml")):
            if path.stem in found:
                raise each.refused(f"another cause is called {path.stem}")
            found[path.stem] = read_cause(path)
    return tuple(found.values())


def with_twins(names: Iterable[str]) -> str:
    """Names of causes as in a sentence, each with the causes that no log tells from it."""
    every = ((name, [each.name for each in catalogue() if each.twin_of == name]) for name in names)
    return " and ".join(" or ".join([name, *twins]) for name, twins in every)


def read_cause(path: Path) -> Cause:
    """Read the declaration of a cause; its name is that of the file.

    Raises
    ------
    InputError
        An entry is missing, not known, or of the wrong type.
    """
    return read_table(Cause, {**read_toml(path), "name": path.stem}, path.name)
