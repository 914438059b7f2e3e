"""Modbus answers of the rig compared with those of a log, exchange by exchange."""

from collections import defaultdict
from dataclasses import dataclass
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS, encode
from fieldrig_bus.modbus.message import ModbusResponse
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.replay_result import Difference, What
from fieldrig_devices.replay.runs import Subject
from fieldrig_devices.replay.streams import Item
from fieldrig_devices.replay.words import hex_words, late_words, time_words

EXCEPTION: Final = 0x80
MOST_OPEN: Final = 4_096


@dataclass(slots=True)
class _Open:
    """A request that was sent to the rig."""

    bus: str
    unit: int
    request: bytes
    log_ns: int
    """The instant of the request in the log, had the rig never been late."""
    rig_ns: int
    expected: tuple[bytes, int] | None = None
    """The answer of the log and its instant, by the rig's clock."""
    answered_ns: int = 0
    """The instant of the log's answer, had the rig never been late; how late it was may change meanwhile."""
    actual: tuple[bytes, int] | None = None


class ModbusAnswers:
    """The exchanges that were played, by their number in the rig."""

    def __init__(self, grounds: Grounds) -> None:
        self._grounds = grounds
        self._open: dict[int, _Open] = {}
        self._longest_ns: defaultdict[tuple[str, int], int] = defaultdict(int)
        """The longest time of an answer of the log, by bus and unit."""

    def asked(self, exchange: int, bus: str, unit: int, request: bytes, log_ns: int, rig_ns: int) -> None:
        """Take a request that was sent to the rig."""
        self._open[exchange] = _Open(bus, unit, request, log_ns, rig_ns)
        if len(self._open) > MOST_OPEN:
            self._end(next(iter(self._open)))

    def asked_again(self, exchange: int, rig_ns: int) -> None:
        """Take a request that was sent once more: its answer is awaited from now on."""
        open_ = self._open.get(exchange)
        if open_ is not None:
            open_.rig_ns = rig_ns

    def expect(self, exchange: int, response: bytes, at_ns: int, log_ns: int) -> None:
        """Take the answer of the log, at `at_ns` by the rig's clock and at `log_ns` had the rig never been late."""
        open_ = self._open.get(exchange)
        if open_ is not None:
            open_.expected, open_.answered_ns = (response, at_ns), log_ns
            unit = open_.bus, open_.unit
            self._longest_ns[unit] = max(self._longest_ns[unit], log_ns - open_.log_ns)
            self._compare(exchange, open_)

    def heard(self, exchange: int, response: bytes, rig_ns: int) -> None:
        """Take the answer of the rig."""
        open_ = self._open.get(exchange)
        if open_ is not None:
            open_.actual = response, rig_ns
            self._compare(exchange, open_)

    def is_answered(self, exchange: int) -> bool:
        """Return whether the rig has answered."""
        open_ = self._open.get(exchange)
        return open_ is None or open_.actual is not None

    def finish(self, end_ns: int) -> None:
        """Compare everything that is left; an answer about `end_ns` may be one that the log ends before.

        So may any answer to a request that is not as far from the end as an answer took in the log.
        """
        sure_ns = end_ns - self._grounds.tolerances.time_ns
        for exchange, open_ in list(self._open.items()):
            ends_ns = open_.rig_ns + self._longest_ns[open_.bus, open_.unit]
            if open_.expected is None and open_.actual is not None and max(ends_ns, open_.actual[1]) > sure_ns:
                del self._open[exchange]
            else:
                self._end(exchange)

    def _compare(self, exchange: int, open_: _Open) -> None:
        if open_.expected is not None and open_.actual is not None:
            self._end(exchange)

    def _end(self, exchange: int) -> None:
        open_ = self._open.pop(exchange)
        expected, actual = open_.expected, open_.actual
        if expected is None and actual is None:
            return
        parts = self._grounds.names[1].parts(self._item(open_, (expected or actual or (b"", 0))[0]))
        device = f"unit {open_.unit}" if parts is None or parts.node == f"unit {open_.unit}" else parts.node
        node = device if device.startswith("unit ") else f"unit {open_.unit} ({device})"
        function = FUNCTIONS.get(open_.request[0], f"function {open_.request[0]}")
        place = _place(open_.request)
        subject = f"{function} {place}".rstrip()
        self._grounds.compared(open_.bus, node, subject)
        if actual is None and expected is not None:
            within = time_words(self._grounds.timeout_ns)
            words = f"{node} did not answer {subject} within {within}, the log says {self._outcome(open_, expected[0])}"
            self._add(What.NO_ANSWER, open_, expected[1], node, subject, words)
        elif expected is None and actual is not None:
            words = f"{node} answered {subject} with {self._outcome(open_, actual[0])}, the log has no answer"
            self._add(What.MORE, open_, actual[1], node, subject, words)
        elif expected is not None and actual is not None:
            self._judge_both(open_, expected, actual, node, subject)

    def _judge_both(
        self, open_: _Open, expected: tuple[bytes, int], actual: tuple[bytes, int], node: str, subject: str
    ) -> None:
        if (expected[0][0] | actual[0][0]) & EXCEPTION and expected[0] != actual[0]:
            words = f"{node} answered {subject} with {self._outcome(open_, actual[0])}"
            words += f", the log says {self._outcome(open_, expected[0])}"
            self._add(What.REFUSED, open_, expected[1], node, subject, words)
            return
        late_ns = (actual[1] - open_.rig_ns) - (open_.answered_ns - open_.log_ns)
        log, rig = (
            self._grounds.names[side].parts(self._item(open_, response[0]))
            for side, response in enumerate((expected, actual))
        )
        times_ns = self._grounds.since(expected[1]), self._grounds.since(actual[1])
        differs = (
            log is not None
            and rig is not None
            and self._grounds.runs.take(
                Subject(open_.bus, node, subject, f"{node} answered {{}} with"), log.values, rig.values, times_ns
            )
        )
        if not differs and abs(late_ns) > self._grounds.tolerances.time_ns:
            words = f"{node} answered {subject} {late_words(late_ns)}"
            self._add(What.LATE, open_, expected[1], node, subject, words, late_ns)

    def _outcome(self, open_: _Open, response: bytes) -> str:
        if response[0] & EXCEPTION:
            code = response[1] if len(response) > 1 else 0
            return f"exception {code:02X}h {EXCEPTIONS.get(code, '')}".rstrip()
        parts = self._grounds.names[1].parts(self._item(open_, response))
        if parts is None or not parts.values:
            return hex_words(response[1:])
        return ", ".join(f"{part.label} {part.text}" for part in parts.values[:3])

    def _item(self, open_: _Open, response: bytes) -> Item:
        data = encode(ModbusResponse(open_.unit, response or b"\0"))
        return Item(0, response, 0, TraceEntry(0, open_.bus, "modbus", "", data), open_.request)

    def _add(
        self, what: What, open_: _Open, time_ns: int, node: str, subject: str, words: str, late_ns: int = 0
    ) -> None:
        self._grounds.result.add(
            Difference(self._grounds.since(time_ns), what, open_.bus, node, subject, words, late_ns)
        )


def _place(request: bytes) -> str:
    """Return the addresses of a request."""
    if len(request) < 5 or request[0] not in (1, 2, 3, 4, 5, 6, 15, 16, 22, 23):
        return ""
    address, count = int.from_bytes(request[1:3]), int.from_bytes(request[3:5])
    if request[0] in (5, 6, 22) or count == 1:
        return f"at {address}"
    return f"at {address} to {address + count - 1}" if count else f"at {address}, none"
