"""One axis as the controller has it: enable, state, actual values, diagnosis, and set values once a ring cycle.

Source: PacDrive manual 3063-3074, 4190-4196, 6066-6171 (digest PD-091 to PD-093, PD-150 on); control word and modes are
those of IEC 61491.  Whoever moves an axis (a field bus face, later a cam) is its `SetValues`; without one the axis
stands where it came under control.  Positions are encoder increments and don't overflow: they are counted on over the
32 bits of the telegram.
"""

from collections.abc import Callable
from enum import Enum
from typing import Final, Protocol

from fieldrig_devices.max4.configuration.tree import Object
from fieldrig_devices.max4.messages.diagnosis import Diagnosis, Sender
from fieldrig_devices.sercos.idn import Element, ServiceError
from fieldrig_devices.sercos.service import Done

INCREMENTS: Final = 1_000_000
"""A revolution (manual 6929-6933)."""
NOT_THERE: Final = 0x0004
"""No message of a drive's: it is not on the ring; our number beside the service channel error messages."""


class Mode(Enum):
    """Which set value counts: the operation mode in bits 8 and 9 of the control word."""

    POSITION = 0x0000
    """Primary mode: set values in increments."""
    VELOCITY = 0x0100
    """First secondary mode: increments per second."""
    TORQUE = 0x0200
    """Second secondary mode: 0.1 % of the motor's rated torque."""


class AxisState(Enum):
    """0 and 1 are the manual's (6073), the rest is digest 3.2."""

    NO_HARDWARE_ENABLE = 0
    WAITING = 1
    """For ControllerEnable."""
    ENABLING = 2
    """The brake lifts."""
    CONTROLLED = 3
    STOPPING = 4
    ERROR = 5
    """Without torque."""


class SetValues(Protocol):
    """Where an axis is to go.  Asked only while the axis is under control, once a ring cycle."""

    mode: Mode
    """May change between two cycles."""

    def begin(self, axis: "Axis") -> None:
        """The axis has just come under control: the first `next` follows from `axis.position`."""

    def next(self) -> float:
        """The set value of this cycle, in the unit of `mode`; positions are whole numbers of increments."""

    def end(self) -> None:
        """The axis is not under control any more."""


class DriveEnd(Protocol):
    """What is behind an axis: a drive on the ring, or a simulated one."""

    @property
    def status(self) -> int:
        """Drive status word, without the service channel's bits."""

    def read(self, idn: int, element: Element, done: Done) -> None:
        """Over the service channel: `done` comes many cycles later.  Lists and texts without their lengths."""

    def write(self, idn: int, data: bytes, done: Done) -> None: ...

    def command(self, idn: int, done: Callable[[bool], None]) -> None:
        """A procedure command; `done` gets whether it went well."""


class Axis:
    """Made by the controller; faces use it, and never build one.

    After each ring cycle `position`, `velocity`, `torque` are those of the cycle; then `watchers` hear of a change of
    state or diagnosis; then whoever asked with `Controller.each_cycle` is called; then the set values are asked for.
    """

    def __init__(self, name: str, one: Object, ring_address: int, diagnosis: Diagnosis, *, is_simulated: bool) -> None:
        self.name = name
        """The symbolic name."""
        self.object = one
        self.ring_address = ring_address
        """`RealTimeBusAdr`; has nothing to do with the logical address."""
        self.diagnosis = diagnosis
        self.is_simulated = is_simulated
        self.sender = Sender("MC_4", name)
        self.drive: DriveEnd | None = None
        """None while there is no drive on the ring."""
        self.is_operating = False
        """The drive is on the ring and cyclic data go both ways (CP4)."""
        self.is_controlled = False
        """Set values are followed."""
        self.modes: frozenset[Mode] = frozenset(Mode)
        """Whose set values are in the drive's telegram.  In another mode the axis stands still."""
        self.is_enabled = False
        """ControllerEnable."""
        self.axis_state = AxisState.NO_HARDWARE_ENABLE
        self.mc4_state = 0x03
        """As the drive shows it: 0x03, 0x10, 0x21 and so on."""
        self.position = 0
        """Actual, in increments."""
        self.velocity = 0.0
        """Actual, in increments per second."""
        self.torque = 0
        """Actual, in 0.1 % of the motor's rated torque."""
        self.set_value: float = 0
        """What was last sent to the drive, in the unit of the mode."""
        self.mode = Mode.POSITION
        """The mode of `set_value`."""
        self.set_values: SetValues | None = None
        self.watchers: list[Callable[[], None]] = []
        """Called when state, enable, diagnosis or the source of set values have changed."""
        self._quit: Callable[[Axis, Callable[[bool], None] | None], None] | None = None

    @property
    def status_word(self) -> int:
        """Of the drive's AT, S-0-0135, without the service channel's bits; 0 without a drive."""
        return 0 if self.drive is None else self.drive.status

    @property
    def log_adr(self) -> int:
        """The logical address: what IEC code calls the axis by."""
        return self.object.log_adr

    @property
    def is_in_error(self) -> bool:
        """A diagnosis with an error reaction is pending (classes 1 to 5), or the drive says so."""
        return self.diagnosis.is_error

    @property
    def diag_code(self) -> int:
        """DiagCode; 0: nothing is pending."""
        return self.diagnosis.code

    @property
    def diag_msg(self) -> str:
        return self.diagnosis.msg

    @property
    def following_error(self) -> int:
        """Set minus actual position; 0 in other modes."""
        return round(self.set_value) - self.position if self.mode is Mode.POSITION and self.is_controlled else 0

    def enable(self, is_on: bool) -> None:
        """ControllerEnable.  It holds until it is taken away, also over errors; the drive decides what comes of it."""
        if is_on is not self.is_enabled:
            self.is_enabled = is_on
            self.changed()

    def quit_errors(self, done: Callable[[bool], None] | None = None) -> None:
        """Quit this axis' diagnoses: in the drive (S-0-0099, over the service channel), then here."""
        if self._quit is not None:
            self._quit(self, done)

    def follow(self, set_values: SetValues | None) -> None:
        """From the next cycle on; None: stand still where it is."""
        before, self.set_values = self.set_values, set_values
        if self.is_controlled:
            if before is not None:
                before.end()
            self._begin()
        self.changed()

    def read(self, idn: int, done: Done, element: Element = Element.DATA) -> None:
        """A parameter of the drive; slow (PD-028).  `done` gets the bytes, or a ServiceError, maybe at once."""
        if self.drive is None:
            done(ServiceError(NOT_THERE))
        else:
            self.drive.read(idn, element, done)

    def write(self, idn: int, data: bytes, done: Done) -> None:
        if self.drive is None:
            done(ServiceError(NOT_THERE))
        else:
            self.drive.write(idn, data, done)

    # ---- by the controller

    def enter(self, state: AxisState, mc4_state: int, *, is_operating: bool = True) -> None:
        """What the drive says, or that it says nothing any more."""
        was_controlled = self.is_controlled
        self.axis_state, self.mc4_state, self.is_operating = state, mc4_state, is_operating
        self.is_controlled = is_operating and state is AxisState.CONTROLLED
        if self.is_controlled and not was_controlled:
            self._begin()
        elif was_controlled and not self.is_controlled and self.set_values is not None:
            self.set_values.end()
        self.changed()

    def ask(self) -> tuple[Mode, float]:
        """Once a cycle, under control: the next set value."""
        source = self.set_values
        if source is None or source.mode not in self.modes:
            if self.mode is not Mode.POSITION:
                self._stand()
        else:
            self.mode, self.set_value = source.mode, source.next()
        return self.mode, self.set_value

    def changed(self) -> None:
        for watcher in self.watchers:
            watcher()

    def on_quit(self, action: "Callable[[Axis, Callable[[bool], None] | None], None]") -> None:
        """The controller's way of quitting an axis."""
        self._quit = action

    def _begin(self) -> None:
        self._stand()
        if self.set_values is not None:
            self.set_values.begin(self)

    def _stand(self) -> None:
        self.mode, self.set_value = Mode.POSITION, self.position
