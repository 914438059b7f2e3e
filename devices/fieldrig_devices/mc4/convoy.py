"""Drives of one process that only follow their set positions: a cycle of all in one go, from the MDT to the ATs.

Each drive takes its cycle in its turn; the first to whom one comes moves all that ride (`axis_array`), and the others
find their AT.
"""

import struct
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from fieldrig.clock import US
from fieldrig_bus.ring.message import BROADCAST, Cycle
from fieldrig_devices.mc4.axis_array import MOST_PLACE, AxisArray
from fieldrig_devices.mc4.seat import FEWEST, Seat, Shape
from fieldrig_devices.mc4.straight import ENDING
from fieldrig_devices.sercos.slave import RUNNING_MST
from fieldrig_devices.sercos.telegram import AT_HEAD

FEWER: Final = FEWEST * 3 // 4
"""With so few a convoy is given up."""


class Convoy:
    def __init__(self, shape: Shape, seats: Sequence[Seat]) -> None:
        self._shape, self._seats, self._cycle_ns = shape, seats, shape.cycle_us * US
        size = len(seats)
        self.axes = AxisArray(size, shape.moving)
        """Columns are the numbers of the seats."""
        record = [0, 1, *range(shape.place, shape.place + 4)]
        self._places = np.array([[seat.offset + place for place in record] for seat in seats])
        self._heard = np.zeros((size, len(record)), np.uint8)
        self._control: npt.NDArray[np.uint16] = np.ndarray((size,), "<u2", self._heard, 0, (len(record),))
        self._wanted: npt.NDArray[np.int32] = np.ndarray((size,), "<i4", self._heard, 2, (len(record),))
        self._ending = np.zeros(size, np.uint16)
        """Bits of the control word that end a ride when they change: none where nobody rides."""
        self._steady_control = np.zeros(size, np.uint16)
        self._ats = np.zeros((size, shape.at_length), np.uint8)
        self._moving = self._columns()
        self._riding: list[Seat] = []
        self._gathered: list[Seat] = []
        """Who could have ridden in the cycle `_gathering`."""
        self._gathering: Cycle | None = None
        self.cycle: Cycle | None = None
        """The present one."""
        self.now_ns = self._at_ns = 0
        """When it came; until when all have gone."""
        self._mdt = self._mdt_before = b""

    def _columns(self) -> list[npt.NDArray[Any]]:
        """Where what moves lies in the ATs."""
        columns: list[npt.NDArray[Any]] = []
        shape, start = self._shape, AT_HEAD.size
        for code in shape.codes:
            columns.append(np.ndarray((len(self._ats),), f"<{code}", self._ats, start, (shape.at_length,)))
            start += struct.calcsize(f"<{code}")
        return columns

    # ---- one cycle

    def go(self, cycle: Cycle, now_ns: int) -> bool:
        """The next cycle for all that ride; False, and nothing is done, if it is none like the others."""
        for seat in [seat for seat in self._riding if seat.at is not None]:
            seat.end()  # it hasn't heard of the last one
        if len(self._riding) <= FEWER:
            self.dissolve()
        lead_ns = now_ns - self._at_ns - self._cycle_ns
        if not self._riding or not -self._cycle_ns < 3 * lead_ns < self._cycle_ns or not self._is_ordinary(cycle):
            return False
        self._listen(cycle.mdt)
        refused = self.axes.go(self._wanted)
        self.cycle, self._mdt_before, self._mdt = cycle, self._mdt, cycle.mdt
        self._at_ns += self._cycle_ns
        self._answer()
        for number in np.flatnonzero(refused).tolist() if refused.any() else ():
            self._seats[number].end()
        for number in self.axes.astray(now_ns):
            self._seats[number].is_astray = True
        self.now_ns = now_ns
        return True

    def _is_ordinary(self, cycle: Cycle) -> bool:
        mdt = cycle.mdt
        return cycle.mst == RUNNING_MST and len(mdt) == self._shape.mdt_length and mdt[0] == BROADCAST

    def _listen(self, mdt: bytes) -> None:
        """Whose control word is otherwise rides no more."""
        np.frombuffer(mdt, np.uint8).take(self._places, None, self._heard, "clip")
        changed = self._control & self._ending != self._steady_control
        for number in np.flatnonzero(changed).tolist() if changed.any() else ():
            self._seats[number].end()

    def _answer(self) -> None:
        for column, values in zip(self._moving, self.axes.feedback(), strict=True):
            column[:] = values
        image, length = self._ats.tobytes(), self._shape.at_length
        for seat in self._riding:
            start = seat.number * length
            seat.at = image[start : start + length]

    # ---- who rides

    def gather(self, seat: Seat, cycle: Cycle, now_ns: int) -> None:
        """It has gone by this cycle alone, and could have ridden."""
        if cycle is not self._gathering:
            self._gathering = cycle
            self._gathered.clear()
        self._gathered.append(seat)
        if len(self._gathered) + len(self._riding) < FEWEST:
            return
        if not self._riding:
            self.cycle, self._mdt, self._at_ns = cycle, cycle.mdt, seat.machine.at_ns
        elif cycle is not self.cycle and not self.go(cycle, now_ns):
            return
        for one in self._gathered:
            self._admit(one)
        self._gathered.clear()

    def _admit(self, seat: Seat) -> None:
        """A drive that is not as far as the others, or has changed since, goes on alone."""
        axis, machine = seat.machine.axis, seat.machine
        lead_ns = machine.at_ns - self._at_ns
        if not seat.template or 6 * abs(lead_ns) > self._cycle_ns or abs(axis.set_increments) > MOST_PLACE:
            return
        number = seat.number
        self.axes.put(number, axis, machine.true_motor.standstill_torque_nm, seat.most_error, seat.course)
        self._ats[number] = np.frombuffer(seat.template, np.uint8)
        self._steady_control[number] = int.from_bytes(self._mdt[seat.offset : seat.offset + 2], "little") & ENDING
        self._ending[number] = ENDING
        self._riding.append(seat)
        seat.begin(self, lead_ns)

    def leave(self, seat: Seat) -> None:
        """It is where it would be alone."""
        is_pending = seat.at is not None
        self._riding.remove(seat)
        self.axes.give(seat.number, seat.machine.axis_alone, before=is_pending)
        self.axes.clear(seat.number)
        self._ending[seat.number] = self._steady_control[seat.number] = 0
        at_ns, mdt = (self._at_ns - self._cycle_ns, self._mdt_before) if is_pending else (self._at_ns, self._mdt)
        seat.machine.at_ns = at_ns + seat.lead_ns
        seat.slave.take_up(mdt)

    def dissolve(self) -> None:
        for seat in tuple(self._riding):
            seat.end()
