"""The start times of the telegrams in a cycle, and the layout of the MDT (IEC 61491, S-0-0001 to S-0-0010).

Times for a drive are relative to the end of the MST, the only telegram that marks the start of the cycle.
"""

import struct
from collections.abc import Sequence

from fieldrig.clock import US
from fieldrig_bus.ring.sercos.message import BROADCAST
from fieldrig_bus.ring.sercos.timing import GAP_NS, MST_BYTES, telegram_ns
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.ring_drive import Drive
from fieldrig_devices.sercos.telegram import HEAD_BYTES, size


class RingPlan:
    def __init__(self, order: Sequence[Drive], cycle_ns: int, mbaud: int, settling_ns: int) -> None:
        """`order` is that of the ring; `settling_ns` is the time from the end of the MDT to command valid time."""
        self._order = tuple(order)
        self.cycle_ns, self._mbaud, self._settling_ns = cycle_ns, mbaud, settling_ns

    def timing(self, drive: Drive, own: dict[int, int]) -> dict[int, int]:
        """Return S-0-0001 and following for a drive, in microseconds and bytes; `own` are its S-0-0003 and S-0-0005."""
        cycle_us = self.cycle_ns // US
        mst_ns, at_ns = telegram_ns(MST_BYTES, self._mbaud), 0
        for other in self._order:
            at_ns += GAP_NS
            if other is drive:
                break
            at_ns += telegram_ns(other.at_length, self._mbaud)
        mdt_ns, end_ns = self._mdt_slot()
        position, length = 1, 0
        for other in self._order:
            if other is drive:
                position = 1 + length
            length += HEAD_BYTES + size(other.mdt_codes)
        return {
            std.NC_CYCLE_TIME: cycle_us,
            std.SERCOS_CYCLE_TIME: cycle_us,
            std.AT_START: max(at_ns // US, own[std.SHORTEST_AT_START]),
            std.MDT_START: (mdt_ns - mst_ns) // US,
            std.COMMAND_VALID_TIME: (end_ns - mst_ns + self._settling_ns) // US,
            std.FEEDBACK_TIME: max(cycle_us - own[std.SHORTEST_FEEDBACK_TIME] - 1, 1),
            std.RECORD_POSITION: position,
            std.MDT_LENGTH: length,
        }

    def needed_ns(self) -> int:
        """Shortest possible cycle with these drives."""
        return self._mdt_slot()[1] + self._settling_ns

    def _mdt_slot(self) -> tuple[int, int]:
        """Start and end of the MDT in the cycle."""
        begin_ns = telegram_ns(MST_BYTES, self._mbaud) + GAP_NS
        begin_ns += sum(telegram_ns(drive.at_length, self._mbaud) + GAP_NS for drive in self._order)
        length = 1 + sum(HEAD_BYTES + size(drive.mdt_codes) for drive in self._order)
        return begin_ns, begin_ns + telegram_ns(length, self._mbaud)

    def lay_out(self) -> tuple[struct.Struct, list[int]]:
        """Return the MDT and its values, all 0, and set the `place` of each drive's control word."""
        codes, values = "<B", [BROADCAST]
        for drive in self._order:
            drive.place = len(values)
            codes += "HH" + "".join(drive.mdt_codes)
            values += [0, 0, *(0 for _ in drive.mdt)]
        return struct.Struct(codes), values
