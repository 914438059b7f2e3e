"""The object real-time bus: it brings the fibre ring up, keeps it, and says what is wrong with it.

Source: PacDrive manual 456, 5344-5355, 6042-6044 (digest PD-130 to PD-141); the manual says nothing about phases and
failures, so what is reported when is our choice.  A drive that doesn't answer is left out or stops the phase-up, by a
setting.  A ring that has come down stays down until somebody quits; then it is tried again, and the drives' own
diagnoses are quitted with it.
"""

from collections.abc import Mapping, Sequence
from enum import Enum, auto
from typing import Final, Protocol

from fieldrig.clock import MS, Clock, Timer
from fieldrig.link import Link
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.configuration.version import Version, goes_with, version_of
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.ring.drive_end import ALL, RingDrive
from fieldrig_devices.max4.ring.drive_parameters import DriveParameters
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.idn import idn_text
from fieldrig_devices.sercos.master import SercosMaster
from fieldrig_devices.sercos.preparation import NO_IDN
from fieldrig_devices.sercos.ring_drive import Event, RingEvent

AGAIN_NS: Final = 3 * MS
"""Between two attempts: the last cycle of the one is over."""
TRANSITION: Final = std.CP3_TRANSITION_CHECK


class State(Enum):
    OFF = auto()
    RISING = auto()
    """Phases 0 to 3."""
    READING = auto()
    """Operation; parameters of the drives are being read."""
    UP = auto()
    DOWN = auto()
    """Until somebody quits."""


class Host(Protocol):
    """What the bus tells the controller."""

    def report_ring(self, code: Code, ext: str = "") -> None: ...

    def report_axis(self, code: int, axis: Axis, ext: str = "", *, is_logged: bool = True) -> None: ...

    def on_ring_settled(self) -> None:
        """Up, or given up."""

    def on_ring_cycle(self) -> None:
        """In operation, when the answers of a cycle are there."""

    def on_ring_lost(self) -> None:
        """No cycles until it is settled again."""

    def quit_axes(self) -> None:
        """The ring has come up because somebody quitted: so are the drives that are on it."""


class RealTimeBus:
    def __init__(
        self,
        clock: Clock,
        link: Link[RingMessage],
        host: Host,
        drives: Sequence[RingDrive],
        parameters: Mapping[str, DriveParameters],
        *,
        cycle_ns: int,
        wait_ns: int,
        version: Version,
        leave_out_missing: bool,
    ) -> None:
        """`parameters` by the names of the axes; `wait_ns`: for an open ring."""
        self._clock, self._link, self._host = clock, link, host
        self._drives, self._parameters = tuple(drives), parameters
        self._cycle_ns, self._wait_ns = cycle_ns, wait_ns
        self._version, self._leave_out_missing = version, leave_out_missing
        self.state = State.OFF
        self.is_open = True
        self.present: tuple[RingDrive, ...] = ()
        """Those that the ring is brought up with."""
        self._absent: set[int] = set()
        self._master: SercosMaster | None = None
        self._is_quitting = self._has_been_up = False
        self._unread = 0
        self._wait: Timer | None = None
        self._lost: dict[int, int] = {}

    @property
    def phase(self) -> int:
        return self._master.phase if self._master is not None else 0

    def at_errors(self, address: int) -> int:
        """ATs of a drive that did not come, since power-on."""
        present = self._master.drives.get(address) if self._master is not None else None
        return self._lost.get(address, 0) + (present.lost if present is not None else 0)

    @property
    def missed_cycles(self) -> int:
        """Cycles that this computer was too late for, in this phase-up."""
        return self._master.missed_cycles if self._master is not None else 0

    # ---- up and down

    def bring_up(self, *, is_quitting: bool = False) -> None:
        """`is_quitting`: the drives' diagnoses are to be quitted when the ring is up."""
        self._is_quitting = is_quitting
        self._drop_master()
        self.present = tuple(one for one in self._drives if one.axis.ring_address not in self._absent)
        if not self.present:
            self._settle(State.DOWN if self._drives else State.UP)
            return
        self.state = State.RISING
        self.is_open = True
        self._master = master = self._made_master()
        master.start()
        master.request_phase(4)
        self._wait = self._clock.call_at(self._clock.now_ns() + self._wait_ns, self._on_wait_over)

    def _made_master(self) -> SercosMaster:
        """With as many set and actual values as the cycle has room for; without room even so, it says so itself."""
        fewer = [(count, 0) for count in range(len(ALL), 0, -1)]
        for count, short_cycle_ns in (*fewer, (1, self._cycle_ns)):
            for one in self.present:
                one.lay_out(ALL[:count], short_cycle_ns)
            drives = [one.drive for one in self.present]
            master = SercosMaster(
                self._clock,
                self._link,
                self._cycle_ns,
                drives,
                on_event=self._on_event,
                on_cycle=self._host.on_ring_cycle,
            )
            if master.needed_ns() <= self._cycle_ns:
                break
        return master

    def stop(self) -> None:
        """Power-off or reset."""
        self._drop_master()
        for one in self.present:
            one.end()
        self.present = ()
        self.state = State.OFF
        self._absent.clear()
        self._has_been_up = False

    def quit(self) -> None:
        """Try again what failed, if it can be."""
        is_up_without_some = self.state is State.UP and bool(self._absent)
        is_in_use = any(one.axis.is_controlled for one in self.present)
        if (self.state is State.DOWN and not self.is_open) or (is_up_without_some and not is_in_use):
            self._absent.clear()
            was_up = self.state is State.UP
            self.state = State.RISING
            if was_up:
                self._leave()
            self._try_again(is_quitting=True)

    def is_still_wrong(self, code: int) -> bool:
        """Whether the cause of a diagnosis of the ring is there."""
        return code % 1000 == Code.RING_OPEN % 1000 and self.is_open and self.state is State.DOWN

    def _drop_master(self) -> None:
        if self._wait is not None:
            self._wait.cancel()
        if self._master is not None:
            self._master.stop()
            for address, drive in self._master.drives.items():
                self._lost[address] = self._lost.get(address, 0) + drive.lost
                drive.lost = 0
            self._master = None

    def _try_again(self, *, is_quitting: bool) -> None:
        self._drop_master()

        def again() -> None:
            if self.state is State.RISING:
                self.bring_up(is_quitting=is_quitting)

        self._wait = self._clock.call_at(self._clock.now_ns() + AGAIN_NS, again)

    def _on_wait_over(self) -> None:
        if self.state is State.RISING and self.phase == 0 and self.is_open and self._master is not None:
            self._master.request_phase(0)
            self._host.report_ring(Code.RING_OPEN)
            self._fail_axes()
            self._settle(State.DOWN)

    def _settle(self, state: State) -> None:
        self.state = state
        self._host.on_ring_settled()

    # ---- what the ring says

    def _on_event(self, event: RingEvent) -> None:
        match event.what:
            case Event.CLOSED:
                self.is_open = False
            case Event.OPEN:
                self.is_open = True
                if self.state in (State.READING, State.UP) or self.phase > 0:
                    self._host.report_ring(Code.RING_OPEN)
            case Event.MISSING:
                self._absent.add(event.address)
                self._host.report_axis(Code.DRIVE_MISSING, self._axis(event.address))
            case Event.REFUSED:
                idn = event.idn if event.idn != NO_IDN else TRANSITION
                ext = f"{idn_text(idn)} {event.code:04x}"
                self._host.report_axis(Code.DRIVE_REFUSED, self._axis(event.address), ext)
            case Event.NO_ROOM:
                self._host.report_ring(Code.NO_ROOM, f"{event.code} us")
            case Event.AT_FAILED if event.code == 2 and not self.is_open:
                self._host.report_axis(Code.AT_FAILED, self._axis(event.address))
            case Event.PHASE:
                self._on_phase(event.code)

    def _axis(self, address: int) -> Axis:
        return next(one.axis for one in self._drives if one.axis.ring_address == address)

    def _on_phase(self, phase: int) -> None:
        if phase == 4:
            self._on_operation()
        elif phase == 0 and self.state in (State.RISING, State.READING, State.UP):
            self._on_down()

    def _on_down(self) -> None:
        was_rising = self.state is State.RISING
        self._leave()
        if was_rising and self._absent and self._leave_out_missing and not self.is_open:
            self.state = State.RISING
            self._try_again(is_quitting=self._is_quitting)
            return
        if self.is_open:
            self._fail_axes()
        self._settle(State.DOWN)

    def _leave(self) -> None:
        for one in self.present:
            one.end()
        self._host.on_ring_lost()

    def _fail_axes(self) -> None:
        """The open ring has its one entry in the log, and each axis its diagnosis."""
        for one in self._drives:
            self._host.report_axis(Code.RING_OPEN, one.axis, is_logged=False)

    # ---- in operation

    def _on_operation(self) -> None:
        assert self._master is not None
        self.state = State.READING
        self._unread = len(self.present)
        for one in self.present:
            one.begin(self._master)
        for one in self.present:
            self._parameters[one.axis.name].exchange(self._on_read)

    def _on_read(self) -> None:
        self._unread -= 1
        if self._unread or self.state is not State.READING:
            return
        for one in self.present:
            self._check_version(one)
        if self._has_been_up:
            self._host.report_ring(Code.RING_UP)
        self._has_been_up = True
        self._settle(State.UP)
        if self._is_quitting:
            self._host.quit_axes()

    def _check_version(self, one: RingDrive) -> None:
        """MAx-4 and MC-4 (digest PD-332); a drive that says nothing of the kind fits nothing."""
        text = str(one.axis.object["FirmwareVersion"].value)
        try:
            fits = goes_with(self._version, version_of(text))
        except ValueError:
            fits = False
        one.is_refused = not fits
        if not fits:
            self._host.report_axis(Code.VERSION, one.axis, text)
