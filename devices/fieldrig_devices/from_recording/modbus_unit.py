"""A unit of a recording as a Modbus device: its register table, its recorded values, and what it refuses."""

from collections.abc import Iterator, Mapping
from itertools import chain, groupby
from pathlib import PurePosixPath
from typing import Any, Final

from pydantic import ValidationError

from fieldrig.clock import MS
from fieldrig.points.values import counted
from fieldrig.text.flow import flow
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.identification import EXTENDED, LAST_OBJECT, REGULAR, Identification, ServerId
from fieldrig_devices.from_recording.answer_times import AnswerTimes
from fieldrig_devices.from_recording.columns import TIME, Column, column_from, column_of
from fieldrig_devices.from_recording.modbus_log import UnitLog
from fieldrig_devices.from_recording.modbus_refusals import ModbusRefusals
from fieldrig_devices.from_recording.parts import ReadBack, comment
from fieldrig_devices.from_recording.register_log import BITS, READERS, RegisterLog
from fieldrig_devices.from_recording.typed_registers import Typed, show_float, typed_values
from fieldrig_devices.from_recording.unit_words import seen, unknown, use_words
from fieldrig_devices.registers.table import SPACES

SHORT: Final = {"coils": "coil", "discrete_inputs": "input", "holding_registers": "h", "input_registers": "i"}
"""The words with which the names of values begin."""
TEXTS: Final = ("vendor_name", "product_code", "revision", "vendor_url", "product_name", "model_name",
                "user_application_name")  # fmt: skip
"""The keys of `identification` by the ids of function 43/14."""
MOST_READ_BACKS: Final = 8


class UnitModel:
    """One unit, as it is written."""

    def __init__(
        self,
        name: str,
        unit_id: int,
        asked_as: int,
        log: UnitLog,
        during_ns: tuple[int, int],
        line: LineTiming | None = None,
    ) -> None:
        """`during_ns` are the instants from which the unit is on, and at which the recording ends.

        `asked_as` is the unit id of the recording, which is another one for a unit that has none of its own.

        `line` is the timing of the serial line that it is on.
        """
        self._line = line
        begin_ns, end_ns = during_ns
        self.name, self.unit_id, self.asked_as, self.log = name, unit_id, asked_as, log
        self.remarks: list[str] = []
        self.columns: dict[str, Column] = {}
        self.recorded = PurePosixPath("recorded", f"{name}.csv")
        self.answer_times = PurePosixPath("recorded", f"{name}-answers.csv")
        self.entries = {space: self._entries(space, log.spaces[space], begin_ns) for space in SPACES}
        self.more = self._more()
        refusals = ModbusRefusals(log, self.entries, self.more)
        last_ns = end_ns - log.longest_answer_ns
        silences = log.silences.faults(begin_ns, last_ns)
        self.times = AnswerTimes(log, self._on_line_ns, last_ns, refusals.at_times)
        self.faults = [*silences, *refusals.faults]
        self.silences = len(silences)
        self.remarks += refusals.remarks

    @property
    def turnaround_ms(self) -> float:
        """The usual time from a request to its answer."""
        return float(f"{self.times.usual_ns / MS:.3g}")

    def _on_line_ns(self, size: int) -> int:
        """Return the time that an answer itself takes, which the emulated line adds."""
        return 0 if self._line is None else self._line.frame_ns(size)

    def _entries(self, space: str, registers: Mapping[int, RegisterLog], begin_ns: int) -> list[dict[str, Any]]:
        groups = [group for group in self.log.groups if READERS.get(group.function) == space]
        typed = {} if space in BITS else typed_values(registers, groups)
        taken = {address + place for address, value in typed.items() for place in range(value.words)}
        entries: list[dict[str, Any]] = []
        for address in sorted(registers):
            head: dict[str, Any] = {"address": address, "name": f"{SHORT[space]}{address}"}
            if address in typed:
                entries.append(head | self._typed(head["name"], typed[address], begin_ns))
            elif address not in taken:
                entries.append(head | self._value(head["name"], registers[address], begin_ns, is_bit=space in BITS))
        return _joined(entries)

    def _typed(self, name: str, value: Typed, begin_ns: int) -> dict[str, Any]:
        if not value.changes:
            return value.entry
        return value.entry | self._live(name, column_from(value.changes, 0, begin_ns, show_float))

    def _value(self, name: str, register: RegisterLog, begin_ns: int, *, is_bit: bool) -> dict[str, Any]:
        """Return the keys of a register or bit that has no type."""
        written = register.written
        column = column_of(register.values, begin_ns, str, written=written) if register.is_moved else None
        if column is not None and column.left_out:
            self.remarks.append(f"{name} changed {counted(column.left_out, 'time')} more than its column has")
        if column is not None and column.moves:
            return self._live(name, column) | ({"access": "rw"} if register.is_written else {})
        return {"initial": bool(register.start) if is_bit else register.start} if register.start else {}

    def _live(self, name: str, column: Column) -> dict[str, Any]:
        self.columns[name] = column
        return {"source": {"kind": "replay", "file": f"../{self.recorded}", "column": name, "time_column": TIME}}

    def _more(self) -> dict[str, Any]:
        """Return the further keys of the device."""
        more: dict[str, Any] = {}
        texts = {number: text.decode("ascii", "replace") for number, text in self.log.identification.items()}
        if texts:
            known: dict[str, Any] = {key: texts[number] for number, key in enumerate(TEXTS) if number in texts}
            extended = {number: text for number, text in texts.items() if number >= 0x80}
            known |= {"extended": extended} if extended else {}
            self._take(more, "identification", Identification, known | self._further_texts(texts))
        if self.log.server_id is not None:
            self._take(more, "server_id", ServerId, _server_id(self.log.server_id))
        if self.log.status is not None:
            more["exception_status"] = self.log.status
        return more

    def _further_texts(self, texts: Mapping[int, str]) -> dict[str, Any]:
        """Return an empty text for those of a level that the unit has, and that no master has read."""
        level, highest = self.log.identified_as, max(texts)
        if level not in (REGULAR, EXTENDED) or highest > LAST_OBJECT[level - 1]:
            return {}
        self.remarks.append(f"the texts of level {level} of its identification: an empty one stands for them")
        return {"vendor_url": ""} if level == REGULAR else {"extended": {LAST_OBJECT[REGULAR] + 1: ""}}

    def _take(self, more: dict[str, Any], key: str, model: type[Any], value: dict[str, Any]) -> None:
        try:
            model.model_validate(value)
        except ValidationError:
            self.remarks.append(f"its {key.replace('_', ' ')} has characters that the key {key} does not take")
            return
        more[key] = value

    # ---- words and files

    def table(self, source: str) -> bytes:
        """Return the register table."""
        lines = [f"# Unit {self.asked_as} of the recording {source}. Addresses are as on the wire, from 0."]
        for group, log in sorted(self.log.groups.items()):
            lines += comment(use_words(group, log), 0)
        for space in SPACES:
            if self.entries[space]:
                lines += ["", f"{space}:", *(f"  - {flow(entry)}" for entry in self.entries[space])]
        return ("\n".join(lines) + "\n").encode()

    def words_seen(self) -> Iterator[str]:
        """Yield what the recording says of the unit."""
        yield from seen(self.log, self.asked_as, self.unit_id, self.turnaround_ms, self.silences)
        if own := len(self.times.single):
            yield f"{counted(own, 'kind')} of requests had other times or answers: see {self.answer_times}"

    def words_unknown(self) -> Iterator[str]:
        """Yield what is not known, or not repeated."""
        return chain(self.remarks, unknown(self.log))

    def read_backs(self, bus: str) -> Iterator[ReadBack]:
        """Yield requests whose answers stay the same."""
        count = 0
        for group, log in sorted(self.log.groups.items()):
            space = READERS.get(group.function)
            if space is None or log.sample is None or log.refused or group.function == 23 or count == MOST_READ_BACKS:
                continue
            registers = self.log.spaces[space]
            logs = [registers[address] for address in group.addresses if address in registers]
            if any(register.is_moved or register.is_written for register in logs):
                continue
            request, response = log.sample
            count += 1
            yield ReadBack(bus, self.unit_id, request.hex(" "), response.hex(" "))


def _joined(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the entries with runs of plain zeros as one entry each, as a table of hundreds of them reads badly."""
    joined: list[dict[str, Any]] = []
    for is_plain, run in groupby(entries, lambda entry: len(entry) == 2):
        pending = list(run)
        while is_plain and pending:
            length = next(
                (
                    place
                    for place in range(1, len(pending))
                    if pending[place]["address"] != pending[0]["address"] + place
                ),
                len(pending),
            )
            joined.append(pending[0] | ({"count": length} if length > 1 else {}))
            del pending[:length]
        joined += pending
    return joined


def _server_id(data: bytes) -> dict[str, Any]:
    """Return the keys for the answer of function 17: an id of one byte, the run indicator, and text.

    The standard leaves the length of the id to the maker; the first byte that is 00h or FFh after it is the indicator.
    """
    at = next((place for place in range(1, len(data)) if data[place] in (0x00, 0xFF)), len(data) - 1)
    text = data[at + 1 :].decode("ascii", "replace")
    return {"server_id": data[:at].hex() or "00", "is_running": data[at] == 0xFF, "additional": text}
