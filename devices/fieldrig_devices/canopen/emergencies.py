"""The errors that a node has because of faults: EMCY at the start of each, and "error reset" at its end.

Source: CiA 301 version 4.2, 7.2.7.1: an error is reported once, when it occurs.
"""

from fieldrig.clock import Clock
from fieldrig_devices.canopen.emcy import Emcy
from fieldrig_devices.canopen.node_faults import Emergency, NodeFaults

MOST_INFO = 5
FIRST_SOURCE = 1 << 16
"""Sources of errors below this are parts of the device, such as axes."""


class Emergencies:
    """Raises and clears the errors when their faults begin and end."""

    def __init__(self, clock: Clock, emcy: Emcy, faults: NodeFaults) -> None:
        self._clock, self._emcy, self._faults = clock, emcy, faults
        self._raised: dict[int, int] = {}
        """The codes of the errors by the numbers of their faults."""

    def follow(self) -> None:
        """Bring the errors of the node up to date."""
        now_ns = self._clock.now_ns()
        on = {fault.number: fault.settings for fault in self._faults.records.of(Emergency) if fault.is_on(now_ns)}
        for number in [number for number in self._raised if number not in on]:
            self._emcy.clear_error(self._raised.pop(number), FIRST_SOURCE + number)
        for number, fault in on.items():
            if number not in self._raised:
                self._raised[number] = fault.code
                info = bytes.fromhex(fault.info)[:MOST_INFO]
                self._emcy.raise_error(fault.code, fault.error_register, info, FIRST_SOURCE + number)
