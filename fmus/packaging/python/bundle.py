"""The Python modules that an FMU carries, and the data beside them, in a package that no other FMU has.

Modules of equal names in one process run each other's code. So the modules that a component needs, found
by walking imports, are written below one package named after their contents, and their imports of each
other are rewritten to it.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

from warmlink.fmus.syntax import no_garbage_collection

_PREFIX = "warmlink."
_EXPORTER = "pythonfmu"


@dataclass(frozen=True)
class Bundle:
    """Modules of one FMU.

    Attributes
    ----------
    package : name of the package that holds them
    files : contents by path below the package's parent folder
    modules : their names, by the names that they have in this process
    """

    package: str
    files: dict[str, bytes]
    modules: dict[str, str]


@dataclass(frozen=True)
class _Module:
    name: str
    path: Path
    is_package: bool

    @cached_property
    def source(self) -> bytes:
        # The exporter's package would import its builder, which no FMU needs.
        return b"" if self.name == _EXPORTER else self.path.read_bytes().replace(b"\r\n", b"\n")

    @property
    def imports(self) -> tuple[ast.Import | ast.ImportFrom, ...]:
        return _import_statements(self.source)


def bundle(roots: tuple[str, ...], stem: str) -> Bundle:
    """Collect modules, everything of ours and of pythonfmu that they import, and our data (JSON) beside them.

    Parameters
    ----------
    roots : names of importable modules to begin with
    stem : beginning of the package's name, which the contents' hash completes

    Raises
    ------
    ValueError
        A module says `import a.b` for a module that is to be bundled; its name cannot be rewritten.
    """
    own = {_PREFIX.partition(".")[0], _EXPORTER, *(root.partition(".")[0] for root in roots)}
    modules: dict[str, _Module] = {}
    waiting = list(roots)
    while waiting:
        name = waiting.pop()
        if name in modules or name.partition(".")[0] not in own:
            continue
        module = _locate(name)
        if module is not None:
            modules[name] = module
            waiting += _imported(module)
        waiting += [name.rpartition(".")[0]] if "." in name else []

    contents = {name: module.source for name, module in modules.items()}
    data = {
        (name.rpartition(".")[0], file.name): file.read_bytes().replace(b"\r\n", b"\n")
        for name, module in modules.items()
        for file in module.path.parent.glob("*.json")
        if name.startswith(_PREFIX) and not module.is_package
    }
    contents |= {f"{home}/{name}": content for (home, name), content in data.items()}
    digest = hashlib.sha256()
    for name, content in sorted(contents.items()):
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    package = f"{stem}_{digest.hexdigest()[:12]}"
    files = {f"{package}/__init__.py": b""}
    for name, module in modules.items():
        files[_path(_renamed(name, package), module.is_package)] = _rewritten(module, package, own)
    for (home, name), content in data.items():
        files[f"{_renamed(home, package).replace('.', '/')}/{name}"] = content
    return Bundle(package, files, {name: _renamed(name, package) for name in sorted(modules)})


def _locate(name: str) -> _Module | None:
    """The module of a name; None for a namespace package and for what is no module."""
    try:
        spec = importlib.util.find_spec(name)
    except ModuleNotFoundError:
        return None
    if spec is None or spec.origin is None:
        return None
    return _Module(name, Path(spec.origin), spec.submodule_search_locations is not None)


@cache
def _import_statements(source: bytes) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Import statements of a module, found once for all FMUs that carry it."""
    with no_garbage_collection():
        return tuple(_imports(ast.parse(source)))


def _imports(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Import statements, but for those that only a type checker reads."""
    if isinstance(tree, ast.If) and ast.unparse(tree.test).endswith("TYPE_CHECKING"):
        for statement in tree.orelse:
            yield from _imports(statement)
        return
    if isinstance(tree, ast.Import | ast.ImportFrom):
        yield tree
    for child in ast.iter_child_nodes(tree):
        yield from _imports(child)


def _imported(module: _Module) -> list[str]:
    names: list[str] = []
    for statement in module.imports:
        if isinstance(statement, ast.Import):
            names += [alias.name for alias in statement.names]
        else:
            parent = _absolute(module, statement)
            names += [parent, *(f"{parent}.{alias.name}" for alias in statement.names)]
    return names


def _absolute(module: _Module, statement: ast.ImportFrom) -> str:
    if not statement.level:
        return statement.module or ""
    package = module.name if module.is_package else module.name.rpartition(".")[0]
    return importlib.util.resolve_name("." * statement.level + (statement.module or ""), package)


def _renamed(name: str, package: str) -> str:
    return f"{package}.{name.removeprefix(_PREFIX)}"


def _path(name: str, is_package: bool) -> str:
    return name.replace(".", "/") + ("/__init__.py" if is_package else ".py")


def _rewritten(module: _Module, package: str, own: set[str]) -> bytes:
    """Source whose absolute imports of bundled modules go to the package."""
    lines = module.source.decode("utf-8").split("\n")
    for statement in module.imports:
        if isinstance(statement, ast.Import):
            bundled = [alias.name for alias in statement.names if alias.name.partition(".")[0] in own]
            if bundled:
                raise ValueError(
                    f"{module.name}, line {statement.lineno}: 'import {bundled[0]}' cannot be bundled; "
                    f"write 'from {bundled[0].rpartition('.')[0] or bundled[0]} import ...'"
                )
        elif not statement.level and statement.module and statement.module.partition(".")[0] in own:
            row, column = statement.lineno - 1, statement.col_offset
            old, new = f"from {statement.module}", f"from {_renamed(statement.module, package)}"
            if not lines[row][column:].startswith(old):
                raise ValueError(f"{module.name}, line {statement.lineno}: write '{old} import ...'")
            lines[row] = lines[row][:column] + new + lines[row][column + len(old) :]
    return "\n".join(lines).encode("utf-8")
