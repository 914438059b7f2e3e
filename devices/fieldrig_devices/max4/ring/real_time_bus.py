"""The object real-time bus, which brings the fibre ring up, operates it, and reports its failures.

Source: PacDrive manual 456, 5344-5355, 6042-6044 (digest PD-130 to PD-141); the manual does not describe phases and
failures, so the reports are our choice.  A drive that does not answer is left out or stops the phase-up, by a setting.
A ring that has failed stays down until its diagnosis is acknowledged ("quit"); then it is brought up again, and the
diagnoses of the drives are acknowledged too.
"""

from collections.abc import Mapping, Sequence
from enum import Enum, auto
from typing import Final, Protocol

from fieldrig.clock import MS, Alarm, Clock
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

RETRY_NS: Final = 3 * MS
"""Time between two attempts, after which the last cycle of the first one has ended."""
TRANSITION: Final = std.CP3_TRANSITION_CHECK


class RingState(Enum):
    """States of the ring."""

    OFF = auto()
    RISING = auto()
    """The ring is in phases 0 to 3."""
    READING = auto()
    """The ring is in operation, and the parameters of the drives are being read."""
    UP = auto()
    DOWN = auto()
    """The ring has failed, until its diagnosis is acknowledged."""


class Host(Protocol):
    """The controller, as the ring reports to it."""

    def report_ring(self, code: Code, ext: str = "") -> None: ...

    def report_axis(self, code: int, axis: Axis, ext: str = "", *, is_logged: bool = True) -> None: ...

    def on_ring_settled(self) -> None:
        """Called when the ring is up or has failed."""

    def on_ring_cycle(self) -> None:
        """Called once per cycle in operation, when the answers have arrived."""

    def on_ring_lost(self) -> None:
        """Called when the cycles stop, until the ring is in operation again."""

    def quit_axes(self) -> None:
        """Acknowledge the diagnoses of the drives, after the ring has come up again on an acknowledgement."""


class RealTimeBus:
    """The ring of one boot."""

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
        """`parameters` are by the names of the axes; `wait_ns` is the longest wait for an open ring to close."""
        self._clock, self._link, self._host = clock, link, host
        self._drives, self._parameters = tuple(drives), parameters
        self._cycle_ns, self._wait_ns = cycle_ns, wait_ns
        self._version, self._leave_out_missing = version, leave_out_missing
        self.state = RingState.OFF
        self.is_open = True
        self.present: tuple[RingDrive, ...] = ()
        """The drives with which the ring is brought up."""
        self._absent: set[int] = set()
        self._master: SercosMaster | None = None
        self._is_quitting = self._has_been_up = False
        self._unread = 0
        self._wait = Alarm(self._clock)
        self._missed_ns = 0
        """The time by which the present wait for the ring is longer already."""
        self._lost: dict[int, int] = {}

    @property
    def phase(self) -> int:
        return self._master.phase if self._master is not None else 0

    def at_errors(self, address: int) -> int:
        """Number of ATs of a drive that did not arrive, since power-on."""
        present = self._master.drives.get(address) if self._master is not None else None
        return self._lost.get(address, 0) + (present.lost if present is not None else 0)

    @property
    def missed_cycles(self) -> int:
        """Number of cycles since the last phase-up for which the host was too late."""
        return self._master.missed_cycles if self._master is not None else 0

    # ---- up and down

    def bring_up(self, *, is_quitting: bool = False) -> None:
        """Bring the ring up; with `is_quitting`, acknowledge the diagnoses of the drives once it is up."""
        self._is_quitting = is_quitting
        self._drop_master()
        self.present = tuple(drive for drive in self._drives if drive.axis.ring_address not in self._absent)
        if not self.present:
            self._settle(RingState.DOWN if self._drives else RingState.UP)
            return
        self.state = RingState.RISING
        self.is_open = True
        self._master = master = self._made_master()
        master.start()
        master.request_phase(4)
        self._missed_ns = 0
        self._wait.after(self._wait_ns, self._on_wait_over)

    def _made_master(self) -> SercosMaster:
        """A master with as many set and actual values as fit into the cycle; if none fit, the master reports that."""
        fewer = [(count, 0) for count in range(len(ALL), 0, -1)]
        for count, short_cycle_ns in (*fewer, (1, self._cycle_ns)):
            for ring_drive in self.present:
                ring_drive.lay_out(ALL[:count], short_cycle_ns)
            drives = [ring_drive.drive for ring_drive in self.present]
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
        """Stop the ring, at power-off or reset."""
        self._drop_master()
        for drive in self.present:
            drive.end()
        self.present = ()
        self.state = RingState.OFF
        self._absent.clear()
        self._has_been_up = False

    def quit(self) -> None:
        """Bring the ring up again if it has failed or is up without some drives, and if that is possible."""
        is_up_without_some = self.state is RingState.UP and bool(self._absent)
        is_in_use = any(drive.axis.is_controlled for drive in self.present)
        if (self.state is RingState.DOWN and not self.is_open) or (is_up_without_some and not is_in_use):
            self._absent.clear()
            was_up = self.state is RingState.UP
            self.state = RingState.RISING
            if was_up:
                self._leave()
            self._try_again(is_quitting=True)

    def is_still_wrong(self, code: int) -> bool:
        """True if the code is a diagnosis of the ring whose cause is still present."""
        return code % 1000 == Code.RING_OPEN % 1000 and self.is_open and self.state is RingState.DOWN

    def _drop_master(self) -> None:
        self._wait.stop()
        if self._master is not None:
            self._master.stop()
            for address, drive in self._master.drives.items():
                self._lost[address] = self._lost.get(address, 0) + drive.lost
                drive.lost = 0
            self._master = None

    def _try_again(self, *, is_quitting: bool) -> None:
        self._drop_master()

        def again() -> None:
            if self.state is RingState.RISING:
                self.bring_up(is_quitting=is_quitting)

        self._wait.after(RETRY_NS, again)

    def _on_wait_over(self) -> None:
        master = self._master
        if self.state is RingState.RISING and self.phase == 0 and self.is_open and master is not None:
            if master.missed_ns > self._missed_ns:
                # In real time a late host is late for the drives too, which may still be starting: it is no wait.
                self._wait.after(master.missed_ns - self._missed_ns, self._on_wait_over)
                self._missed_ns = master.missed_ns
                return
            master.request_phase(0)
            self._host.report_ring(Code.RING_OPEN)
            self._fail_axes()
            self._settle(RingState.DOWN)

    def _settle(self, state: RingState) -> None:
        self.state = state
        self._host.on_ring_settled()

    # ---- events of the ring

    def _on_event(self, event: RingEvent) -> None:
        match event.what:
            case Event.CLOSED:
                self.is_open = False
            case Event.OPEN:
                self.is_open = True
                if self.state in (RingState.READING, RingState.UP) or self.phase > 0:
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
        return next(drive.axis for drive in self._drives if drive.axis.ring_address == address)

    def _on_phase(self, phase: int) -> None:
        if phase == 4:
            self._on_operation()
        elif phase == 0 and self.state in (RingState.RISING, RingState.READING, RingState.UP):
            self._on_down()

    def _on_down(self) -> None:
        was_rising = self.state is RingState.RISING
        self._leave()
        if was_rising and self._absent and self._leave_out_missing and not self.is_open:
            self.state = RingState.RISING
            self._try_again(is_quitting=self._is_quitting)
            return
        if self.is_open:
            self._fail_axes()
        self._settle(RingState.DOWN)

    def _leave(self) -> None:
        for drive in self.present:
            drive.end()
        self._host.on_ring_lost()

    def _fail_axes(self) -> None:
        """Add a diagnosis to each axis; the open ring itself is logged once."""
        for drive in self._drives:
            self._host.report_axis(Code.RING_OPEN, drive.axis, is_logged=False)

    # ---- in operation

    def _on_operation(self) -> None:
        assert self._master is not None
        self.state = RingState.READING
        self._unread = len(self.present)
        for drive in self.present:
            drive.begin(self._master)
        for drive in self.present:
            self._parameters[drive.axis.name].exchange(self._on_read)

    def _on_read(self) -> None:
        self._unread -= 1
        if self._unread or self.state is not RingState.READING:
            return
        for drive in self.present:
            self._check_version(drive)
        if self._has_been_up:
            self._host.report_ring(Code.RING_UP)
        self._has_been_up = True
        self._settle(RingState.UP)
        if self._is_quitting:
            self._host.quit_axes()

    def _check_version(self, drive: RingDrive) -> None:
        """Refuse a drive whose version does not fit the controller (digest PD-332) or is not known."""
        text = str(drive.axis.object["FirmwareVersion"].value)
        try:
            fits = goes_with(self._version, version_of(text))
        except ValueError:
            fits = False
        drive.is_refused = not fits
        if not fits:
            self._host.report_axis(Code.VERSION, drive.axis, text)
