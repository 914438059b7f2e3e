"""Interpolated position: takes one set-point from a buffer per period of 60C2h, and moves on straight lines.

Source: CiA 402-2, chapter 'interpolated position mode'; sub mode 0, buffer organisation FIFO.  Bit 4 of the control
word starts it.  With an empty buffer the axis holds its last set-point, or has a quick stop
(`Behaviour`); a full buffer refuses further set-points.
Set-points are accepted only in 'operation enabled', because cyclic masters send them from the start, together with the
control word.
"""

from collections import deque
from collections.abc import Callable
from typing import Final

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.behaviour import EmptyBuffer
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.line import LinePosition
from fieldrig_devices.cia402.modes.mode import BIT_12, TARGET_REACHED

ENABLE: Final = 0x0010
ACTIVE: Final = BIT_12
_CLEAR, _MOST, _POSITION = (objects.BUFFER, 6), (objects.BUFFER, 2), 4


class InterpolatedPosition(LinePosition):
    number = 7

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._buffer: deque[int] = deque()
        self._is_enabled = False

    def end(self) -> None:
        super().end()
        self._is_enabled = False
        self._clear()

    def writers(self) -> dict[tuple[int, int], Callable[[int], None]]:
        return {(objects.DATA_RECORD, 1): self._on_record, _CLEAR: self._on_clear}

    def control(self, word: int, rising: int) -> None:
        self._is_enabled = bool(word & ENABLE)

    def _on_record(self, position: int) -> None:
        if not self._is_begun:
            return
        numbers = self.context.objects.numbers
        if not numbers[_CLEAR]:
            raise Abort(Code.DEVICE_STATE)
        if len(self._buffer) >= numbers[_MOST]:
            raise Abort(Code.OUT_OF_MEMORY)
        self._buffer.append(position)
        self._show()

    def _on_clear(self, access: int) -> None:
        if not access:
            self._clear()

    def _clear(self) -> None:
        self._buffer.clear()
        self._show()

    def _show(self) -> None:
        self.context.objects.put(objects.BUFFER, len(self._buffer), _POSITION)

    @property
    def _is_active(self) -> bool:
        return self._is_enabled and self._is_begun and not self.is_halted

    def step(self) -> None:
        cycle_s, has_next = self.context.cycle_s, bool(self._buffer) and self._is_active
        if self.is_halted or not (self._is_led or has_next):
            super().step()
            return
        if not self._is_led:
            self._line.stand(self.context.motion.position)
        place = self._line.step(cycle_s)
        if self._line.is_done and has_next:
            # the rest of the cycle belongs to the next line
            self._lead(place, self._buffer.popleft(), min(self._line.overrun_s, cycle_s))
            self._show()
            place = self._line.value
        self._follow(place)
        if self._line.is_done and self._is_active and self.context.behaviour.empty_buffer is EmptyBuffer.QUICK_STOP:
            self.context.on_quick_stop()

    @property
    def status(self) -> int:
        if self.is_halted:
            return self.halted_status
        is_at_rest = self._is_led or self.context.motion.is_done
        is_there = is_at_rest and self._line.is_done and not self._buffer and not self.context.travel.held
        return (ACTIVE if self._is_active else 0) | (TARGET_REACHED if is_there else 0)
