"""Probing: the position of the motor at the edge of an input.

Source: IEC 61491 by its public facts: while the procedure command S-0-0170 is active, an edge that S-0-0169 selects
latches the position in S-0-0130 to S-0-0133, once; resetting the probe's enable (S-0-0405, S-0-0406) rearms it.  Bits
0 to 3 of S-0-0169, and of the status S-0-0179, are the rising and the falling edge of probe 1, then those of probe 2;
S-0-0409 to S-0-0412 contain them individually.  Left out: real-time bits, and continuous measurement.
"""

from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.datum import IdnTable

PROBES: Final = (0, 1)
CONTROL, COMMAND, STATUS = std.PROBE_CONTROL, std.PROBING_COMMAND, std.MEASURED_STATUS
_VALUES, _INPUTS, _ENABLES, _LATCHED = (
    std.PROBE_1_POSITIVE,
    std.PROBE_1,
    std.PROBE_1_ENABLE,
    std.PROBE_1_POSITIVE_LATCHED,
)


class Probes:
    def __init__(self, table: IdnTable, position: Callable[[], int]) -> None:
        """`position` returns the present position as it is sent over the ring."""
        self._table, self._position = table, position
        self._command: Command | None = None
        for probe in PROBES:
            table[_ENABLES + probe].watchers.append(partial(self._on_enable, probe))
        for bit in range(2 * len(PROBES)):
            table[_LATCHED + bit].reader = partial(self._latched, bit)

    def begin(self, command: Command) -> None:
        """Start S-0-0170, which stays active until the master clears it."""
        self._command = command
        self._table[STATUS].set(0)

    def put(self, probe: int, level: float) -> None:
        """Set the input of probe 0 or 1."""
        table, is_on = self._table, bool(level)
        datum = table[_INPUTS + probe]
        if is_on is bool(datum.number):
            return
        datum.set(int(is_on))
        bit = 2 * probe + (not is_on)
        status = table[STATUS].number
        is_active = self._command is not None and self._command.is_active
        is_armed = table[_ENABLES + probe].number & 1 and table[CONTROL].number >> bit & 1 and not status >> bit & 1
        if is_active and is_armed:
            table[_VALUES + bit].set(self._position())
            table[STATUS].set(status | 1 << bit)

    def _latched(self, bit: int) -> bytes:
        return self._table[_LATCHED + bit].encoded(self._table[STATUS].number >> bit & 1)

    def _on_enable(self, probe: int) -> None:
        if not self._table[_ENABLES + probe].number & 1:
            self._table[STATUS].set(self._table[STATUS].number & ~(3 << 2 * probe))
