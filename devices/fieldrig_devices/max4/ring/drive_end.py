"""A drive on the ring as the drive end of an axis: its cyclic data and its service channel.

Source: public facts of IEC 61491; IDNs and units of the MC-4 (`mc4.idns`).  The AT contains position, velocity, torque,
S-0-0182 with AxisState and MC4State, and S-0-0390 with the DiagCode, the MDT the set values that the configuration
names.  ControllerEnable is the bit "drive on"; "drive enable" and "run" are always set, because without them a drive
loses its torque immediately.
"""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig.clock import S
from fieldrig.shortcuts import Shortcut
from fieldrig_devices.max4.axes.axis import INCREMENTS, Axis, AxisState, Mode
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.idn import Element
from fieldrig_devices.sercos.master import SercosMaster
from fieldrig_devices.sercos.ring_drive import Drive
from fieldrig_devices.sercos.service import STATUS_MASK, Done

AT: Final = (
    std.POSITION_FEEDBACK_1,
    std.VELOCITY_FEEDBACK,
    std.TORQUE_FEEDBACK,
    std.MANUFACTURER_CLASS_3,
    std.DIAGNOSTIC_NUMBER,
)
SHORT_AT: Final = (std.POSITION_FEEDBACK_1, std.TORQUE_FEEDBACK, std.MANUFACTURER_CLASS_3, std.DIAGNOSTIC_NUMBER)
"""AT for more drives than fit into a cycle; the velocity is computed from the positions."""
MDT: Final = {"position": std.POSITION_COMMAND, "velocity": std.VELOCITY_COMMAND, "torque": std.TORQUE_COMMAND}
ALL: Final = ("position", "velocity", "torque")
MODES: Final = {"position": Mode.POSITION, "velocity": Mode.VELOCITY, "torque": Mode.TORQUE}
PER_VELOCITY: Final = INCREMENTS / 60 / 10_000
"""Increments per second of a velocity of 0.0001 1/min."""
READY: Final = words.ENABLE | words.RUN
FOLLOWING: Final = READY | words.DRIVE_ON | Mode.POSITION.value
NEWS: Final = Shortcut(
    "max4.drive_end.news", "the values of an AT are taken, and those of an MDT given, when they change"
)
_HALF, _MASK = 1 << 31, 0xFFFF_FFFF
_STATES: Final = {state.value: state for state in AxisState}


class RingDrive:
    """The drive end of one axis on the ring."""

    __slots__ = (
        "_address", "_control", "_held", "_is_idle", "_master", "_needs_news", "_per_way", "_place", "_places", "_seen",
        "_sent",
        "_table", "_wanted", "axis", "code", "drive", "is_refused", "on_code", "raw", "state",
    )  # fmt: skip

    def __init__(self, axis: Axis, commands: Sequence[str] | None, on_code: Callable[[Axis, int], None]) -> None:
        """`commands` are the set values in the telegram, or None if `lay_out` chooses them.

        `on_code` is called with each DiagCode that the drive shows.
        """
        self.axis, self.on_code = axis, on_code
        self._wanted = commands
        self.lay_out(ALL)
        self._address = axis.ring_address
        self._master: SercosMaster | None = None
        self.raw: int | None = None
        """Position as the drive sends it, or None before the first AT."""
        self.state = self.code = 0
        self._control = 0
        self._sent: tuple[int, ...] = ()
        self._seen: tuple[int, ...] = ()
        self._table: list[int] = []
        self._place = 0
        """Index of the position set value among the values of the MDT; 0 if there is none."""
        self._is_idle = False
        """True without control, while the values last sent are still valid."""
        self._held: float | None = None
        """The position that the axis holds under control, if it was sent last."""
        self._needs_news = NEWS.is_taken
        self.is_refused = False
        """True if the drive must not be enabled: its version is not compatible, or has not been read yet."""

    def lay_out(self, commands: Sequence[str], short_cycle_ns: int = 0) -> None:
        """Choose the telegrams.  Set values of the configuration replace `commands`; a cycle selects SHORT_AT."""
        self._places = tuple(self._wanted or commands)
        at = SHORT_AT if short_cycle_ns else AT
        self.drive = Drive(self.axis.ring_address, [MDT[name] for name in self._places], at)
        self._per_way = S / short_cycle_ns if short_cycle_ns else 0.0
        self.axis.modes = frozenset(MODES[name] for name in self._places)

    def begin(self, master: SercosMaster) -> None:
        """Start cyclic operation, after CP4 is reached."""
        self._master = master
        self.state, self.code, self._control = -1, 0, 0
        self._sent = self._seen = ()
        self._is_idle = False
        self.is_refused = True
        self._table = master.command_values
        self._place = self.drive.place + 2 if self._places[0] == "position" else 0
        self.raw = None
        self.axis.drive = self

    def end(self) -> None:
        """Leave the axis without a drive, because the ring is down."""
        self._master = None
        axis = self.axis
        axis.drive, axis.is_enabled, axis.velocity, axis.torque = None, False, 0.0, 0
        axis.enter(AxisState.NO_HARDWARE_ENABLE, 0x00, is_operating=False)

    # ---- once per cycle

    def take(self) -> None:
        """Take the actual values from the AT."""
        values = self.drive.values
        axis = self.axis
        if values == self._seen and self._needs_news:
            if self._per_way:
                axis.velocity = 0.0
            return
        self._seen = values
        before = self.raw
        if self._per_way:
            _, _, raw, axis.torque, state, code = values
            way = 0 if before is None else ((raw - before + _HALF) & _MASK) - _HALF
            axis.velocity = way * self._per_way
        else:
            _, _, raw, velocity, axis.torque, state, code = values
            way = 0 if before is None else ((raw - before + _HALF) & _MASK) - _HALF
            axis.velocity = velocity * PER_VELOCITY
        if raw != before:
            # counted beyond 32 bits; the first position after phase-up is absolute
            axis.position = raw if before is None else axis.position + way
            self.raw = raw
            self._is_idle = False
        if state != self.state:
            self.state = state
            axis.enter(_STATES.get(state >> 8, AxisState.STOPPING), state & 0xFF)
        if code != self.code:
            self.code = code
            if code:
                self.on_code(axis, code)

    def give(self) -> None:
        """Put the set values into the MDT.  Two cases are short: an axis that follows positions, and one at rest."""
        axis = self.axis
        if not self._needs_news:
            self._give()
            return
        if not axis.is_enabled:
            if self._is_idle and not axis.is_controlled:
                return
        elif axis.is_controlled and self._control == FOLLOWING and self._place:
            source = axis.set_values
            if source is None:
                if axis.set_value == self._held:
                    return
            elif source.mode is Mode.POSITION:
                self._held = None
                axis.set_value = value = source.next()
                self._table[self._place] = ((int(value) + _HALF) & _MASK) - _HALF
                return
        self._give()

    def _give(self) -> None:
        axis = self.axis
        control = READY | words.DRIVE_ON if axis.is_enabled and not self.is_refused else READY
        raw = self.raw or 0
        if not axis.is_controlled:  # so that the set value does not jump when control begins
            values = self._values(raw, 0, 0)
        else:
            mode, value = axis.ask()
            control |= mode.value
            if mode is Mode.POSITION:
                values = self._values(((int(value) + _HALF) & _MASK) - _HALF, 0, 0)
            elif mode is Mode.VELOCITY:
                values = self._values(raw, max(-_HALF, min(round(value / PER_VELOCITY), _HALF - 1)), 0)
            else:
                values = self._values(raw, 0, max(-32_768, min(round(value), 32_767)))
        if self._control == FOLLOWING or values != self._sent or control != self._control:
            assert self._master is not None
            self._sent, self._control = values, control
            self._master.set_commands(self._address, control, *values)
        self._is_idle = not axis.is_controlled and not axis.is_enabled
        self._held = axis.set_value if axis.is_controlled and control == FOLLOWING else None

    def _values(self, position: int, velocity: int, torque: int) -> tuple[int, ...]:
        if self._places == ALL:
            return position, velocity, torque
        given = {"position": position, "velocity": velocity, "torque": torque}
        return tuple(given[name] for name in self._places)

    @property
    def status(self) -> int:
        return self.drive.status & ~STATUS_MASK

    # ---- service channel

    def read(self, idn: int, element: Element, done: Done) -> None:
        assert self._master is not None
        self._master.read(self._address, idn, element, done)

    def write(self, idn: int, data: bytes, done: Done) -> None:
        assert self._master is not None
        self._master.write(self._address, idn, data, done)

    def command(self, idn: int, done: Callable[[bool], None]) -> None:
        assert self._master is not None
        self._master.command(self._address, idn, done)
