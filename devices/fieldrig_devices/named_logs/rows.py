"""The rows of a log in the order of time, in constant memory.

The row of a dialogue is complete when its last message came, and is shown at its first.  So later rows wait for it, up
to a bound: beyond that, the row says that the dialogue is still open.  If it is completed after all, it gets another
row then.
"""

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig.clock import S
from fieldrig.traces.names import Namer
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.canopen.names import CanopenNames
from fieldrig_devices.dialogues import Dialogue, ModbusDialogues, ModbusExchange, SdoDialogues, SdoTransfer, Stray
from fieldrig_devices.modbus.names import ModbusNames
from fieldrig_devices.named_logs.can_rows import CanRows
from fieldrig_devices.named_logs.modbus_rows import ModbusRows
from fieldrig_devices.named_logs.named_log import NamedLog, decoded
from fieldrig_devices.named_logs.row import Row, row_of
from fieldrig_devices.named_logs.sdo_rows import sdo_row

MOST_HELD: Final = 20_000
"""Rows that wait for a dialogue."""
PATIENCE_NS: Final = 10 * S
"""How long they wait, in the time of the log."""
MOST_BUSES: Final = 256
"""Buses whose names are remembered."""


@dataclass(slots=True)
class _Place:
    """The place of a message among the rows."""

    entry: TraceEntry
    row: Row | None = None
    """The row, as soon as it is known."""
    is_part: bool = False
    """True if the message belongs to the row of another one."""


class _PlainRows:
    """Makes the rows of a bus of any other family."""

    def __init__(self, namer: Namer) -> None:
        self._namer = namer

    def row(self, number: int, entry: TraceEntry) -> Row:
        try:
            named = self._namer(decoded(entry), entry.sender)
        except ValueError:
            return row_of(number, entry, (entry.family,), "", "", entry.data.hex(" "))
        return row_of(number, entry, (entry.family,), named.kind, named.node, named.text)


BusRows = CanRows | ModbusRows | _PlainRows


class Rows:
    """Makes the rows of a log."""

    def __init__(self, names: NamedLog, *, every_frame: bool = False, has_values: bool = False) -> None:
        """Each message has a row if `every_frame`, and CAN frames have their values one by one if `has_values`."""
        self._names, self._every_frame, self._has_values = names, every_frame, has_values
        self._buses: OrderedDict[tuple[str, str], BusRows] = OrderedDict()
        self._sdo, self._modbus = SdoDialogues(), ModbusDialogues()
        self._places: OrderedDict[int, _Place] = OrderedDict()
        self._extra = 0
        self._late: dict[int, TraceEntry] = {}
        """The first messages of dialogues that later rows wait for no longer."""

    def learn(self, entries: Iterable[TraceEntry]) -> None:
        """Take what was configured before the log: mappings of PDOs, channels, heartbeats, device types."""
        for number, entry in enumerate(entries):
            rows = self._rows(entry)
            if isinstance(rows, CanRows):
                for dialogue in self._sdo.take(number, entry):
                    if isinstance(dialogue, SdoTransfer):
                        rows.take(dialogue)
        self._sdo.unfinished()

    def of(self, entries: Iterable[TraceEntry]) -> Iterator[Row]:
        """Yield the rows of these messages."""
        for number, entry in enumerate(entries):
            row = None if self._places else self._alone(number, entry)
            if row is not None:
                yield row
            else:
                yield from self._take(number, entry)
        for dialogue in (*self._sdo.unfinished(), *self._modbus.unfinished()):
            yield from self._end(dialogue)
        yield from self._ready(None)

    def _alone(self, number: int, entry: TraceEntry) -> Row | None:
        """Return the row of a PDO when nothing waits, as `_take` does in more steps; None for all other messages."""
        rows = self._rows(entry)
        if not isinstance(rows, CanRows) or entry.time_ns >= rows.next_loss_ns or self._sdo.is_of_channel(entry):
            return None
        return rows.pdo(number, entry)

    def _take(self, number: int, entry: TraceEntry) -> Iterator[Row]:
        rows = self._rows(entry)
        if isinstance(rows, CanRows):
            if entry.time_ns >= rows.next_loss_ns:
                for row in rows.losses(entry):
                    self._add(row, entry)
            ended: Sequence[Dialogue] = self._sdo.take(number, entry)
            is_dialogue, is_part = self._sdo.is_concerned, self._sdo.went_on
        elif isinstance(rows, ModbusRows):
            ended = self._modbus.take(number, entry)
            is_dialogue, is_part = self._modbus.is_concerned, False
        else:
            ended, is_dialogue, is_part = (), False, False
        place = self._places[number] = _Place(entry, None, is_part and not self._every_frame)
        for dialogue in ended:
            yield from self._end(dialogue)
        if self._every_frame or not is_dialogue:
            place.row = row = rows.row(number, entry)
            if isinstance(rows, CanRows) and (back := rows.heard(row)) is not None:
                self._add(back, entry)
        yield from self._ready(entry)

    def _add(self, row: Row, entry: TraceEntry) -> None:
        """Add a row that is no message."""
        self._extra -= 1
        self._places[self._extra] = _Place(entry, row)

    def _rows(self, entry: TraceEntry) -> BusRows:
        bus = entry.bus, entry.family
        rows = self._buses.get(bus)
        if rows is None:
            namer = self._names.namer(entry.bus, entry.family)
            rows = self._buses[bus] = _rows_of(namer, self._has_values)
            if isinstance(namer, CanopenNames):
                self._sdo.describe(entry.bus, namer.dictionaries)
            if len(self._buses) > MOST_BUSES:
                self._buses.popitem(last=False)
        return rows

    def _end(self, dialogue: Dialogue) -> Iterator[Row]:
        """Put the row of a dialogue at its first message; yield it if that place has been left."""
        first = dialogue.entries[0]
        place = self._places.get(first)
        entry = self._late.pop(first, None) if place is None else place.entry
        row = None if entry is None else self._row(dialogue, entry)
        if row is None or self._every_frame or (place is None and dialogue.end_ns is None):
            return
        for number in dialogue.entries:
            part = self._places.get(number)
            if part is not None:
                part.is_part = True
        if place is None:
            yield row
        else:
            place.row, place.is_part = row, False

    def _row(self, dialogue: Dialogue, entry: TraceEntry) -> Row | None:
        rows = self._rows(entry)
        if isinstance(dialogue, SdoTransfer) and isinstance(rows, CanRows):
            rows.take(dialogue)
            return sdo_row(dialogue, entry, rows.names)
        if isinstance(dialogue, ModbusExchange) and isinstance(rows, ModbusRows):
            return rows.exchange(dialogue, entry)
        if isinstance(dialogue, Stray):
            return self._stray(dialogue, entry, rows)
        return None

    def _stray(self, stray: Stray, entry: TraceEntry, rows: BusRows) -> Row:
        row = rows.row(stray.entries[0], entry)
        if stray.why not in row.text:
            row.text += f" ({stray.why})"
        row.services += ("stray",)
        return row

    def _still_open(self, number: int, entry: TraceEntry) -> Row:
        row = self._rows(entry).row(number, entry)
        row.text += " (still open)"
        row.services += ("unanswered",)
        return row

    def _ready(self, entry: TraceEntry | None) -> Iterator[Row]:
        """Yield the rows that wait for nothing; all of them if there is no next message."""
        places = self._places
        while places:
            number, place = next(iter(places.items()))
            if place.row is None and not place.is_part:
                if entry is None or not self._is_too_long(place, entry):
                    return
                self._late[number] = place.entry
                place.row = self._still_open(number, place.entry)
            del places[number]
            if place.row is not None and not place.is_part:
                yield place.row

    def _is_too_long(self, place: _Place, entry: TraceEntry) -> bool:
        return len(self._places) > MOST_HELD or entry.time_ns > place.entry.time_ns + PATIENCE_NS


def _rows_of(namer: Namer, has_values: bool) -> BusRows:
    if isinstance(namer, CanopenNames):
        return CanRows(namer, has_values=has_values)
    return ModbusRows(namer) if isinstance(namer, ModbusNames) else _PlainRows(namer)
