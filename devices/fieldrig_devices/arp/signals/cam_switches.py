"""Cam switches, CAM1 to CAM6: each switches an output or a flag by the position of an axis.

Source: manual 5.11; digest chapter 15.  A cam switch turns on when the axis passes its set value toward its reset
value, and is off whenever the axis is not between the two.  So with set below reset it works in the positive direction
only, and vice versa.  It is off if it is armed between them, and at both values themselves.  A cam that is passed
completely within one control loop has no effect.  Disarming leaves the output as it is.

The interpretation `cam_wrap` determines the behaviour where the counter wraps.  With "travel", as a user of a cyclic
axis expects, a step over the wrap is as long as the distance that the axis travelled, so a cam that begins there turns
on, and a value beyond the counter's limits is in the next turn (19000 to 21000 on a counter from 0 to 20000 is on from
19000 to 1000).  With "jump", the plain numbers are compared, and the wrap is a jump from one end to the other.
"""

from typing import Final

from fieldrig_devices.arp.parameters import Parameters, ParX
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import CamSwitch
from fieldrig_devices.arp.signals.axis_values import AxisValues

_AXES: Final = (1, 2)


class _Armed:
    __slots__ = ("axis", "bits", "cam", "is_inverted", "is_upward", "latched", "low", "number", "was", "width")

    def __init__(self, cam: CamSwitch, bits: list[int], position: int) -> None:
        self.cam, self.bits = cam, bits
        self.axis, self.number, self.is_inverted = cam.axis, cam.number, int(cam.is_inverted)
        self.is_upward = cam.set_at < cam.reset_at
        self.low, self.width = min(cam.set_at, cam.reset_at), abs(cam.reset_at - cam.set_at)
        self.latched = 0
        self.was = position

    def follow(self, position: int, turn: int) -> None:
        """Follow the axis to a new position; `turn` is the range of its counter, or 0 if a wrap is a jump."""
        travel, self.was = position - self.was, position
        phase = position - self.low
        if turn:
            phase %= turn
            if 2 * travel > turn:
                travel -= turn
            elif -2 * travel > turn:
                travel += turn
        if not 0 < phase < self.width:
            self.latched = 0
        elif (before := phase - travel) <= 0:
            self.latched = int(self.is_upward)
        elif before >= self.width:
            self.latched = int(not self.is_upward)


class CamSwitches:
    def __init__(
        self, axes: AxisValues, flags: list[int], outputs: list[int], parameters: Parameters, readings: Readings
    ) -> None:
        self._axes, self._flags, self._outputs = axes, flags, outputs
        self._parameters, self._readings = parameters, readings
        self._armed: dict[int, _Armed] = {}
        self._version = -1
        self._turns = [0, 0, 0]

    def arm(self, number: int, cam: CamSwitch) -> None:
        """Arm CAM1 to CAM6.  Repeating the same instruction changes nothing."""
        armed = self._armed.get(number)
        if armed is None or armed.cam != cam:
            bits = self._outputs if cam.letter == "O" else self._flags
            self._armed[number] = _Armed(cam, bits, self._axes.position(cam.axis))

    def disarm(self, number: int) -> None:
        self._armed.pop(number, None)

    def reset(self) -> None:
        self._armed.clear()

    def control(self) -> None:
        """Set every output that has a cam switch, even if a program has written it; once per control loop, after the
        axes."""
        if not self._armed:
            return
        if self._version != self._parameters.version:
            self._refresh()
        positions = (0, self._axes.position(1), self._axes.position(2))
        for armed in self._armed.values():
            position = positions[armed.axis]
            if position != armed.was:
                armed.follow(position, self._turns[armed.axis])
            armed.bits[armed.number] = armed.latched ^ armed.is_inverted

    def _refresh(self) -> None:
        self._version = self._parameters.version
        if self._readings.cam_wrap == "travel":
            for axis in _AXES:
                table = self._parameters.ram[axis]
                self._turns[axis] = max(0, table[ParX.COUNTER_MAXIMUM] - table[ParX.COUNTER_MINIMUM])
