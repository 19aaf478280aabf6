"""Dataclasses whose making costs a tenth: a command makes some hundred of them before it begins.

The standard decorator writes the methods of each class as text and compiles it; these share their code.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NoReturn

_MISSING: Any = dataclasses.MISSING

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, **how):
        """Do what the standard decorator does, whose arguments frozen, eq, repr and kw_only it takes."""
        return _made(cls) if cls is not None else lambda each: _made(each, **how)


def _made(cls: type, frozen: bool = False, eq: bool = True, repr: bool = True, kw_only: bool = False) -> type:
    dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)
    fields = dataclasses.fields(cls)
    compared = [each.name for each in fields if each.compare]
    key: Any = attrgetter(*compared) if compared else lambda each: ()

    def __repr__(self: Any) -> str:  # noqa: N807
        shown = (f"{each.name}={getattr(self, each.name)!r}" for each in fields if each.repr)
        return f"{type(self).__qualname__}({', '.join(shown)})"

    def __eq__(self: Any, other: object) -> bool:  # noqa: N807
        return key(self) == key(other) if type(other) is type(self) else NotImplemented

    def __hash__(self: Any) -> int:  # noqa: N807
        return hash((cls, key(self)))

    methods: dict[str, Any] = {"__init__": _initializer(cls, fields)}
    methods |= {"__repr__": __repr__} if repr else {}
    methods |= {"__eq__": __eq__, "__hash__": __hash__ if frozen else None} if eq else {}
    methods |= {"__setattr__": _refuse, "__delattr__": _refuse} if frozen else {}
    for name, method in methods.items():
        if name not in cls.__dict__:
            setattr(cls, name, method)
    return cls


def _initializer(cls: type, fields: tuple[dataclasses.Field[Any], ...]) -> Callable[..., None]:
    blank = {each.name: each.default for each in fields}
    in_order = [each.name for each in fields if not each.kw_only]
    makers: dict[str, Any] = {each.name: each.default_factory for each in fields if each.default is _MISSING}
    followed = hasattr(cls, "__post_init__")

    def __init__(self: Any, *given: Any, **named: Any) -> None:  # noqa: N807
        # The inner one refuses a value that is given twice.
        values = {**blank, **dict(**dict(zip(in_order, given, strict=False)), **named)}
        if len(values) > len(blank) or len(given) > len(in_order):
            raise TypeError(f"{cls.__qualname__}: more values than {', '.join(blank)}")
        for name, make in makers.items():
            if values[name] is _MISSING:
                if make is _MISSING:
                    raise TypeError(f"{cls.__qualname__}: {name} is missing")
                values[name] = make()
        self.__dict__.update(values)
        if followed:
            self.__post_init__()

    return __init__


def _refuse(self: object, name: str, *value: object) -> NoReturn:
    raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
