"""Values of the language as values of Python, and back.

BOOL, integers, bit strings     bool, int
REAL, LREAL                     float
STRING, WSTRING                 str
CHAR, WCHAR                     str of one character
TIME, LTIME                     int, in nanoseconds
DATE, DT, TOD                   datetime.date, datetime.datetime (UTC, without zone), datetime.time
LDATE                           datetime.date; LTOD and LDT: int, in nanoseconds
pointer, reference, interface   int, an address; to be written None, which is 0, or an instance under test
enumeration                     str, the name of the value; an int if it has none
structure, instance             dict
array                           list, in the order of the indices
"""

from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, date, datetime, time, timedelta
from math import isfinite, isinf
from typing import Any, Final

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.owner import Owner
from fieldrig_devices.iec.elementary import UNITS_NS, Elementary, Family
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.literal_texts import long_time_text, real_text, string_text
from fieldrig_devices.iec.memory import limited
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.symbols import Symbol, parts
from fieldrig_devices.iec.types import ArrayType, BlockType, EnumType, PointerType, Type, Value
from fieldrig_devices.iec.values import NoTargetError, checked

_EPOCH: Final = datetime(1970, 1, 1)  # noqa: DTZ001  dates of the language have no zone
_DAY_NS: Final = 86_400_000_000_000
_US_NS: Final = 1_000


class Placed:
    """An instance in the memory of a program under test; its address is a value of the language."""

    __slots__ = ("_address", "_bench", "_kind", "_path")

    _bench: Owner
    _path: str
    _kind: BlockType
    _address: int


def at(kind: Type, address: int, path: str = "") -> Symbol:
    """Return what is at an address as a symbol."""
    return Symbol(path, path, kind, steps=(address,))


def read(runtime: Runtime, symbol: Symbol) -> Any:
    """Return the value of a symbol; None for a reference to nothing."""
    if symbol.is_value:
        try:
            return single(symbol.type, runtime.read(symbol))
        except NoTargetError:
            return None
    inside = [part for part in parts(symbol) if part.name[:1] != "$"]
    if isinstance(symbol.type, ArrayType):
        return [read(runtime, part) for part in inside]
    return {part.name: read(runtime, part) for part in inside}


def write(runtime: Runtime, symbol: Symbol, value: Any) -> None:
    """Write a value, or those of its parts; nothing if one of them does not fit.  ArgumentError says which."""
    for part, cell in list(_cells_of(runtime, symbol, value)):
        try:
            runtime.write(part, cell)
        except ValueError as wrong:
            raise ArgumentError(*str(wrong).partition("; ")[::2]) from wrong


def single(kind: Type, value: Value) -> Any:
    """Return a value of a type with one cell."""
    if isinstance(kind, EnumType):
        return next((name for name, number in kind.values.items() if number == value), value)
    stored = storage(kind)
    if stored is Elementary.BOOL:
        return bool(value)
    if isinstance(stored, Elementary) and stored.family is Family.CHARACTER:
        return chr(int(value))
    if not isinstance(stored, Elementary) or not stored.is_time or isinstance(value, str):
        return value
    ns = int(value) * UNITS_NS[stored]
    if stored.family is Family.TIME or stored in (Elementary.LTOD, Elementary.LDT, Elementary.UNSIGNED_LDT):
        return ns
    instant = _EPOCH + timedelta(microseconds=ns // _US_NS)
    if stored in (Elementary.DATE, Elementary.LDATE, Elementary.UNSIGNED_LDATE):
        return instant.date()
    return instant.time() if stored is Elementary.TOD else instant


def _cells_of(runtime: Runtime, symbol: Symbol, value: Any) -> Iterator[tuple[Symbol, Value]]:
    """Yield the parts of a symbol with the cells that a value of Python gives them.  ArgumentError if it does not fit.

    A dict may leave out components, which then keep their values.
    """
    kind, path = symbol.type, symbol.path
    if symbol.is_value:
        yield symbol, cell_of(runtime, kind, value, path)
    elif isinstance(kind, ArrayType):
        if not isinstance(value, list | tuple) or len(value) != kind.count:
            raise ArgumentError(f"{path} cannot be {_shown(value)}", f"expected a list of {kind.count} values")
        for part, one in zip(parts(symbol), value, strict=True):
            yield from _cells_of(runtime, part, one)
    else:
        if not isinstance(value, Mapping):
            instance = f"an instance of {kind} under test, or " if isinstance(kind, BlockType) else ""
            of = "it" if instance else str(kind)
            raise ArgumentError(f"{path} cannot be {_shown(value)}", f"expected {instance}a dict with values of {of}")
        known = {part.name.lower(): part for part in parts(symbol)}
        for name, one in value.items():
            found = known.get(str(name).lower())
            if found is None:
                raise ArgumentError(f"{path} has no {name}", closest(str(name), [part.name for part in known.values()]))
            yield from _cells_of(runtime, found, one)


def cell_of(runtime: Runtime, kind: Type, value: Any, path: str) -> Value:
    """Return a value of Python as the one cell of a type.  ArgumentError for one that does not fit."""
    return checker_of(runtime, kind, path)(value)


def checker_of(runtime: Runtime, kind: Type, path: str) -> Callable[[Any], Value]:
    """Return `cell_of` for one variable."""
    symbol = Symbol(path, path, kind)
    stored = storage(kind)

    def check(value: Any) -> Value:
        try:
            return checked(_plain(runtime, kind, stored, value), symbol)
        except (ValueError, TypeError, OverflowError) as wrong:
            if isinstance(wrong, ArgumentError):
                raise
            raise ArgumentError(f"{path} cannot be {_shown(value)}", _expected(kind, wrong)) from wrong

    return check


def _plain(runtime: Runtime, kind: Type, stored: object, value: Any) -> Value:
    """Return a value of Python as one of those that cells have; what is wrong with it is found later."""
    if isinstance(kind, EnumType) and isinstance(value, str):
        numbers = {name.casefold(): number for name, number in kind.values.items()}
        if value.casefold() not in numbers:
            raise ValueError(f"expected one of {', '.join(kind.values)}")
        return numbers[value.casefold()]
    if isinstance(kind, PointerType) and value is None:
        return 0
    if isinstance(kind, PointerType) and isinstance(kind.to, BlockType):
        return _address(runtime, kind.to, value)
    if isinstance(kind, PointerType) and type(value) is not int:
        raise ValueError("expected None; only the program itself, or a TEST block, can give one of its variables")
    if stored is Elementary.BOOL and type(value) is not bool:
        raise ValueError("expected True or False")
    if isinstance(stored, Elementary) and stored.family is Family.CHARACTER:
        if not isinstance(value, str) or len(value) != 1 or ord(value) > stored.high:
            raise ValueError(f"expected a text of one character up to {chr(int(stored.high))!a}")
        return ord(value)
    if isinstance(stored, Elementary) and stored.is_time:
        counts = _counts(stored, value)
        if not stored.low <= counts <= stored.high and not isinstance(value, int):
            raise ValueError(f"expected {single(kind, stored.low)} to {single(kind, stored.high)}")
        return counts
    if isinstance(stored, Elementary) and not stored.is_real and isinstance(value, float):
        raise ValueError("expected a whole number")
    if (
        stored is Elementary.REAL
        and isinstance(value, int | float)
        and isfinite(value)
        and isinf(float(limited(value, stored)))
    ):
        raise ValueError("expected at most 3.402823E38")
    if not isinstance(value, bool | int | float | str):
        raise ValueError(f"expected a value of {kind}")
    return value


def _address(runtime: Runtime, to: BlockType, value: Any) -> int:
    """Return the address of an instance, for a pointer to its block, to one that it extends, or to an interface."""
    if type(value) is int:
        return value
    if not isinstance(value, Placed):
        raise ValueError(f"expected None, or an instance of {to} under test")
    if value._bench.runtime is not runtime:
        raise ValueError("expected an instance of this program, not of another one")
    pou = value._kind.pou
    if to.name.casefold() not in {value._kind.name.casefold(), *(pou.also if pou is not None else ())}:
        raise ValueError(f"expected an instance of {to}, not one of {value._kind}")
    return value._address


def _counts(stored: Elementary, value: Any) -> int:
    """Return a time or a date in the unit of its type."""
    ns: int
    match value:
        case datetime():
            plain = value.astimezone(UTC).replace(tzinfo=None) if value.tzinfo is not None else value
            ns = (plain - _EPOCH) // timedelta(microseconds=1) * _US_NS
        case date():
            ns = (datetime(value.year, value.month, value.day) - _EPOCH).days * _DAY_NS  # noqa: DTZ001
        case time():
            ns = (value.hour * 3600 + value.minute * 60 + value.second) * 1_000_000_000 + value.microsecond * _US_NS
        case timedelta():
            ns = value // timedelta(microseconds=1) * _US_NS
        case bool() | str() | float():
            raise ValueError('expected a time in nanoseconds, such as T("10ms")')
        case int():
            ns = value
        case _:
            raise ValueError('expected a time in nanoseconds, such as T("10ms")')
    if ns % UNITS_NS[stored]:
        raise ValueError(f"expected a multiple of {UNITS_NS[stored]} ns, the unit of {stored}")
    return ns // UNITS_NS[stored]


def literal(value: Any) -> str:
    """Return a value of Python as a constant of the language.  ArgumentError for one that has no single value."""
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case int():
            return str(value)
        case float() if isfinite(value):
            return real_text(value)
        case str() if value.isascii():
            return string_text(value)
        case timedelta():
            return long_time_text(value // timedelta(microseconds=1) * _US_NS).replace("LTIME", "T")
    raise ArgumentError(
        f"{_shown(value)} cannot be a constant", "expected a number, a text, True, False or a timedelta"
    )


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _expected(kind: Type, wrong: Exception) -> str:
    text = str(wrong).partition(": ")[2] or str(wrong)
    return text if text.startswith("expected") else f"expected a value of {kind}"
