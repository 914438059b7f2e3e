"""The electronic cam, PST: axis 1 follows axis 2 by a table.

Source: manual 5.9.4.1, 3.2 (@ParX[19] to [25], all of the slave's set); digest chapters 13.4 and 13.5.  The cam sees
the master through gear and offset as a virtual master, which a preset of the real counter does not move.  While the
master is at rest the slave drives to the curve; a moving master is followed at once, even if that causes a jump.
Positions are compared as the program sees them, in thousandths: a position on an end of the table is inside.
"""

from typing import Final

from fieldrig_devices.arp.motion.axis import Axis
from fieldrig_devices.arp.motion.cam_table import CamTable, CurveValue
from fieldrig_devices.arp.motion.flags import AxisFlag
from fieldrig_devices.arp.motion.reference_generators import Move, coast
from fieldrig_devices.arp.motion.setup import Offset
from fieldrig_devices.arp.parameters import Kind
from fieldrig_devices.motion.profile import Limits, State, move

_HALF_STEP: Final = 0.0005  # half of a raw unit


class VirtualMaster:
    """The master as PST sees it.  `lapped` counts its wraps in the last `look`, upward minus downward."""

    def __init__(self, master: Axis, gear: float, offset: float) -> None:
        self._master, self._gear = master, gear
        self._shift = master.reading * (1 - gear)
        self.offset = offset
        self.lapped = 0
        self.speed = 0.0
        self.position = 0.0
        self._find()
        self._shift -= gear * master.jump  # the reading already contains this jump

    @property
    def is_at_rest(self) -> bool:
        """True if the master moved less than a count in the last sample; a simulated master has no counts."""
        master = self._master
        return master.speed == 0 if master.setup.kind is Kind.SIMULATED else master.counter.delta == 0

    def look(self, gear: float, offset: float) -> None:
        """Update the position; call it once per control loop."""
        if gear != self._gear:
            self._shift += (self._gear - gear) * self._last
            self._gear = gear
        master = self._master
        if master.jump:
            self._shift += gear * master.jump
        self.offset = offset
        self.speed = gear * master.measured_speed
        self._find()

    def _find(self) -> None:
        reading = self._master.reading
        self._last = reading
        position = self._gear * reading + self._shift + self.offset
        span = self._master.setup.span
        if span.low <= position <= span.high:
            self.position, self.lapped = position, 0
            return
        self.lapped = span.laps(position)
        self._shift -= self.lapped * span.length
        self.position = span.back(position, self.lapped)


class ElectronicCam:
    """Moves the slave: first onto the curve if necessary, then along it."""

    def __init__(self, slave: Axis, master: Axis, table: CamTable, ignores_zero_steps: bool) -> None:
        """Create the cam without any effect; `is_inside` is True if it may take over."""
        setup = slave.setup
        self._table, self._ignores_zero_steps = table, ignores_zero_steps
        self._master = VirtualMaster(master, setup.master_gear, setup.master_offset.wanted)
        self._offset = setup.slave_offset.wanted
        self._shift = 0.0
        """Whole ranges between the slave's counter and the table."""
        self._entry: Move | None = None

    @property
    def is_inside(self) -> bool:
        return self._table.low - _HALF_STEP <= self._master.position <= self._table.high + _HALF_STEP

    def enter(self, slave: Axis, limits: Limits) -> None:
        """Take over the slave; it drives to the curve within `limits` if the master is at rest."""
        slave.begin(self)
        span = slave.setup.span
        place = self._table.at(self._master.position).slave + self._offset
        end = span.wrapped(place)
        self._shift = -span.laps(place) * span.length if end != place else 0.0
        distance = end - slave.reference
        if self._master.is_at_rest and (abs(distance) >= _HALF_STEP or slave.speed != 0):
            self._entry = Move(slave, move(distance, slave.speed, limits), end)
        else:
            slave.flags[AxisFlag.SYNCHRONOUS] = 1

    def advance(self, slave: Axis, now_ns: int) -> None:
        setup = slave.setup
        self._master.look(setup.master_gear, self._step(self._master.offset, setup.master_offset))
        self._offset = self._step(self._offset, setup.slave_offset)
        if slave.flags.is_to_stop or not self.is_inside:
            coast(slave, now_ns)
        elif self._entry is None:
            self._follow(slave, now_ns)
        elif self._entry.follow(slave, now_ns):
            self._entry = None
            slave.flags[AxisFlag.SYNCHRONOUS] = 1

    def shift(self, distance: float) -> None:
        """Shift only the entry; the table keeps its positions."""
        if self._entry is not None:
            self._entry.shift(distance)

    def _follow(self, slave: Axis, now_ns: int) -> None:
        master, table = self._master, self._table
        value = table.at(master.position)
        if table.leaves_slave_span and not slave.setup.span.low <= value.slave <= slave.setup.span.high:
            coast(slave, now_ns)  # manual 5.9.4.1, notes 5 and 6
            return
        if master.lapped:
            self._shift += master.lapped * table.lap
        self._shift -= slave.place(value.slave + self._offset + self._shift, _state(value, master.speed))

    def _step(self, present: float, offset: Offset) -> float:
        if present == offset.wanted:
            return present
        if offset.step > 0:
            return present + min(max(offset.wanted - present, -offset.step), offset.step)
        return present if self._ignores_zero_steps else offset.wanted


def _state(value: CurveValue, master_speed: float) -> State:
    return State(value.slave, value.slope * master_speed, value.curvature * master_speed * master_speed)
