"""The times of the answers of a Modbus device, each as a recording has it: a CSV file with a row for each answer.

Requests of one kind take the times of its rows in turn, and begin again after the last one, so that not only the usual
time of a device is that of the machine, but also its longest one, and how often it comes.  A row without a time is a
request that is lost, and one with an exception is refused.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.sources.sheet import Sheet, read_sheet

LONGEST_MS: Final = 60_000
FUNCTION, ADDRESS, QUANTITY, TIME, EXCEPTION, UNIT = "function", "address", "quantity", "answer_ms", "exception", "unit"
_HIGHEST: Final = {FUNCTION: 127, ADDRESS: 0xFFFF, QUANTITY: 0xFFFF, EXCEPTION: 255, UNIT: 255}
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


class Answer(NamedTuple):
    """An answer to a request."""

    after_ns: int | None
    """The time that it takes; None if the request is lost."""
    exception: int = 0
    """The code with which the request is refused; 0 if it is carried out."""


class AnswerTimes:
    """The next answer to each kind of request."""

    def __init__(self, answers: Mapping[Kind, Sequence[Answer]], usual_ns: int) -> None:
        """`usual_ns` is the time of the requests that `answers` has no kind for."""
        self._answers, self._usual = answers, Answer(usual_ns)
        self._taken: defaultdict[Kind, int] = defaultdict(int)

    def next(self, request: ModbusRequest) -> Answer:
        """Return the answer to this request, and go on to the next one of its kind."""
        for kind in kind_of(request.unit, request.pdu).wider:
            answers = self._answers.get(kind)
            if answers is not None:
                place = self._taken[kind]
                self._taken[kind] = (place + 1) % len(answers)
                return answers[place]
        return self._usual


def read_answer_times(file: Path) -> dict[Kind, list[Answer]]:
    """Read the answers by kind.  ValueError, with the line, for a file that has none."""
    sheet = read_sheet(file)
    answers: defaultdict[Kind, list[Answer]] = defaultdict(list)
    kinds = zip(*(_numbers(sheet, column) for column in (UNIT, FUNCTION, ADDRESS, QUANTITY)), strict=True)
    exceptions = _numbers(sheet, EXCEPTION)
    for numbers, exception, (line, cell) in zip(kinds, exceptions, sheet.cells(TIME), strict=True):
        time_ms = sheet.number(cell) if cell else None
        if cell and (time_ms is None or not 0 <= time_ms <= LONGEST_MS):
            raise ValueError(f"line {line}: expected 0 to {LONGEST_MS} in column {TIME!r}, got {cell!r}")
        kind = Kind(*numbers)
        given = [number is not None for number in numbers[1:]]
        if given != sorted(given, reverse=True):
            raise ValueError(f"line {line}: expected a function where there is an address, and that for a quantity")
        answers[kind].append(Answer(None if time_ms is None else round(time_ms * MS), exception or 0))
    return dict(answers)


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
