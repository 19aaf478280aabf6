"""Dataclasses whose making costs a fraction: a command makes some hundred of them before it begins.

The standard decorator writes each method of each class as text and compiles it; here `__init__` alone is
made so, and what else a class has is shared code.
"""

from __future__ import annotations

import dataclasses
from operator import attrgetter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, **how):
        """Do what the standard decorator does, whose arguments frozen, eq, repr and kw_only it takes."""
        return _made(cls) if cls is not None else lambda each: _made(each, **how)


def _made(cls: type, frozen: bool = False, eq: bool = True, repr: bool = True, kw_only: bool = False) -> type:
    dataclasses.dataclass(repr=False, eq=False, kw_only=kw_only)(cls)
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

    methods: dict[str, Any] = {"__repr__": __repr__} if repr else {}
    methods |= {"__eq__": __eq__, "__hash__": __hash__ if frozen else None} if eq else {}
    methods |= {"__setattr__": _set_once, "__delattr__": _set_once} if frozen else {}
    for name, method in methods.items():
        if name not in cls.__dict__:
            setattr(cls, name, method)
    return cls


def _set_once(self: Any, name: str, *value: object) -> None:
    """Take each field's first value, from `__init__`, and nothing after it."""
    if not value or name in self.__dict__ or name not in self.__dataclass_fields__:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
    self.__dict__[name] = value[0]
