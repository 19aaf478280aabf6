"""Components and controllers by the names that people give them, and controllers that users write themselves.

A class or a Component in a Python file becomes an FMU like the shipped ones.
"""

from __future__ import annotations

import atexit
import hashlib
import importlib
import sys
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from warmlink.controllers.interface import INPUTS, OUTPUTS
from warmlink.controllers.own import Law
from warmlink.fmus.catalogue import Entry, catalogue
from warmlink.fmus.component import Component
from warmlink.fmus.component.instance import Instance
from warmlink.fmus.errors import InputError, in_one_line
from warmlink.fmus.files import scratch_folder
from warmlink.fmus.heat_term.component import STORED as STORED_TERM
from warmlink.fmus.heat_term.component import heat_term
from warmlink.fmus.heat_term.component import read_stored as read_stored_term
from warmlink.fmus.names import instead
from warmlink.fmus.reduced_link.component import reduced_link
from warmlink.fmus.reduced_link.equations import STORED, read_stored
from warmlink.orchestration.text_files import is_file

_SHIM = """from warmlink.controllers.own import component_of
from {package}.law import {attribute} as law

COMPONENT = component_of(law) if isinstance(law, type) else law
"""


@dataclass(frozen=True)
class Controller:
    """A controller: what people call it, and its component.

    A user's own one has the `digest` of its file, its `place`, as `my_law.py:MyLaw`, and the `module` that
    declares its component; for one that warmlink ships they are empty.
    """

    name: str
    component: Component
    digest: str = ""
    place: str = ""
    module: str = ""

    @property
    def kinds(self) -> set[str]:
        """Names of warmlink's components that it needs."""
        return set() if self.place else {self.component.name}


@cache
def entries() -> dict[str, Entry]:
    """Every component with the place of its declaration, by its own name, as `ThermalLink`."""
    return {entry.component.name: entry for entry in catalogue()}


def components() -> dict[str, Component]:
    """Every component by its own name."""
    return {name: entry.component for name, entry in entries().items()}


def reduced_link_in(fmu: Path) -> Component | None:
    """Declaration of the reduced link that an FMU is, from the model that it holds; None for another FMU."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            return reduced_link(fmu.stem, read_stored(archive.read(STORED)))
    except (OSError, KeyError, ValueError, TypeError, zipfile.BadZipFile):
        return None


def heat_term_in(fmu: Path) -> Component | None:
    """Declaration of the term that an FMU is, from the term that it holds; None for another FMU."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            return heat_term(read_stored_term(archive.read(STORED_TERM)))
    except (OSError, KeyError, ValueError, TypeError, AttributeError, zipfile.BadZipFile):
        return None


@cache
def controllers() -> dict[str, Component]:
    """Compensating controllers by the name of their folder, as `lag`."""
    laws = [entry for entry in entries().values() if entry.law]
    for entry in laws:
        if entry.added:
            _check_law(entry.component, f"{entry.module}:{entry.attribute}")
    return {entry.law: entry.component for entry in laws}


def controller(name: str) -> Component:
    """Controller by its name; InputError if no controller has that name."""
    if name not in controllers():
        raise InputError(f"{name}: no such controller; {instead(name, controllers())}")
    return controllers()[name]


def shipped(name: str) -> Controller:
    """Controller with its name; raises as `controller`."""
    return Controller(name, controller(name))


def controller_named(name: str | Path) -> Controller:
    """A shipped controller by its name, or a user's own law, as `my_law.py:MyLaw`.

    InputError if there is none of that name, or as `load_own_law`.
    """
    name = str(name)
    own = Path(name.rpartition(":")[0] or name).suffix == ".py"
    return load_own_law(name) if own else shipped(name)


def refuse_one_name(what: str, names: Iterable[str]) -> None:
    """Refuse things of which two have one name, since what is found is told by it."""
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise InputError(f"{twice[0]}: two {what} of that name; rename one")


def load_own_law(place: str) -> Controller:
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
    return Controller(attribute, component, digest, place, module)


def _import(package: str, source: bytes, attribute: str, place: str) -> None:
    """Import the file inside a package of its own, whose name no other module has."""
    folder = _own_modules()
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


def made_module(package: str, files: Mapping[str, str]) -> str:
    """Package of files, by their names, under a name that nothing else has; gives that name again."""
    folder = _own_modules()
    if not (folder / package).is_dir():
        (folder / package).mkdir()
        for name, text in {"__init__.py": "", **files}.items():
            (folder / package / name).write_text(text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        for name in files:
            if name.endswith(".py"):
                importlib.import_module(f"{package}.{name.removesuffix('.py')}")
    finally:
        sys.path.remove(str(folder))
    return package


@cache
def _own_modules() -> Path:
    """Folder for modules that are not warmlink's, of laws and terms, which goes with the process."""
    held = ExitStack()
    atexit.register(held.close)
    return held.enter_context(scratch_folder())


def _is_law(found: object) -> bool:
    return isinstance(found, Component) or (isinstance(found, type) and issubclass(found, Law))


def _check(component: Component, place: str) -> None:
    """Check name and connectors, which are those of every compensator, and let the law take one step."""
    if component.name in entries():  # whose FMU would be taken for its own
        raise InputError(f"{place}: warmlink has a {component.name} of its own; rename yours")
    _check_law(component, place)


def _check_law(component: Component, place: str) -> None:
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
            f"{place}: does not work ({type(fault).__name__}: {in_one_line(fault)}); mend the file"
        ) from fault
