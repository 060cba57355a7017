"""Frozen records whose classes cost next to nothing to make.

There are some hundred and fifty syntax nodes and diagnostics, of which a run meets a few. A
dataclass writes and compiles its methods when its class is made, about half a millisecond each;
here all classes share theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar, dataclass_transform

R = TypeVar("R", bound="_Base")


class _RecordType(type):
    """Collects the annotated fields of a class, those of its base first, and gives it slots."""

    record_fields: tuple[str, ...]
    record_defaults: dict[str, Any]
    record_setters: tuple[Callable[[Any, Any], None], ...]

    def __new__(mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> _RecordType:
        annotated: dict[str, str] = namespace.get("__annotations__", {})
        own = tuple(n for n, text in annotated.items() if not text.startswith("ClassVar"))
        defaults = {n: namespace.pop(n) for n in own if n in namespace}
        base = bases[0] if bases else None
        if isinstance(base, _RecordType):
            fields, defaults = base.record_fields + own, base.record_defaults | defaults
        else:
            fields = own
        namespace["__slots__"], namespace["__match_args__"] = own, fields
        cls = super().__new__(mcs, name, bases, namespace)
        cls.record_fields, cls.record_defaults = fields, defaults
        cls.record_setters = tuple(getattr(cls, field).__set__ for field in fields)
        return cls


class _Base(metaclass=_RecordType):
    """The methods of all records."""

    def __init__(self, *args: Any, **values: Any) -> None:
        cls = type(self)
        if values or len(args) != len(cls.record_setters):
            args = tuple(_complete(cls, args, values))
        for put, value in zip(cls.record_setters, args, strict=True):
            put(self, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"cannot assign to `{name}`: {type(self).__name__} is frozen")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"cannot delete `{name}`: {type(self).__name__} is frozen")

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self.__getstate__() == other.__getstate__()

    def __hash__(self) -> int:
        return hash((type(self).__name__, *self.__getstate__()))

    def __repr__(self) -> str:
        named = (f"{name}={getattr(self, name)!r}" for name in type(self).record_fields)
        return f"{type(self).__name__}({', '.join(named)})"

    def __getstate__(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in type(self).record_fields)

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        for put, value in zip(type(self).record_setters, state, strict=True):
            put(self, value)


@dataclass_transform(frozen_default=True)
class Record(_Base):
    """A record whose fields are given by position or name; equal when all its fields are."""


@dataclass_transform(frozen_default=True, kw_only_default=True)
class NamedRecord(_Base):
    """A record whose fields are given by name."""


def _complete(cls: type[_Base], args: tuple[Any, ...], values: dict[str, Any]) -> Iterator[Any]:
    """All fields of a new record, in order. Raises TypeError like any other call."""
    left = cls.record_fields[len(args) :]
    wrong = [name for name in values if name not in left]
    wrong += [name for name in left if name not in values and name not in cls.record_defaults]
    if wrong or len(args) > len(cls.record_fields):
        raise TypeError(f"{cls.__name__}({', '.join(cls.record_fields)}): check {wrong or args}")
    yield from args
    for name in left:
        yield values[name] if name in values else cls.record_defaults[name]


def changed(record: R, **changes: object) -> R:
    """The record with some fields changed. Raises TypeError for a field it doesn't have."""
    cls = type(record)
    values = dict(zip(cls.record_fields, record.__getstate__(), strict=True))
    return cls(**{**values, **changes})
