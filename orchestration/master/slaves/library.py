"""An FMU's shared library with the functions of its FMI version, and what they exchange."""

from __future__ import annotations

import ctypes
import os
import platform
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from ctypes import c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from itertools import accumulate
from pathlib import Path
from typing import Any, ClassVar

from warmlink.fmus.errors import InputError
from warmlink.fmus.names import instead
from warmlink.orchestration.master.slaves.slave import Names
from warmlink.orchestration.master.slaves.surroundings import working_folder
from warmlink.orchestration.system.archive import holds_source_code
from warmlink.orchestration.system.model import FmuVariable, ModelInfo, Value

_INTEGERS = [f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)]
_TYPES: dict[str, dict[str, Any]] = {
    "fmi1": {"Real": c_double, "Integer": c_int, "Boolean": ctypes.c_byte, "String": c_char_p},
    "fmi2": {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p},
    "fmi3": {
        **{"Float32": ctypes.c_float, "Float64": c_double, "Boolean": c_bool, "String": c_char_p},
        **{name: getattr(ctypes, f"c_{name.lower()}") for name in _INTEGERS},
        "Binary": c_void_p,
    },
}
"""Types by which variables are exchanged, by the names that are part of the functions' names."""


class Callbacks1(ctypes.Structure):
    """`fmiCallbackFunctions` of FMI 1.0, which are passed by value: logger, allocate, free, step finished."""

    _fields_: ClassVar[Any] = [(name, c_void_p) for name in ("logger", "allocate", "free", "finished")]


_LETTERS = {
    **{"p": c_void_p, "s": c_char_p, "n": c_size_t, "d": c_double, "i": c_int, "b": c_bool, "u": c_uint},
    "c": Callbacks1,
}

_BOTH = {
    **dict.fromkeys(("FreeInstance", "ExitInitializationMode", "Terminate"), "p"),
    **dict.fromkeys(("GetFMUState", "SetFMUState", "FreeFMUState"), "pp"),
    **{"SerializedFMUStateSize": "ppp", "SerializeFMUState": "pppn", "DeserializeFMUState": "ppnp"},
}
_ARGUMENTS = {
    "fmi1": {
        **{"FreeInstance": "p", "Terminate": "p"},
        **{f"{verb}{name}": "ppnp" for name in _TYPES["fmi1"] for verb in ("Get", "Set")},
    },
    "fmi2": {
        **_BOTH,
        **{f"{verb}{name}": "ppnp" for name in _TYPES["fmi2"] for verb in ("Get", "Set")},
        **{"Instantiate": "sisspii", "SetDebugLogging": "pinp", "SetupExperiment": "piddid"},
        **{"EnterInitializationMode": "p", "GetDirectionalDerivative": "ppnpnpp"},
    },
    "fmi3": {
        **_BOTH,
        **{f"{verb}{name}": "ppnpn" for name in _TYPES["fmi3"] for verb in ("Get", "Set")},
        **dict.fromkeys(("GetBinary", "SetBinary"), "ppnppn"),
        **dict.fromkeys(("EnterConfigurationMode", "ExitConfigurationMode"), "p"),
        **{"SetDebugLogging": "pbnp", "EnterInitializationMode": "pbddbd"},
        **{"GetDirectionalDerivative": "ppnpnpnpn"},
    },
}
_MODES = dict.fromkeys(("EnterEventMode", "EnterContinuousTimeMode"), "p")
_MODEL = {
    **{"SetTime": "pd", "SetContinuousStates": "ppn", "GetContinuousStates": "ppn"},
    **{"GetNominalsOfContinuousStates": "ppn", "GetEventIndicators": "ppn"},
}
_OF_INTERFACE = {
    ("fmi1", "CoSimulation"): {
        **{"Instantiate": "ssssdbbcb", "ExitInitializationMode": "pdbd", "DoStep": "pddb"},
    },
    ("fmi1", "ModelExchange"): {
        **_MODEL,
        **{"Instantiate": "sscb", "ExitInitializationMode": "pbdp", "EventUpdate": "pbp"},
        **{"CompletedIntegratorStep": "pp", "GetDerivatives": "ppn"},
    },
    ("fmi2", "CoSimulation"): {
        **{"DoStep": "pddi", "GetBooleanStatus": "pip", "GetRealStatus": "pip"},
        **{"SetRealInputDerivatives": "ppnpp"},
    },
    ("fmi3", "CoSimulation"): {
        **{
            "InstantiateCoSimulation": "sssbbbbpnppp",
            "DoStep": "pddbpppp",
            "UpdateDiscreteStates": "ppppppp",
        },
        **{"EnterEventMode": "p", "EnterStepMode": "p"},
    },
    ("fmi3", "ScheduledExecution"): {
        **{"InstantiateScheduledExecution": "sssbbppppp", "ActivateModelPartition": "pud"},
        **{"GetIntervalDecimal": "ppnpp"},
    },
    ("fmi2", "ModelExchange"): {
        **_MODES,
        **_MODEL,
        **{"NewDiscreteStates": "pp", "CompletedIntegratorStep": "pipp", "GetDerivatives": "ppn"},
    },
    ("fmi3", "ModelExchange"): {
        **_MODES,
        **_MODEL,
        **{"InstantiateModelExchange": "sssbbpp", "UpdateDiscreteStates": "ppppppp"},
        **{"CompletedIntegratorStep": "pbpp", "GetContinuousStateDerivatives": "ppn"},
    },
}
"""Arguments of each function: pointer, string, size, double, int, bool, unsigned, callbacks of FMI 1.0."""

_SPELLED = {name: name.replace("FMUState", "FMUstate").replace("Des", "DeS") for name in _BOTH}
"""Names in FMI 2.0 that differ in their capitals."""
_SPELLED_1 = {
    "CoSimulation": {
        **{"Instantiate": "InstantiateSlave", "FreeInstance": "FreeSlaveInstance"},
        **{"Terminate": "TerminateSlave", "ExitInitializationMode": "InitializeSlave"},
    },
    "ModelExchange": {
        **{"Instantiate": "InstantiateModel", "FreeInstance": "FreeModelInstance"},
        **{"GetNominalsOfContinuousStates": "GetNominalContinuousStates"},
        **{"ExitInitializationMode": "Initialize"},
    },
}
"""Names in FMI 1.0 that differ, by the interface."""


def exchanged_as(prefix: str, variable: FmuVariable) -> tuple[str, Any] | None:
    """Name and ctypes type by which a variable is exchanged; None where it cannot be."""
    enumeration = "Int64" if prefix == "fmi3" else "Integer"
    base, types = enumeration if variable.type == "Enumeration" else variable.type, _TYPES[prefix]
    return (base, types[base]) if base in types else None


Held = dict[int, list[Value]]
"""All values of an array by its value reference: what its elements were set to, or start from."""

_FLOATS = ("Real", "Float32", "Float64")


def held_from_start(variables: Mapping[str, FmuVariable]) -> Held:
    """Give the start values of everything, by value reference."""
    held: Held = {}
    for variable in variables.values():
        blank: list[Value] = ["" if variable.kind in ("String", "Binary") else 0] * variable.elements
        values = held.setdefault(variable.value_reference, blank)
        if variable.start is not None:
            values[variable.element] = variable.start
    return held


class Batch:
    """Variables of one base type, as FMI functions name it, chosen by their places in a set of variables.

    `held` are the slave's values of arrays, of which some elements may be set alone. The FMU's functions
    `get` and `set` take the same `arguments`. Binary values are text here, two hexadecimal digits for a byte.
    """

    def __init__(self, base: str, c_type: Any, chosen: Mapping[int, FmuVariable], held: Held) -> None:
        self.base, self.positions, self.count = base, list(chosen), len(chosen)
        self.arrays = any(variable.elements > 1 for variable in chosen.values())
        self.plain = base in _FLOATS and not self.arrays
        self.names = [variable.name for variable in chosen.values()]
        self._places = [(v.value_reference, v.element) for v in chosen.values()]
        self._held = held
        references, size = [reference for reference, _ in self._places], self.count
        if self.arrays:
            # FMI exchanges all elements of an array at once.
            sizes = {v.value_reference: v.elements for v in chosen.values()}
            starts = dict(zip(sizes, accumulate(sizes.values(), initial=0), strict=False))
            self._slots = [starts[reference] + element for reference, element in self._places]
            references, size = list(sizes), sum(sizes.values())
        self.references = (c_uint * len(references))(*references)
        self.values: Any = (c_type * size)()
        self._lengths = (c_size_t * size)()
        self._bytes: list[bytes] = []
        self.get: Any = None
        self.set: Any = None
        self.arguments: tuple[Any, ...] = ()

    def arguments_for(self, component: Any, prefix: str) -> tuple[Any, ...]:
        """Give the arguments by which an instance is asked for the values, or given them."""
        lengths = (self._lengths,) if self.base == "Binary" else ()
        sizes = (len(self.values),) if prefix == "fmi3" else ()
        return component, self.references, len(self.references), *lengths, self.values, *sizes

    def load(self, values: Sequence[Value]) -> None:
        """Fill the array from the values of the whole set."""
        chosen = values if self.count == len(values) else [values[p] for p in self.positions]
        if self.arrays:
            for (reference, element), value in zip(self._places, chosen, strict=True):
                self._held[reference][element] = value
            chosen = [value for reference in self.references for value in self._held[reference]]
        if self.base in _FLOATS:
            self.values[:] = chosen
        elif self.base == "String":
            self.values[:] = [str(value).encode() for value in chosen]
        elif self.base == "Binary":
            self._bytes = [bytes.fromhex(str(value)) for value in chosen]
            self._lengths[:] = [len(value) for value in self._bytes]
            self.values[:] = [ctypes.cast(c_char_p(value), c_void_p).value for value in self._bytes]
        else:
            self.values[:] = [int(value) for value in chosen]

    def unload(self) -> list[Value]:
        """Give the array's values as Python values."""
        values: list[Value] = self.values[:]
        if self.base == "Boolean":
            values = [bool(value) for value in values]
        if self.base == "Binary":
            pairs = zip(self.values, self._lengths, strict=True)
            values = [ctypes.string_at(at, size).hex() if at else "" for at, size in pairs]
        if self.base == "String":
            values = [(value or b"").decode("utf-8", "replace") for value in self.values]
        return [values[slot] for slot in self._slots] if self.arrays else values


def sorted_by_type(
    slave: str, prefix: str, variables: Mapping[str, FmuVariable], names: Names, held: Held
) -> list[Batch]:
    """Sort variables into batches of one base type; InputError where one is unknown or cannot be exchanged.

    `prefix` is that of the slave's FMI version; `held` keeps what arrays were set to.
    """
    found: dict[tuple[str, Any], dict[int, FmuVariable]] = {}
    for position, name in enumerate(names):
        variable = variables.get(name)
        if variable is None:
            raise InputError(f"{slave}.{name}: the FMU has no such variable; {instead(name, variables)}")
        base = None if variable.dimensions else exchanged_as(prefix, variable)
        if base is None:
            raise InputError(
                f"{slave}.{name}: {variable.type} values of this shape cannot be exchanged; "
                "choose a scalar number, Boolean or String"
            )
        found.setdefault(base, {})[position] = variable
    return [Batch(*base, chosen, held) for base, chosen in found.items()]


class Library:
    """The shared library of an unpacked FMU; its `functions` by their names in FMI 3.0, without the prefix.

    Takes the instance's name for sentences, the FMU's description, the folder, and `fmi1`, `fmi2` or `fmi3`.
    InputError if there is no library for this platform, or one that does not load or lacks functions.
    """

    def __init__(self, name: str, info: ModelInfo, folder: Path, prefix: str) -> None:
        fmu, identifier = info.path.name, info.model_identifier
        place = (folder / "binaries" / platform_name(prefix)).absolute()
        if not place.is_dir():
            offered = ", ".join(sorted(p.name for p in place.parent.glob("*"))) or "none"
            told = f"{name}: {fmu} holds no library for {place.name} (it has: {offered})"
            compiled = (
                "compile its source code (fmpy compile FILE) or " if holds_source_code(info.path) else ""
            )
            raise InputError(f"{told}; {compiled}export it for this platform")
        here = working_folder()
        self._prefix = f"{identifier}_fmi" if prefix == "fmi1" else prefix
        self._spelled = {"fmi1": _SPELLED_1.get(info.interface, {}), "fmi2": _SPELLED}.get(prefix, {})
        try:
            os.chdir(place)  # where some libraries look for others
            self._dll = ctypes.CDLL(str(place / f"{identifier}{SUFFIX}"))
            arguments = {**_ARGUMENTS[prefix], **_OF_INTERFACE[prefix, info.interface]}
            self.functions = {each: self._declared(each, letters) for each, letters in arguments.items()}
        except (OSError, AttributeError) as error:
            raise InputError(f"{name}: the library of {fmu} does not load: {error}") from error
        finally:
            if here is not None:
                with suppress(OSError):
                    os.chdir(here)

    def _declared(self, name: str, letters: str) -> Any:
        function = getattr(self._dll, self._prefix + self._spelled.get(name, name))
        function.argtypes = [_LETTERS[letter] for letter in letters]
        function.restype = c_void_p if name.startswith("Instantiate") else c_int
        return function

    def close(self) -> None:
        """Unload the library."""
        handle = c_void_p(self._dll._handle)
        if sys.platform == "win32":
            ctypes.windll.kernel32.FreeLibrary(handle)
        else:
            ctypes.CDLL(None).dlclose(handle)


SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def platform_name(prefix: str) -> str:
    """Folder of this platform in an FMU of `fmi1`, `fmi2` or `fmi3`; only the last names Linux on ARM."""
    arm, bits = platform.machine().lower() in ("aarch64", "arm64"), 64 if sys.maxsize > 2**32 else 32
    system = {"win32": "windows"}.get(sys.platform, sys.platform)
    if prefix != "fmi3" and not (arm and system == "linux"):
        return f"{'win' if system == 'windows' else system}{bits}"
    return f"{'aarch64' if arm else 'x86_64' if bits == 64 else 'x86'}-{system}"
