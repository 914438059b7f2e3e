"""One axis of the controller: enable, state, actual values, diagnosis, and set values once per ring cycle.

Source: PacDrive manual 3063-3074, 4190-4196, 6066-6171 (digest PD-091 to PD-093, PD-150 and up); control word and modes
are those of IEC 61491.  The source of motion (a field bus face, later a cam) is the `SetValues` of an axis; without it
the axis holds the position at which it came under control.  Positions are encoder increments and do not overflow: they
are counted beyond the 32 bits of the telegram.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final, Protocol

from fieldrig_devices.max4.configuration.tree import Object
from fieldrig_devices.max4.messages.diagnosis import Diagnosis, Sender
from fieldrig_devices.sercos.idn import Element, ServiceError
from fieldrig_devices.sercos.service import Done

INCREMENTS: Final = 1_000_000
"""Encoder increments per revolution (manual 6929-6933)."""
NOT_THERE: Final = 0x0004
"""Our error number, besides those of the service channel, for a drive that is not on the ring."""


class Mode(Enum):
    """The quantity of the set value: the operation mode in bits 8 and 9 of the control word."""

    POSITION = 0x0000
    """Primary mode, with set values in increments."""
    VELOCITY = 0x0100
    """First secondary mode, with set values in increments per second."""
    TORQUE = 0x0200
    """Second secondary mode, with set values in 0.1 % of the rated torque of the motor."""


class AxisState(Enum):
    """Values of AxisState: 0 and 1 are those of the manual (6073), the others those of digest 3.2."""

    NO_HARDWARE_ENABLE = 0
    WAITING = 1
    """The axis waits for ControllerEnable."""
    ENABLING = 2
    """The brake is being released."""
    CONTROLLED = 3
    STOPPING = 4
    ERROR = 5
    """The drive has an error and no torque."""


class SetValues(Protocol):
    """A source of set values.  It is called only while the axis is under control, once per ring cycle."""

    mode: Mode
    """The quantity of the set values, which may change between two cycles."""

    def begin(self, axis: "Axis") -> None:
        """Called when the axis comes under control; the first set value continues from `axis.position`."""

    def next(self) -> float:
        """The set value of this cycle, in the unit of `mode`; positions are whole numbers of increments."""

    def end(self) -> None:
        """Called when the axis is no longer under control."""


class DriveEnd(Protocol):
    """The drive of an axis, which is on the ring or simulated."""

    @property
    def status(self) -> int:
        """Drive status word without the bits of the service channel."""

    def read(self, idn: int, element: Element, done: Done) -> None:
        """Read over the service channel; `done` is called many cycles later.  Lists and texts have no lengths."""

    def write(self, idn: int, data: bytes, done: Done) -> None: ...

    def command(self, idn: int, done: Callable[[bool], None]) -> None:
        """Run a procedure command, then call `done` with true if it succeeded."""


class Axis:
    """An axis that the controller creates and that faces use.

    In each ring cycle `position`, `velocity` and `torque` are updated first; then `watchers` are called if state or
    diagnosis have changed, then the actions of `Controller.each_cycle`, and finally the source of set values.
    """

    def __init__(self, name: str, node: Object, ring_address: int, diagnosis: Diagnosis, *, is_simulated: bool) -> None:
        self.name = name
        """The symbolic name."""
        self.object = node
        self.ring_address = ring_address
        """Address on the ring (`RealTimeBusAdr`), which is independent of the logical address."""
        self.diagnosis = diagnosis
        self.is_simulated = is_simulated
        self.sender = Sender("MC_4", name)
        self.drive: DriveEnd | None = None
        """The drive, or None while it is not on the ring."""
        self.is_operating = False
        """True while the drive exchanges cyclic data on the ring (CP4)."""
        self.is_controlled = False
        """True while the drive follows set values."""
        self.modes: frozenset[Mode] = frozenset(Mode)
        """Modes whose set values are in the telegram of the drive; in any other mode the axis stands still."""
        self.is_enabled = False
        """ControllerEnable."""
        self.axis_state = AxisState.NO_HARDWARE_ENABLE
        self.mc4_state = 0x03
        """State as the drive shows it, such as 0x03, 0x10 or 0x21."""
        self.position = 0
        """Actual position in increments."""
        self.velocity = 0.0
        """Actual velocity in increments per second."""
        self.torque = 0
        """Actual torque in 0.1 % of the rated torque of the motor."""
        self.set_value: float = 0
        """Set value last sent to the drive, in the unit of `mode`."""
        self.mode = Mode.POSITION
        """The mode of `set_value`."""
        self.set_values: SetValues | None = None
        self.watchers: list[Callable[[], None]] = []
        """Called after a change of state, enable, diagnosis or source of set values."""
        self._quit: Callable[[Axis, Callable[[bool], None] | None], None] | None = None

    @property
    def status_word(self) -> int:
        """Drive status word (S-0-0135) without the bits of the service channel; 0 without a drive."""
        return 0 if self.drive is None else self.drive.status

    @property
    def log_adr(self) -> int:
        """The logical address, by which IEC code refers to the axis."""
        return self.object.log_adr

    @property
    def is_in_error(self) -> bool:
        """True while a diagnosis with an error reaction (classes 1 to 5) is pending."""
        return self.diagnosis.is_error

    @property
    def diag_code(self) -> int:
        """DiagCode; 0 if no diagnosis is pending."""
        return self.diagnosis.code

    @property
    def diag_msg(self) -> str:
        """DiagMsg; empty if no diagnosis is pending."""
        return self.diagnosis.msg

    @property
    def following_error(self) -> int:
        """Set position minus actual position in increments; 0 in other modes."""
        return round(self.set_value) - self.position if self.mode is Mode.POSITION and self.is_controlled else 0

    def enable(self, is_on: bool) -> None:
        """Set ControllerEnable.  It stays set until it is reset, even after errors; the drive decides on its effect."""
        if is_on is not self.is_enabled:
            self.is_enabled = is_on
            self.changed()

    def quit_errors(self, done: Callable[[bool], None] | None = None) -> None:
        """Acknowledge (quit) the diagnoses of this axis: in the drive (S-0-0099, service channel), then here."""
        if self._quit is not None:
            self._quit(self, done)

    def follow(self, set_values: SetValues | None) -> None:
        """Set the source of set values for the next cycle; None holds the present position."""
        before, self.set_values = self.set_values, set_values
        if self.is_controlled:
            if before is not None:
                before.end()
            self._begin()
        self.changed()

    def read(self, idn: int, done: Done, element: Element = Element.DATA) -> None:
        """Read a parameter of the drive, which is slow (PD-028); `done` receives the bytes or a ServiceError.

        `done` may be called before this method returns.
        """
        if self.drive is None:
            done(ServiceError(NOT_THERE))
        else:
            self.drive.read(idn, element, done)

    def write(self, idn: int, data: bytes, done: Done) -> None:
        """Write a parameter of the drive, as in `read`."""
        if self.drive is None:
            done(ServiceError(NOT_THERE))
        else:
            self.drive.write(idn, data, done)

    # ---- for the controller

    def enter(self, state: AxisState, mc4_state: int, *, is_operating: bool = True) -> None:
        """Take over the state of the drive, also when the drive leaves the ring."""
        was_controlled = self.is_controlled
        self.axis_state, self.mc4_state, self.is_operating = state, mc4_state, is_operating
        self.is_controlled = is_operating and state is AxisState.CONTROLLED
        if self.is_controlled and not was_controlled:
            self._begin()
        elif was_controlled and not self.is_controlled and self.set_values is not None:
            self.set_values.end()
        self.changed()

    def ask(self) -> tuple[Mode, float]:
        """Return mode and set value of this cycle; called once per cycle under control."""
        source = self.set_values
        if source is None or source.mode not in self.modes:
            if self.mode is not Mode.POSITION:
                self._stand()
        else:
            self.mode, self.set_value = source.mode, source.next()
        return self.mode, self.set_value

    def changed(self) -> None:
        """Call all watchers."""
        for watcher in self.watchers:
            watcher()

    def on_quit(self, action: "Callable[[Axis, Callable[[bool], None] | None], None]") -> None:
        """Set the action that acknowledges (quits) the diagnoses of an axis."""
        self._quit = action

    def _begin(self) -> None:
        self._stand()
        if self.set_values is not None:
            self.set_values.begin(self)

    def _stand(self) -> None:
        self.mode, self.set_value = Mode.POSITION, self.position
