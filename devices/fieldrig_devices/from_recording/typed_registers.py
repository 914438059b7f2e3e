"""Texts and floating-point numbers in the registers of a recording, where they are certain.

Modbus has no types.  A text is a run of constant registers that are read at once, all of letters, digits and the signs
of names.  A number of 32 bits (IEEE 754) that moves gives itself away by its low word, which takes values of its whole
range while the number itself moves in small steps; two registers with numbers of 16 bits each do not.
"""

import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import isfinite
from typing import Any, Final, NamedTuple

from fieldrig_devices.from_recording.register_log import Group, RegisterLog
from fieldrig_devices.from_recording.series import Change

SHORTEST_RUN, FEWEST_LETTERS, LONGEST_TEXT = 4, 2, 250
"""Registers, letters and characters of a text."""
LETTERS: Final = frozenset(b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 ._-/:+()#")
"""Characters of names, versions and serial numbers; by chance, one in 25,000 runs has nothing else."""
FEWEST_CHANGES: Final = 8
SMALLEST, LARGEST = 1e-4, 1e7
"""Magnitudes that measured values have."""
LARGEST_STEP: Final = 0.25
"""Part of its magnitude by which a number moves at once."""
LEAST_SPREAD: Final = 0xC000
"""Range that the values of a low word have to cover."""
ORDERS: Final = ("big", "little")


class Typed(NamedTuple):
    """A value in several registers."""

    words: int
    entry: dict[str, Any]
    """The keys of the register table besides address and name."""
    changes: list[Change]
    """The values of a number that moves, as 32 bits with the sign first; nothing for a text."""


def typed_values(registers: Mapping[int, RegisterLog], groups: Iterable[Group]) -> dict[int, Typed]:
    """Return the certain values by the addresses at which they begin; `groups` are read from the same space."""
    found: dict[int, Typed] = {}
    taken: set[int] = set()
    for group in sorted(groups, key=lambda group: -group.quantity):
        for address, value in _in_group(registers, group):
            addresses = range(address, address + value.words)
            if taken.isdisjoint(addresses):
                found[address] = value
                taken.update(addresses)
    return found


def _in_group(registers: Mapping[int, RegisterLog], group: Group) -> Iterator[tuple[int, Typed]]:
    end = group.address + group.quantity
    yield from _texts(registers, group.address, end)
    for address in range(group.address, end - 1):
        high, low = registers.get(address), registers.get(address + 1)
        if high is not None and low is not None and (number := _number(high, low)) is not None:
            yield address, number


def _texts(registers: Mapping[int, RegisterLog], begin: int, end: int) -> Iterator[tuple[int, Typed]]:
    address = begin
    while address < end:
        run = _run(registers, address, end)
        text = run.rstrip(b"\0")
        is_text = len(run) >= 2 * SHORTEST_RUN and b"\0" not in text
        if is_text and sum(chr(byte).isalpha() for byte in text) >= FEWEST_LETTERS:
            yield address, Typed(len(run) // 2, {"type": f"string[{len(run)}]", "initial": text.decode()}, [])
            address += len(run) // 2
        else:
            address += 1


def _run(registers: Mapping[int, RegisterLog], address: int, end: int) -> bytes:
    """Return the bytes of constant registers that may be a text: printable characters, and then zeros."""
    run = b""
    while address < end and len(run) < LONGEST_TEXT:
        register = registers.get(address)
        if register is None or register.is_moved or register.is_written or register.first is None:
            break
        word = register.first.to_bytes(2, "big")
        is_printable = LETTERS.issuperset(word.rstrip(b"\0"))
        if not is_printable or (run.endswith(b"\0") and any(word)):
            break
        run += word
        address += 1
    return run


def _number(first: RegisterLog, second: RegisterLog) -> Typed | None:
    if first.is_written or second.is_written or not (first.is_moved and second.is_moved):
        return None
    for order, (high, low) in zip(ORDERS, ((first, second), (second, first)), strict=True):
        changes = list(_joined(high.values.changes(0), low.values.changes(0)))
        if _is_number([change.value for change in changes]):
            left_out = high.values.left_out + low.values.left_out
            keys = {"type": "f32"} | ({"word_order": order} if order != "big" else {})
            return None if left_out else Typed(2, keys, changes)
    return None


def _joined(high: Sequence[Change], low: Sequence[Change]) -> Iterator[Change]:
    """Yield the values of both words, as changes of either of them."""
    words = {0: high[0].value, 1: low[0].value}
    events = sorted((change.seen_ns, change.before_ns, place, change.value)
                    for place, changes in ((0, high), (1, low)) for change in changes)  # fmt: skip
    for number, (seen_ns, before_ns, place, value) in enumerate(events):
        words[place] = value
        is_last = number + 1 == len(events) or events[number + 1][0] != seen_ns
        if is_last:
            yield Change(before_ns, seen_ns, words[0] << 16 | words[1])


def _is_number(values: Sequence[int]) -> bool:
    lows = {value & 0xFFFF for value in values}
    numbers = [_as_float(value) for value in values]
    if len(set(values)) < FEWEST_CHANGES or max(lows) - min(lows) < LEAST_SPREAD:
        return False
    if not all(isfinite(number) and SMALLEST <= abs(number) <= LARGEST for number in numbers):
        return False
    steps = [abs(later - earlier) / max(abs(earlier), abs(later)) for earlier, later in pairwise(numbers)]
    return max(steps) <= LARGEST_STEP and len({value >> 16 for value in values}) > 1


def show_float(value: int) -> str:
    """Return the shortest text that gives these 32 bits again."""
    return f"{_as_float(value):.9g}"


def _as_float(value: int) -> float:
    number: float = struct.unpack(">f", value.to_bytes(4, "big"))[0]
    return number
