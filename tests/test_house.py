"""The house as it is meant to be: what is installed, what imports what, what loads when."""

import ast
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = ("fmus", "controllers", "orchestration")
HEAVY = (
    "pandas",
    "plotly",
    "casadi",
    "scipy",
    "pint",
    "fmpy",
    "optuna",
    "dask",
    "skfem",
    "pyarrow",
    "pydantic",
)
FACE = Path("orchestration", "face")
"""What installs as `warmlink` itself."""
LAW_FILES = ("equations.py", "law.py")
SOURCES = sorted(path for floor in FLOORS for path in (ROOT / floor).rglob("*.py"))

LAWS = [p for p in SOURCES if p.name in LAW_FILES and p.relative_to(ROOT).parts[0] != "orchestration"]


def sources(room: str) -> list[Path]:
    """Python files of a room and those below; a room that was renamed fails, and is not passed over."""
    found = sorted((ROOT / room).rglob("*.py"))
    assert found, f"{room} holds no Python; it was renamed, or moved"
    return found


def statements(inside: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """All statements, also those inside others; not the expressions, which are most of a tree."""
    for each in inside:
        yield each
        for part in ("body", "orelse", "handlers", "finalbody", "cases"):
            yield from statements(getattr(each, part, ()))


@cache
def imported(path: Path) -> tuple[frozenset[str], frozenset[str]]:
    """Modules that a file imports, and those that it imports names from, also inside functions."""
    plain, sources_of_names = set[str](), dict[str, set[str]]()
    for node in statements(ast.parse(path.read_text("utf-8")).body):
        if isinstance(node, ast.Import):
            plain |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            sources_of_names.setdefault(node.module, set()).update(alias.name for alias in node.names)
    names = {f"{module}.{name}" for module, names in sources_of_names.items() for name in names}
    return frozenset(plain | names | {*sources_of_names}), frozenset(sources_of_names)


def imports(path: Path) -> frozenset[str]:
    """Whatever of a file's imports may be a module."""
    return imported(path)[0]


def test_the_list_of_packages_is_the_tree() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]["packages"]
    places = {path.parent.relative_to(ROOT) for path in SOURCES if path.name == "__init__.py"}
    assert set(declared) == {
        "warmlink" if place == FACE else ".".join(("warmlink", *place.parts)) for place in places
    }
    assert {path.parent for path in SOURCES} == {p.parent for p in SOURCES if p.name == "__init__.py"}


@pytest.mark.parametrize("folder", [*FLOORS, "benchmarks", "tests"])
def test_what_is_imported_of_ours_is_there(folder: str) -> None:
    """Also inside functions, which no other test may call."""
    missing = {
        f"{path.relative_to(ROOT)}: {module}"
        for path in sources(folder)
        for module in imported(path)[1]
        if module.startswith("warmlink.")
        for name in [module.removeprefix("warmlink.").replace(".", "/")]
        if not (ROOT / f"{name}.py").is_file() and not (ROOT / name / "__init__.py").is_file()
    }
    assert not missing


def test_data_are_installed_with_the_room_that_holds_them() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    patterns = [Path(each) for each in declared["package-data"]["*"]]
    for path in (each for floor in FLOORS for each in (ROOT / floor).rglob("*.toml")):
        room = next(each for each in path.parents if (each / "__init__.py").is_file())
        inside = path.relative_to(room)
        assert any(len(each.parts) == len(inside.parts) and inside.match(str(each)) for each in patterns), (
            f"{path.relative_to(ROOT)} is not installed: package-data in pyproject.toml does not name it"
        )


def test_the_face_is_warmlink_and_holds_nothing_but_names() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    assert declared["package-dir"]["warmlink"] == FACE.as_posix()
    assert {path.name for path in (ROOT / FACE).iterdir()} - {"__pycache__"} == {
        "__init__.py",
        "__main__.py",
        "py.typed",
    }


@pytest.mark.parametrize("floor", FLOORS)
def test_imports_point_one_way(floor: str) -> None:
    above = FLOORS[FLOORS.index(floor) + 1 :]
    for path in sources(floor):
        up = {name for name in imports(path) if name.startswith(tuple(f"warmlink.{a}" for a in above))}
        assert not up, f"{path.relative_to(ROOT)} imports {up}"


def test_what_a_component_is_knows_nothing_of_fmus() -> None:
    for path in sources("fmus/component"):
        assert not {name for name in imports(path) if "packaging" in name or "fmi" in name.lower()}, path


BELOW = {
    "orchestration/system": ("orchestration.master", "orchestration.check"),
    "orchestration/master": ("orchestration.check", "orchestration.scenarios"),
    "orchestration/master/slaves": ("master.algorithms", "master.compiled", "master.recording", "master.run"),
    "orchestration/master/algorithms": ("master.compiled", "master.recording", "master.run"),
    "orchestration/master/recording": ("master.compiled", "master.run"),
}
"""What a room must not import: the rooms that stand on it."""


@pytest.mark.parametrize("room", BELOW)
def test_a_room_does_not_import_what_stands_on_it(room: str) -> None:
    for above in BELOW[room]:
        place = above.removeprefix("orchestration.").replace(".", "/")
        there = ROOT / "orchestration" / place
        assert sources(f"orchestration/{place}") if there.is_dir() else there.with_suffix(".py").is_file()
    for path in sources(room):
        up = {n for n in imports(path) if any(f"warmlink.{a}" in n or f".{a}" in n for a in BELOW[room])}
        assert not up, f"{path.relative_to(ROOT)} imports {up}"


def test_rooms_do_not_import_each_other_in_a_circle() -> None:
    """Whoever follows a value through the rooms goes down; a room and the rooms inside it count as one."""
    below: defaultdict[Path, set[Path]] = defaultdict(set)
    floors = {ROOT / floor for floor in FLOORS}
    for path in SOURCES:
        for name in imports(path):
            file = ROOT.joinpath(*name.split(".")[1:]).with_suffix(".py")
            ends = (path.parent, file.parent)
            nested = ends[0].is_relative_to(ends[1]) or ends[1].is_relative_to(ends[0])
            if name.startswith("warmlink.") and file.is_file() and not nested and not floors & {*ends}:
                below[ends[0]].add(ends[1])
    TopologicalSorter(below).prepare()


def test_files_do_not_import_each_other_in_a_circle() -> None:
    """Also inside functions: an import that waits until it is needed is a circle all the same."""
    below: defaultdict[Path, set[Path]] = defaultdict(set)
    for path in SOURCES:
        for name in imports(path):
            file = ROOT.joinpath(*name.split(".")[1:]).with_suffix(".py")
            if name.startswith("warmlink.") and file.is_file() and file != path:
                below[path].add(file)
    TopologicalSorter(below).prepare()


@pytest.mark.parametrize("room", FLOORS)
def test_rooms_can_be_overlooked(room: str) -> None:
    for folder in {path.parent for path in sources(room)}:
        files = list(folder.glob("*.py"))
        assert len(files) <= 16, f"{folder.relative_to(ROOT)} holds {len(files)} files; it wants walls"


@pytest.mark.parametrize("room", [*FLOORS, "benchmarks", "examples", "tests"])
def test_a_file_has_one_subject(room: str) -> None:
    for path in sources(room):
        lines = len(path.read_text("utf-8").splitlines())
        assert lines <= 320, f"{path.relative_to(ROOT)} has {lines} lines; part it by subject"


def test_contributing_says_of_each_room_what_the_room_says_of_itself() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    for path in (each for room in (*FLOORS, "benchmarks") for each in sources(room)):
        if path.name != "__init__.py":
            continue
        sentence = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").partition("\n")[0]
        line = f"| `{path.parent.relative_to(ROOT)}/` | {sentence} |"
        assert line in text, f"CONTRIBUTING.md, The tree: wants the line {line}"


@pytest.mark.parametrize("path", LAWS, ids=str)
def test_equations_know_neither_fmi_nor_tables_nor_plots(path: Path) -> None:
    assert not {name.partition(".")[0] for name in imports(path)} & {*HEAVY, "pythonfmu", "matplotlib"}


def test_names_to_choose_from_are_listed_in_one_place() -> None:
    # `warmlink.fmus.names.instead` names the nearest, and cuts what would fill the screen.
    listing = re.compile(
        r"(choose|choose among|choose one of|it has|there are|known are|use|may have) \{.*join\("
    )
    for path in SOURCES:
        found = [line.strip() for line in path.read_text("utf-8").splitlines() if listing.search(line)]
        assert not found, f"{path.relative_to(ROOT)}: {found[0]}"


def test_no_code_asks_which_machine_it_has() -> None:
    """Machines differ in data: their names stand with the data, and nothing is compared with them."""
    library = ROOT / "orchestration" / "machine" / "library"
    names = {path.stem for path in library.glob("*.toml")}
    assert names
    homes = {"orchestration/machine/__init__.py", "orchestration/arm/chain.py"}
    for path in SOURCES:
        place, text = path.relative_to(ROOT).as_posix(), path.read_text("utf-8")
        if place in homes or not any(name in text for name in (*names, "WARMUP_CELL")):
            continue
        for node in ast.walk(ast.parse(text)):
            asks = isinstance(node, ast.Constant) and node.value in names
            if isinstance(node, ast.Compare):
                sides = (node.left, *node.comparators)
                asks = any(isinstance(side, ast.Name) and side.id == "WARMUP_CELL" for side in sides)
            assert not asks, f"{place}:{getattr(node, 'lineno', 0)} asks which machine it has"


def test_each_class_has_a_name_of_its_own() -> None:
    """A reader who meets a name in a trace, or asks for it, finds one thing."""
    found = defaultdict(list)
    for path in SOURCES:
        for name in re.findall(r"^class ([A-Za-z]\w*)", path.read_text("utf-8"), re.MULTILINE):
            found[name].append(str(path.relative_to(ROOT)))
    assert {name: places for name, places in found.items() if len(places) > 1} == {}


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys, warmlink.orchestration.cli as cli\n"
        "try:\n    cli.app(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('LOADED', [m for m in {HEAVY!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "LOADED []" in done.stdout
    assert "run" in done.stdout


def test_each_file_of_tests_is_imported_under_a_name_of_its_own() -> None:
    """Folders without ``__init__.py`` share one namespace, in which pytest refuses the second of a name."""
    files = defaultdict(list)
    for path in (each for each in sources("tests") if each.name.startswith("test_")):
        folder = path.parent.relative_to(ROOT) if (path.parent / "__init__.py").exists() else Path()
        files[folder / path.name].append(str(path.relative_to(ROOT)))
    assert {name: twice for name, twice in files.items() if len(twice) > 1} == {}


def test_the_project_speaks_of_itself_only() -> None:
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if tracked.returncode != 0:
        pytest.skip("not a git checkout, so there is no list of the project's files")
    home = "/" + "work" + "/"
    for name in tracked.stdout.split():
        path = ROOT / name
        if path.suffix in (".py", ".md", ".toml", ".c", ".h", ".txt", ".j2") and path.is_file():
            assert home not in path.read_text("utf-8"), f"{name} holds a path of one machine"


def test_sentences_name_arguments_that_there_are() -> None:
    """What `argument` names is one of a function outside the commands, or a field of what is given as one."""
    library = [path for path in SOURCES if {"command_line", "cli.py"}.isdisjoint(path.parts)]
    known, named = set[str](), dict[str, str]()
    for path in library:
        text = path.read_text("utf-8")
        for found in re.finditer(r"""(?<![\w.])argument\(\s*["']([\w.]+)["']""", text):
            named[found[1]] = f"{path.relative_to(ROOT)}: argument({found[1]})"
        for node in statements(ast.parse(text).body):
            if isinstance(node, ast.FunctionDef):
                known |= {each.arg for each in [*node.args.args, *node.args.kwonlyargs]}
            elif isinstance(node, ast.ClassDef):
                fields = (each.target for each in node.body if isinstance(each, ast.AnnAssign))
                known |= {each.id for each in fields if isinstance(each, ast.Name)}
    assert not {name: at for name, at in named.items() if not known.issuperset(name.split("."))}


def test_a_room_that_is_gone_is_noticed() -> None:
    with pytest.raises(AssertionError, match="fmus/parts holds no Python"):
        sources("fmus/parts")


def test_the_library_speaks_of_arguments_and_the_command_of_options() -> None:
    """`argument` gives either; a sentence with a whole command may have its options."""
    spoken = re.compile(r"(?<![\w<!-])--[a-z][a-z-]+")
    found = []
    for path in SOURCES:
        text = path.read_text("utf-8")
        if {"command_line", "cli.py"}.isdisjoint(path.parts) and spoken.search(text):
            tree = ast.parse(text)
            told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
            texts = (n for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str))
            sentences = (each for each in texts if " " in each.value and id(each) not in told)
            found += [
                f"{path.relative_to(ROOT)}:{each.lineno}: {each.value}"
                for each in sentences
                if spoken.search(each.value) and "warmlink " not in each.value
            ]
    assert not found
