"""The dialogues of a node or a unit: how many, how they ended, and how soon the answers came."""

from collections import Counter
from typing import Any, Final

from fieldrig_bus.modbus.codec import EXCEPTIONS, FUNCTIONS
from fieldrig_devices.dialogues import ModbusExchange, SdoTransfer
from fieldrig_devices.log_stats.spread import Spread
from fieldrig_devices.named_logs.sdo_rows import abort_words

MOST_WORDS: Final = 100
"""Different errors that are distinguished."""


class Answers:
    """The dialogues of one server."""

    def __init__(self) -> None:
        self.reads = self.writes = self.unanswered = self.strays = 0
        self.times = Spread()
        """The time between request and answer; of SDO transfers only those with a single answer count."""
        self.errors: Counter[str] = Counter()
        """Abort codes and exceptions in words."""

    def take_sdo(self, transfer: SdoTransfer) -> None:
        self._count(transfer.is_download)
        if transfer.abort is not None:
            by = "client: " if transfer.abort_by_client else ""
            self._error(f"{by}{abort_words(transfer.abort)}")
        elif transfer.end_ns is None:
            self.unanswered += 1
        if transfer.end_ns is not None and transfer.form == "expedited" and not transfer.abort_by_client:
            self.times.add(max(0, transfer.end_ns - transfer.begin_ns))

    def take_modbus(self, exchange: ModbusExchange) -> None:
        self._count(exchange.request[0] in WRITES)
        if exchange.exception is not None:
            function = FUNCTIONS.get(exchange.request[0], f"function {exchange.request[0]}")
            self._error(f"{function}: {exchange.exception:02X}h {EXCEPTIONS.get(exchange.exception, '')}".rstrip())
        if exchange.end_ns is not None:
            self.times.add(max(0, exchange.end_ns - exchange.begin_ns))
        elif not exchange.is_broadcast:
            self.unanswered += 1

    def _count(self, is_write: bool) -> None:
        if is_write:
            self.writes += 1
        else:
            self.reads += 1

    def _error(self, words: str) -> None:
        if words in self.errors or len(self.errors) < MOST_WORDS:
            self.errors[words] += 1

    def as_data(self) -> dict[str, Any]:
        return {
            "reads": self.reads,
            "writes": self.writes,
            "unanswered": self.unanswered,
            "strays": self.strays,
            "errors": dict(self.errors.most_common()),
            "answer_times": self.times.as_data(),
        }


WRITES: Final = frozenset({5, 6, 15, 16, 21, 22})
"""Functions that write; one that also reads is counted as a read, as its answer has values."""
