"""The times of the answers of a Modbus device, each as a recording has it: a CSV file with a row for each answer.

Requests of one kind take the times of its rows in turn, and begin again after the last one, so that not only the usual
time of a device is that of the machine, but also its longest one, and how often it comes.  A row without a time is a
request that is lost.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.sources.sheet import Sheet, read_sheet

LONGEST_MS: Final = 60_000
FUNCTION, ADDRESS, QUANTITY, TIME, UNIT = COLUMNS = "function", "address", "quantity", "answer_ms", "unit"
_HIGHEST: Final = {FUNCTION: 127, ADDRESS: 0xFFFF, QUANTITY: 0xFFFF, UNIT: 255}
ADDRESSED: Final = frozenset({1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 24})
"""Functions that name an address."""
SINGLE: Final = frozenset({5, 6, 22, 24})
"""Functions that name one register, bit or queue, and no quantity."""


class Kind(NamedTuple):
    """The requests that take the same times: those of a unit, a function, a first address and a quantity.

    None stands for any.
    """

    unit: int | None
    function: int | None
    address: int | None
    quantity: int | None

    @property
    def wider(self) -> Iterator["Kind"]:
        """The kinds that a request of this one belongs to, the narrowest first."""
        for unit in (self.unit, None):
            yield Kind(unit, *self[1:])
            yield Kind(unit, self.function, self.address, None)
            yield Kind(unit, self.function, None, None)
            yield Kind(unit, None, None, None)


def kind_of(unit: int | None, pdu: bytes) -> Kind:
    """Return the narrowest kind of a request, which may be shorter than its function wants, to a unit."""
    function = pdu[0] if pdu else None
    if function not in ADDRESSED or len(pdu) < 3:
        return Kind(unit, function, None, None)
    address = int.from_bytes(pdu[1:3], "big")
    quantity = int.from_bytes(pdu[3:5], "big") if function not in SINGLE and len(pdu) >= 5 else 1
    return Kind(unit, function, address, quantity)


class AnswerTimes:
    """The next time of each kind of request."""

    def __init__(self, times_ns: Mapping[Kind, Sequence[int | None]], usual_ns: int) -> None:
        """`usual_ns` is the time of the requests that `times_ns` has no kind for."""
        self._times_ns, self._usual_ns = times_ns, usual_ns
        self._taken: defaultdict[Kind, int] = defaultdict(int)

    def next_ns(self, request: ModbusRequest) -> int | None:
        """Return the time that the answer to this request takes, or None if it is lost, and go on to the next one."""
        for kind in kind_of(request.unit, request.pdu).wider:
            times_ns = self._times_ns.get(kind)
            if times_ns is not None:
                place = self._taken[kind]
                self._taken[kind] = (place + 1) % len(times_ns)
                return times_ns[place]
        return self._usual_ns


def read_answer_times(file: Path) -> dict[Kind, list[int | None]]:
    """Read the times in nanoseconds by kind.  ValueError, with the line, for a file that has none."""
    sheet = read_sheet(file)
    times_ns: defaultdict[Kind, list[int | None]] = defaultdict(list)
    kinds = zip(*(_numbers(sheet, column) for column in (UNIT, FUNCTION, ADDRESS, QUANTITY)), strict=True)
    for numbers, (line, cell) in zip(kinds, sheet.cells(TIME), strict=True):
        time_ms = sheet.number(cell) if cell else None
        if cell and (time_ms is None or not 0 <= time_ms <= LONGEST_MS):
            raise ValueError(f"line {line}: expected 0 to {LONGEST_MS} in column {TIME!r}, got {cell!r}")
        kind = Kind(*numbers)
        given = [number is not None for number in numbers[1:]]
        if given != sorted(given, reverse=True):
            raise ValueError(f"line {line}: expected a function where there is an address, and that for a quantity")
        times_ns[kind].append(None if time_ms is None else round(time_ms * MS))
    return dict(times_ns)


def _numbers(sheet: Sheet, column: str) -> Iterator[int | None]:
    """Yield the whole numbers of a column, which may be missing or have empty cells: any."""
    if column not in sheet.names:
        yield from (None for _ in sheet.rows)
        return
    for line, cell in sheet.cells(column):
        number = sheet.number(cell) if cell else None
        if cell and (number is None or not number.is_integer() or not 0 <= number <= _HIGHEST[column]):
            raise ValueError(f"line {line}: expected 0 to {_HIGHEST[column]} in column {column!r}, got {cell!r}")
        yield None if number is None else int(number)
