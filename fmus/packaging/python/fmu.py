"""A component as a Python FMU: pythonfmu's library, a slave, and the modules that it needs.

Modules of equal names in one process run each other's code. So the modules that a component needs, found
by walking imports, and the data beside them are written below one package named after their contents, and
their imports of each other are rewritten to it.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.resources
import importlib.util
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from warmlink.fmus.catalogue import Entry
from warmlink.fmus.files import write_archive
from warmlink.fmus.packaging import release
from warmlink.fmus.packaging.beside import files_beside
from warmlink.fmus.packaging.model_description import model_description
from warmlink.fmus.syntax import parsed

_FACE = "warmlink"
"""The package of the public names, which no FMU needs: each name is imported from where it is declared."""

_PREFIX = f"{_FACE}."
_EXPORTER = "pythonfmu"
_FOR_TYPES = ("TYPE_CHECKING", "typing.TYPE_CHECKING")
"""Conditions under which a type checker alone reads what follows."""

_SCRIPT = '''"""Entry of the FMU: pythonfmu's library looks for the class at the end."""

import ctypes

{imports}
from {slave} import ComponentSlave as Fmi2Slave
from {module} import {attribute} as declared

# pythonfmu 0.7.0 runs this file once more for every instance and then gives up a reference to the module's
# globals that is not its own; without this they would be freed under the running slave.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}(Fmi2Slave):
    component = declared
    form = "{form}"
'''


def build_python_fmus(
    entries: Iterable[Entry], folder: Path, progress: Callable[[str], None] = lambda name: None
) -> list[Path]:
    """Write the Python FMUs of components and return their paths, in the order of the components.

    Parameters
    ----------
    entries : from `catalogue()`, or of one's own
    folder : where `<Name>.fmu` is written, `dist/python`, say
    progress : called with the name of each FMU that is done
    """
    built = []
    for entry in entries:
        built.append(folder / f"{entry.component.name}.fmu")
        write_archive(built[-1], python_fmu_files(entry))
        progress(entry.component.name)
    return built


def python_fmu_files(entry: Entry) -> dict[str, bytes]:
    """Contents of the Python FMU of a component by path inside the archive."""
    component = entry.component
    slave = "warmlink.fmus.packaging.python.slave"
    carried = bundle((slave, entry.module), f"warmlink_{component.snake_name}")
    script = _SCRIPT.format(
        imports="\n".join(f"import {name}" for name in carried.modules.values()),
        slave=carried.modules[slave],
        module=carried.modules[entry.module],
        attribute=entry.attribute,
        name=component.name,
        form=carried.package,
    )
    stem = f"{carried.package}_slave"
    return {
        "modelDescription.xml": model_description(component, native=False, implementation=carried.package),
        **files_beside(entry),
        **_libraries(component.name),
        "documentation/licenses/pythonfmu.txt": release.license_text("pythonfmu").encode(),
        "resources/slavemodule.txt": stem.encode(),
        f"resources/{stem}.py": script.encode(),
        **{f"resources/{path}": content for path, content in carried.files.items()},
    }


def _libraries(identifier: str) -> dict[str, bytes]:
    """Libraries of pythonfmu for the platforms that it has, by path inside the archive."""
    folder = Path(str(importlib.resources.files("pythonfmu"))) / "resources" / "binaries"
    libraries = (file for file in folder.glob("*/*") if file.suffix in (".so", ".dll", ".dylib"))
    return {f"binaries/{f.parent.name}/{identifier}{f.suffix}": f.read_bytes() for f in libraries}


@dataclass(frozen=True)
class Bundle:
    """Modules of one FMU: the package that holds them, and their names in it by those in this process.

    The files' contents are by path below the package's parent folder.
    """

    package: str
    files: dict[str, bytes]
    modules: dict[str, str]


@dataclass(frozen=True)
class _Module:
    name: str
    path: Path

    @property
    def package(self) -> str:
        """Name of the package that it is, or is in."""
        return self.name if self.path.name == "__init__.py" else self.name.rpartition(".")[0]

    @cached_property
    def source(self) -> bytes:
        # The exporter's package would import its builder, which no FMU needs.
        return b"" if self.name == _EXPORTER else _unix(self.path)

    @property
    def imported(self) -> Iterator[str]:
        """Names of the modules that it may import: some of them are names of what modules hold."""
        for statement in (each for each, runs in _import_statements(self.source).items() if runs):
            parent = ""
            if isinstance(statement, ast.ImportFrom):
                if _is_of_the_face(statement):
                    yield from (_home(alias.name) for alias in statement.names)
                    continue
                parent = statement.module or ""
                if statement.level:
                    parent = importlib.util.resolve_name("." * statement.level + parent, self.package)
                yield parent
            yield from (f"{parent}.{alias.name}".lstrip(".") for alias in statement.names)


def bundle(roots: tuple[str, ...], stem: str) -> Bundle:
    """Collect modules, everything of ours and of pythonfmu that they import, and our data (JSON) beside them.

    The contents' hash completes the package's name after the stem. ValueError: a module says `import a.b` for
    a module that is to be bundled; its name cannot be rewritten.
    """
    own = {_PREFIX.partition(".")[0], _EXPORTER, *(root.partition(".")[0] for root in roots)}
    modules: dict[str, _Module] = {}
    waiting = list(roots)
    while waiting:
        name = waiting.pop()
        if name in modules or name == _FACE or name.partition(".")[0] not in own:
            continue
        path = _located(name)
        if path is not None:
            modules[name] = _Module(name, path)
            waiting += modules[name].imported
        waiting.append(name.rpartition(".")[0])

    data = {
        f"{module.package}/{file.name}": _unix(file)
        for name, module in modules.items()
        for file in module.path.parent.glob("*.json")
        if name.startswith(_PREFIX) and module.package != name
    }
    digest = hashlib.sha256()
    for name, content in sorted(({name: each.source for name, each in modules.items()} | data).items()):
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    package = f"{stem}_{digest.hexdigest()[:12]}"
    files = {f"{package}/__init__.py": b""}
    for name, module in modules.items():
        ending = "/__init__.py" if module.package == name else ".py"
        files[_renamed(name, package).replace(".", "/") + ending] = _rewritten(module, package, own)
    for place, content in data.items():
        home, _, name = place.partition("/")
        files[f"{_renamed(home, package).replace('.', '/')}/{name}"] = content
    return Bundle(package, files, {name: _renamed(name, package) for name in sorted(modules)})


def _located(name: str) -> Path | None:
    """File of the module of a name; None for a namespace package and for what is no module."""
    with suppress(ModuleNotFoundError):
        spec = importlib.util.find_spec(name) if name else None
        return None if spec is None or spec.origin is None else Path(spec.origin)
    return None


def _unix(file: Path) -> bytes:
    return file.read_bytes().replace(b"\r\n", b"\n")


@cache
def _import_statements(source: bytes) -> dict[ast.Import | ast.ImportFrom, bool]:
    """Import statements of a module, found once for all FMUs that carry it, and whether they ever run."""
    every = list(ast.walk(parsed(source)))
    for_types = [each for each in every if isinstance(each, ast.If) and ast.unparse(each.test) in _FOR_TYPES]
    idle = {inside for each in for_types for held in each.body for inside in ast.walk(held)}
    return {each: each not in idle for each in every if isinstance(each, ast.Import | ast.ImportFrom)}


def _is_of_the_face(statement: ast.ImportFrom) -> bool:
    """Whether it is `from warmlink import ...`, of public names and not of the folders."""
    folders = ("fmus", "controllers", "orchestration")
    names = [alias.name for alias in statement.names]
    return not statement.level and statement.module == _FACE and not any(name in folders for name in names)


def _home(name: str) -> str:
    """Module that declares a public name of warmlink."""
    return str(getattr(importlib.import_module(_FACE), name).__module__)


def _renamed(name: str, package: str) -> str:
    return f"{package}.{name.removeprefix(_PREFIX)}"


def _rewritten(module: _Module, package: str, own: set[str]) -> bytes:
    """Source whose absolute imports of bundled modules go to the package."""
    lines = module.source.decode("utf-8").split("\n")
    for statement in _import_statements(module.source):
        if isinstance(statement, ast.Import):
            bundled = [alias.name for alias in statement.names if alias.name.partition(".")[0] in own]
            if bundled:
                raise ValueError(
                    f"{module.name}, line {statement.lineno}: 'import {bundled[0]}' cannot be bundled; "
                    f"write 'from {bundled[0].rpartition('.')[0] or bundled[0]} import ...'"
                )
        elif _is_of_the_face(statement):
            homes = [(_renamed(_home(alias.name), package), ast.unparse(alias)) for alias in statement.names]
            row, last = statement.lineno - 1, statement.end_lineno or statement.lineno
            lines[row] = lines[row][: statement.col_offset] + "; ".join(
                f"from {home} import {name}" for home, name in homes
            )
            lines[row + 1 : last] = [""] * (last - row - 1)
        elif not statement.level and statement.module and statement.module.partition(".")[0] in own:
            row, column = statement.lineno - 1, statement.col_offset
            old, new = f"from {statement.module}", f"from {_renamed(statement.module, package)}"
            if not lines[row][column:].startswith(old):
                raise ValueError(f"{module.name}, line {statement.lineno}: write '{old} import ...'")
            lines[row] = lines[row][:column] + new + lines[row][column + len(old) :]
    return "\n".join(lines).encode("utf-8")
