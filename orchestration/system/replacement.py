"""Another FMU in place of a part: what does not fit is said in one message, other names are given to it.

An FMU's variables are known to it by value reference, so that its names may be replaced in a copy of its
model description: whatever reads the system then finds the names that it looks for.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from warmlink.fmus.arguments import argument
from warmlink.fmus.errors import InputError
from warmlink.fmus.files import write_archive
from warmlink.fmus.names import instead
from warmlink.fmus.packaging.cache import cache_folder, undamaged, vouch
from warmlink.orchestration.shell import command
from warmlink.orchestration.system.archive import unpack
from warmlink.orchestration.system.assemble import component, connected
from warmlink.orchestration.system.check import own_unit
from warmlink.orchestration.system.description import ModelInfo, read_description
from warmlink.orchestration.system.model import Connection, FmuPart, System, Value
from warmlink.orchestration.system.units import IDENTITY, Conversion, QuantityError, Unit, conversion
from warmlink.orchestration.system.xml import parse_xml, to_bytes
from warmlink.orchestration.text_files import pair

DESCRIPTION = "modelDescription.xml"

Asked = tuple[str, Unit | None]
"""Causality and unit that a system asks of a variable."""


@dataclass(frozen=True)
class Replacements:
    """FMUs by the instance that they replace, and their own name of a variable by `instance.variable`."""

    fmus: Mapping[str, Path]
    names: Mapping[str, str]

    @classmethod
    def given(cls, fmus: list[str] | None, names: list[str] | None) -> Replacements:
        """What a command was told of them, as `link=My.fmu` and `link.heat_flow=Q`.

        Raises InputError where one does not have its form, or a name is of a part that is not replaced.
        """
        pairs = dict(pair(each, argument("replaced"), "link=My.fmu") for each in fmus or ())
        renamed = dict(pair(each, argument("names"), "link.heat_flow=Q") for each in names or ())
        for name in renamed:
            if not any(name.startswith(f"{instance}.") for instance in pairs):
                raise InputError(
                    f"{argument('names', name)}: is of no part that {argument('replaced')} names; "
                    f"{instead(name, pairs)}"
                )
        return cls({instance: Path(path) for instance, path in pairs.items()}, renamed)

    def fmu(
        self,
        instance: str,
        interface: str,
        asked: Mapping[str, Asked],
        ends: Iterable[str],
        scored: Collection[str] = (),
    ) -> Path:
        """File of the FMU that replaces an instance, under the names that are asked for.

        `interface` names the component that is replaced, `asked` is by the names of its variables, `ends` are
        full names of those in use; what is `scored` must have the unit itself, others any of its quantity.
        Raises InputError with everything that does not fit.
        """
        path = self.fmus[instance]
        info = read_description(path)
        used = {name: end for end in ends for name in asked if end == f"{instance}.{name}"}
        own = {name: self.names.get(end, name) for name, end in used.items()}
        problems = [
            (name, fault)
            for name, end in used.items()
            for fault in _faults(info, own[name], *asked[name], end in scored)
        ]
        problems += [
            (name, f"is another variable of {path.name}, so that {other} cannot be called so")
            for name, other in own.items()
            if name != other and name in info.variables and name not in own.values()
        ]
        first = {other: name for name, other in reversed(own.items())}
        problems += [
            (name, f"is to be {other}, as {first[other]} is; give each a variable of its own")
            for name, other in own.items()
            if name != first[other]
        ]
        if problems:
            told = "; ".join(f"{name} {fault}" for name, fault in problems)
            example = argument("names", {f"{instance}.{problems[0][0]}": "NAME"})
            raise InputError(
                f"{argument('replaced', {instance: str(path)})}: {told}. Where it has another name, say "
                f"{example}; see `{command('warmlink', 'list', 'interface', interface)}`"
            )
        renamed = {other: name for name, other in own.items() if name != other}
        return _renamed(path, renamed) if renamed else path

    def in_system(self, system: System) -> System:
        """A system with its parts replaced, whose start values stay; its remarks tell which are left out.

        Raises InputError where an FMU does not fit.
        """
        parts, links, remarks = dict(system.components), system.connections, [*system.remarks]
        ends = [end for each in links for end in (each.source, each.target)]
        for instance in self.fmus:
            if instance not in parts:
                raise InputError(
                    f"{argument('replaced', instance)}: no such component; {instead(instance, parts)}"
                )
            part, before = parts[instance], read_description(parts[instance].fmu)
            asked = {name: (v.causality, own_unit(before, v)) for name, v in before.variables.items()}
            renamed = [end for end in self.names if end.removeprefix(f"{instance}.") in part.values]
            path = self.fmu(instance, before.model_name, asked, [*ends, *renamed])
            values = _converted(part.values, before, read_description(path))
            parts[instance] = component(instance, path, values)
            remarks += [
                f"{instance}.{name}: {path.name} takes no such value; {value} is left out"
                for name, value in part.values.items()
                if name not in values
            ]
        touched = [each for each in links if any(name in self.fmus for name, _ in each.ends)]
        pairs = [(each.source, each.target) for each in touched]
        was, now = connected(system.components, pairs), connected(parts, pairs)
        anew = {
            link: after if link == plain else _transformed(link, system, parts)
            for link, plain, after in zip(touched, was, now, strict=True)
        }
        connections = tuple(anew.get(each, each) for each in links)
        return replace(system, components=parts, connections=connections, remarks=tuple(remarks))


def _transformed(link: Connection, system: System, parts: Mapping[str, FmuPart]) -> Connection:
    """A connection that does more than to convert units, between parts whose units may be others now."""
    (giving, output), (taking, target) = link.ends
    before, after = (
        {name: read_description(held[name].fmu) for name in (giving, taking)}
        for held in (system.components, parts)
    )
    arriving = _change(after[giving], before[giving], output).then(link.factor, link.offset)
    onward = _change(before[taking], after[taking], target)
    found = arriving.then(onward.factor, onward.offset)
    return replace(link, factor=found.factor, offset=found.offset)


def _change(before: ModelInfo, after: ModelInfo, name: str) -> Conversion:
    """Conversion of a variable's values in one FMU to those in another one; QuantityError if they differ."""
    old, new = (own_unit(info, info.variables[name]) for info in (before, after))
    relative = before.variables[name].relative
    return IDENTITY if old is None or new is None else conversion(old, new, relative)


def _converted(values: Mapping[str, Value], before: ModelInfo, after: ModelInfo) -> dict[str, Value]:
    """Start values for one FMU that another one takes too, in its units."""
    found = {}
    for name, value in values.items():
        old, new = before.variables[name], after.variables.get(name)
        if new is not None and new.settable and new.kind == old.kind:
            with suppress(QuantityError):
                change = _change(before, after, name)
                found[name] = value if change.identity else change(float(value))
    return found


NOTHING_REPLACED = Replacements({}, {})


def _faults(info: ModelInfo, name: str, causality: str, asked: Unit | None, exact: bool) -> Iterator[str]:
    """What is wrong with a variable of an FMU; `exact`: no other unit of the quantity will do."""
    unit = "" if asked is None else f" [{asked.name}]"
    if name not in info.variables:
        yield f"is missing: an {causality}{unit}"
        return
    found = info.variables[name]
    if found.causality != causality:
        yield f"is of causality {found.causality}, but an {causality}{unit} is needed"
    own = own_unit(info, found)
    if own is not None and asked is not None:
        try:
            if not conversion(own, asked).identity and exact:
                yield f"is in {own.name}, but the score is made in{unit}"
        except QuantityError:
            yield f"is in {own.name}, but{unit} is needed"


def _renamed(fmu: Path, names: Mapping[str, str]) -> Path:
    """Copy of an FMU in the cache with other names of variables."""
    folder = unpack(fmu, cache_folder() / "renamed")
    key = hashlib.sha256(json.dumps(sorted(names.items())).encode()).hexdigest()[:16]
    target = folder.with_name(f"{folder.name}-{key}") / fmu.name
    if not undamaged(target):
        found = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
        files = {name: path.read_bytes() for name, path in found.items()}
        root = parse_xml(files[DESCRIPTION], f"{fmu.name}: {DESCRIPTION}", [])
        for element in root.find("ModelVariables").iter():
            if element.get("name") in names:
                element.set("name", names[element.get("name")])
        write_archive(target, {**files, DESCRIPTION: to_bytes(root)})
        vouch(target)
    return target
