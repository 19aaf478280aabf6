"""Users' own controllers: a class or a Component in a Python file becomes an FMU like the shipped ones."""

from __future__ import annotations

import hashlib
import importlib
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from warmlink.controllers.interface import INPUTS, OUTPUTS
from warmlink.controllers.own import Law
from warmlink.fmus.catalogue import Entry
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError
from warmlink.fmus.records import dataclass
from warmlink.orchestration.catalogue import Controller, shipped
from warmlink.orchestration.fmu_store import FmuKind, FmuStore
from warmlink.orchestration.text_files import is_file

_SHIM = """from warmlink.controllers.own import component_of
from {package}.law import {attribute} as law

COMPONENT = component_of(law) if isinstance(law, type) else law
"""


@dataclass(frozen=True)
class OwnLaw(Controller):
    """A law from a user's file: its place, as given, and the module where its component is declared."""

    place: str = ""
    module: str = ""

    @property
    def kinds(self) -> set[str]:
        """None: warmlink has no such component."""
        return set()

    def files(self, store: FmuStore) -> dict[str, Path]:
        """Its FMU of the store's kind, built where it is missing; InputError if the law becomes none."""
        folder = store.folder / "own" / self.digest
        path = folder / f"{self.component.name}.fmu"
        return {self.component.name: path if is_file(path) else self._built(store.kind, folder)}

    def _built(self, kind: FmuKind, folder: Path) -> Path:
        from warmlink.fmus.packaging.native.fmu import build_native_fmus
        from warmlink.fmus.packaging.python.fmu import build_python_fmu

        entry = Entry(self.component, self.module)
        try:
            if kind == "python":
                return build_python_fmu(entry, folder)
            _check_symbolic(self.component)
            return build_native_fmus([entry], folder)[0]
        except InputError:
            raise
        except Exception as fault:
            raise InputError(
                f"{self.place}: does not become a {kind} FMU ({type(fault).__name__}: {_line(fault)}); "
                "write the law in plain arithmetic with warmlink.fmus.component.arithmetic, "
                "where() instead of if"
            ) from fault


def controller_named(name: str) -> Controller:
    """A shipped controller by its name, or a user's own law, as `my_law.py:MyLaw`.

    InputError if there is none of that name, or as `load_own_law`.
    """
    own = Path(name.rpartition(":")[0] or name).suffix == ".py"
    return load_own_law(name) if own else shipped(name)


def load_own_law(place: str) -> OwnLaw:
    """Law from `my_law.py:MyLaw`: a subclass of `warmlink.controllers.own.Law`, or a Component.

    InputError if the file or the name in it does not exist, or what it names is no law.
    """
    file, colon, attribute = place.rpartition(":")
    path = Path(file)
    if not colon or path.suffix != ".py" or not attribute.isidentifier():
        raise InputError(f"{place}: names no law; write it as my_law.py:MyLaw")
    if not is_file(path):
        raise InputError(f"{place}: there is no file {path}; give the path of an existing one")
    source = path.read_bytes()
    digest = hashlib.sha256(source + attribute.encode()).hexdigest()[:16]
    package = f"warmlink_own_{digest}"
    module = f"{package}.component"
    if module not in sys.modules:
        with _refused(place):
            _import(package, source, attribute, place)
    component = sys.modules[module].COMPONENT
    _check(component, place)
    return OwnLaw(attribute, component, digest, place, module)


def _import(package: str, source: bytes, attribute: str, place: str) -> None:
    """Import the file inside a package of its own, whose name no other module has."""
    folder = Path(tempfile.mkdtemp(prefix="warmlink-own-"))
    home = folder / package
    home.mkdir()
    (home / "__init__.py").write_bytes(b"")
    (home / "law.py").write_bytes(source)
    sys.path.insert(0, str(folder))
    try:
        law = importlib.import_module(f"{package}.law")
        found = getattr(law, attribute, None)
        if not _is_law(found):
            there = ", ".join(name for name, each in vars(law).items() if _is_law(each) and each is not Law)
            raise InputError(
                f"{place}: {attribute} is no law; name a subclass of warmlink.controllers.own.Law or a "
                f"Component; the file has {there or 'none'}"
            )
        about = getattr(found, "__doc__", None) or law.__doc__ or ""
        (home / "README.md").write_text(f"# {attribute}\n\n{about.strip()}\n", encoding="utf-8")
        shim = _SHIM.format(package=package, attribute=attribute)
        (home / "component.py").write_text(shim, encoding="utf-8")
        importlib.invalidate_caches()
        importlib.import_module(f"{package}.component")
    finally:
        sys.path.remove(str(folder))


def _is_law(found: object) -> bool:
    return isinstance(found, Component) or (isinstance(found, type) and issubclass(found, Law))


def _check(component: Component, place: str) -> None:
    """Check that the connectors are those of every compensator, and let the law take one step."""
    for kind, wanted, held in (("input", INPUTS, component.u), ("output", OUTPUTS, component.y)):
        for name in (variable.name for variable in wanted if variable.name not in held.index):
            told = f"has no {kind} {name}; take warmlink.controllers.interface's {kind.upper()}S"
            raise InputError(f"{place}: {told}")
    with _refused(place):
        instance = Instance(component, component.name)
        instance.begin(0.0)
        instance.initialize()
        instance.step(0.0, 1.0)
        float(instance.get("correction"))


@contextmanager
def _refused(place: str) -> Iterator[None]:
    try:
        yield
    except InputError as fault:
        sentence = str(fault)
        raise InputError(sentence if sentence.startswith(place) else f"{place}: {sentence}") from None
    except (Exception, SystemExit) as fault:  # a file that ends the program would end it without a word
        raise InputError(
            f"{place}: does not work ({type(fault).__name__}: {_line(fault)}); mend the file"
        ) from fault


def _check_symbolic(component: Component) -> None:
    """Compare the law in symbols, from which C is made, with the law in numbers; TypeError if they differ.

    Python's `math` functions turn a symbol into NaN without an error.
    """
    import casadi as ca
    import numpy as np

    p, u = component.start_values()
    u = 1.1 * u + 0.1
    d = component.settled(p)
    x = component.states_at_start(u, d)

    def both(x: Any, u: Any, d: Any) -> list[Any]:
        observed = component.outputs_of(x, u, d, 7.0)
        return [observed] if component.update is None else [observed, component.updated(x, u, d, 7.0, 1.0)]

    symbols = [ca.SX.sym(name, len(values)) for name, values in (("x", x), ("u", u), ("d", d))]
    function = ca.Function("law", symbols, [ca.vertcat(*both(*symbols))])
    in_symbols = np.asarray(function(x, u, d), dtype=float).ravel()
    in_numbers = np.concatenate([np.atleast_1d(np.asarray(part, dtype=float)) for part in both(x, u, d)])
    if not np.allclose(in_symbols, in_numbers, rtol=1e-9, atol=1e-12, equal_nan=True):
        raise TypeError("the law gives another result for symbols than for numbers")


def _line(fault: BaseException) -> str:
    """An exception's message in one line."""
    return " ".join(str(fault).split())[:300]
