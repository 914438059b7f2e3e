"""Objects that a master may write, and that show points of a device which others set as well.

A read returns the value of the point and not the last one that came from the network.  What a program of the device
drives refuses a write with 0800 0022h, "because of the present device state" (CiA 301, table 22).  Objects of a device
profile (from 6000h on) show their own value, as CiA 401 has it, unless the program drives them.
"""

from collections.abc import Callable, Mapping

from fieldrig.device import Point
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import Boolean, Integer, Real, clamp
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable

PROFILE = 0x6000
"""The first index of the objects of a device profile."""


def show_points(
    dictionary: Dictionary,
    points: Mapping[str, str],
    find: Callable[[str], Point | None],
    why_refused: Callable[[str], str],
) -> None:
    """Let the writable objects of `points`, which are names by object or bit, show the points."""
    bits: dict[str, dict[int, str]] = {}
    for key, name in points.items():
        of, dot, bit = key.partition(".")
        variable = dictionary.by_key(of)
        if not variable.access.is_writable:
            continue
        if dot:
            bits.setdefault(of, {})[int(bit)] = name
        else:
            _show_value(variable, name, find, why_refused)
    for of, names in bits.items():
        _show_bits(dictionary.by_key(of), names, find, why_refused)


def _show_value(
    variable: Variable, name: str, find: Callable[[str], Point | None], why_refused: Callable[[str], str]
) -> None:
    def read() -> bytes:
        point = find(name)
        if point is None or (variable.index >= PROFILE and not why_refused(name)):
            return variable.data
        value, kind = point.read(), variable.type
        if isinstance(value, str) or not isinstance(kind, Boolean | Integer | Real):
            return variable.data
        if isinstance(kind, Integer):
            return kind.encode(round(clamp(value, kind.low, kind.high)))
        return kind.encode(bool(value) if isinstance(kind, Boolean) else float(value))

    def write(data: bytes) -> None:
        if why_refused(name):
            raise Abort(Code.DEVICE_STATE)
        point, value = find(name), variable.type.decode(data)
        if variable.index < PROFILE and point is not None and point.write is not None:
            try:
                point.write(value)
            except ValueError as refused:
                raise Abort(Code.INVALID_VALUE) from refused
        variable.set(data)

    variable.reader, variable.writer = read, write


def _show_bits(
    variable: Variable,
    names: Mapping[int, str],
    find: Callable[[str], Point | None],
    why_refused: Callable[[str], str],
) -> None:
    """Let the bits that the program drives show what it has set; a write keeps them, and serves the others."""

    def read() -> bytes:
        number = variable.number
        for bit, name in names.items():
            point = find(name) if why_refused(name) else None
            if point is not None:
                number = number & ~(1 << bit) | bool(point.read()) << bit
        return number.to_bytes(len(variable.data), "little")

    def write(data: bytes) -> None:
        driven = sum(1 << bit for bit, name in names.items() if why_refused(name))
        present, wanted = int.from_bytes(read(), "little"), int.from_bytes(data, "little")
        if (present ^ wanted) and not (present ^ wanted) & ~driven:
            raise Abort(Code.DEVICE_STATE)
        variable.set((wanted & ~driven | present & driven).to_bytes(len(data), "little"))

    variable.reader, variable.writer = read, write
