"""Requests to Modbus units of which nothing was heard: one that boots does not answer, so the first is sent again.

Modbus has no message that says that a device has booted, and a log need not show whether its machine was on before.
"""

from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.replay.grounds import Grounds
from fieldrig_devices.replay.words import time_words

LONGEST_NS: Final = 60 * S
"""How long after the beginning of a log a unit may need to boot."""
MOST_UNITS: Final = 4_096


class Asked(NamedTuple):
    """A request that was played."""

    sender: str
    bus: str
    request: ModbusRequest


class FirstRequests:
    """The first requests, each with the number of its exchange in the rig."""

    def __init__(self, grounds: Grounds, until_ns: int) -> None:
        """Nothing is sent again after `until_ns`."""
        self._grounds, self._until_ns = grounds, until_ns
        self._open: dict[int, Asked] = {}
        self._known: set[tuple[str, int]] = set()
        """The units that have answered."""

    def sent(self, sender: str, bus: str, request: ModbusRequest) -> None:
        """Take a request that is played."""
        if (bus, request.unit) not in self._known and len(self._open) < MOST_UNITS:
            self._open[request.exchange] = Asked(sender, bus, request)

    def answered(self, exchange: int, waited_ns: int) -> None:
        """Take an answer, and how long it was waited for."""
        asked = self._open.pop(exchange, None)
        if asked is None:
            return
        self._known.add((asked.bus, asked.request.unit))
        if waited_ns > self._grounds.timeout_ns:
            words = f"unit {asked.request.unit} answered after {time_words(waited_ns)}, in which it was asked again"
            self._grounds.result.note(words)

    def again(self, exchange: int, now_ns: int) -> Asked | None:
        """Return the request to send once more; None for one that is given up."""
        asked = self._open.get(exchange)
        if asked is None or now_ns >= self._until_ns or (asked.bus, asked.request.unit) in self._known:
            return None
        return asked
