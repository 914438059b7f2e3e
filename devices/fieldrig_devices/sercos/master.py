"""The master of the ring: it brings the drives up phase by phase, and then runs the cycle.

Source: IEC 61491 by its public facts.  In CP0 the master waits for its own MST to come round ten times; in CP1 it
addresses each drive; in CP2 it reads the times that each drive needs, writes the timing of the ring, and lets the drive
check it (S-0-0127); in CP3 the telegrams have their final form, and S-0-0128 leads to CP4.  Two missing ATs in a row
bring the ring down to CP0, and so does an open ring in CP1 to CP4.  Up to CP2 the cycle is 1 ms.
"""

import struct
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from fieldrig.clock import MS, US, Alarm, Clock
from fieldrig.link import Link, patience_of
from fieldrig_bus.ring.sercos.message import BROADCAST, Answers, Mdt, Mst, RingMessage
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.idn import Element, ServiceError
from fieldrig_devices.sercos.plan import RingPlan
from fieldrig_devices.sercos.preparation import Script, preparation
from fieldrig_devices.sercos.ring_drive import Drive, Event, RingEvent
from fieldrig_devices.sercos.service import CONTROL_MASK, STATUS_MASK, Done
from fieldrig_devices.sercos.telegram import HEAD_BYTES

EARLY_CYCLE_NS: Final = 1 * MS
"""Cycle time in CP0 to CP2, where the master chooses it."""
CLOSED_CYCLES: Final = 10
"""Cycles in which the MST has to come round in CP0."""
CALLS: Final = 10
"""Number of calls for an answer in CP1."""
MOST_MISSED: Final = 2
MOST_SETTLING: Final = 50
"""Cycles after entering a phase in which an AT may be missing; our choice."""
SETTLING_NS: Final = 100 * US
"""Time between the end of the MDT and command valid time."""


class SercosMaster:
    """The master of a ring and its drives."""

    def __init__(
        self,
        clock: Clock,
        link: Link[RingMessage],
        cycle_ns: int,
        drives: Sequence[Drive],
        *,
        mbaud: int = 4,
        early_cycle_ns: int = EARLY_CYCLE_NS,
        settling_ns: int = SETTLING_NS,
        on_event: Callable[[RingEvent], None],
        on_cycle: Callable[[], None],
    ) -> None:
        """`drives` are in the order of the ring.

        `on_cycle` is called in CP4 after the feedback of a cycle has arrived and before its command values are sent.
        """
        self._clock, self._link, self._early_cycle_ns = clock, link, early_cycle_ns
        self.plan = RingPlan(drives, cycle_ns, mbaud, settling_ns)
        self.drives = {drive.address: drive for drive in drives}
        self._order = tuple(drives)
        patience_cycles = patience_of(link) // early_cycle_ns
        self._most_calls = CALLS + patience_cycles
        for drive in drives:
            drive.client.more_patience = patience_cycles
        self._on_event, self._on_cycle = on_event, on_cycle
        self.phase = 0
        self._target = 0
        self._number = 0
        self._closed_cycles = 0
        self._is_closed: bool | None = None
        self._called = 0
        self._script: Script | None = None
        self._waiting_for = 0
        self._had_missed = False
        self._settling = 0
        self._mdt_record = struct.Struct("<B")
        self._values: list[int] = []
        self._busy: list[Drive] = []
        self._timer = Alarm(self._clock)
        self._next_ns = 0
        self.missed_cycles = 0
        """Cycles that the master itself missed because it was late."""
        self.missed_ns = 0
        """The time of these cycles."""
        self.wrong_fcs = 0
        link.on_receive(self._on_message, ["master"])

    # ---- requests of the controller

    def start(self) -> None:
        """Start the cycle, in CP0 until a phase is requested."""
        self._next_ns = self._clock.now_ns()
        self._tick()

    def stop(self) -> None:
        self._timer.stop()

    def request_phase(self, phase: int) -> None:
        """Go to a phase, 0 to 4.  A lower phase is reached through CP0."""
        self._target = phase
        if phase < self.phase:
            self._go_down()

    def set_commands(self, address: int, control: int, *values: int) -> None:
        """Set the control word, without the service channel's bits, and the command values of the next MDTs."""
        drive = self.drives[address]
        drive.control = control
        place = drive.place
        table = self._values
        if place:
            table[place] = control | drive.client.control
            table[place + 2 : place + 2 + len(values)] = values

    @property
    def command_values(self) -> list[int]:
        """The values of the MDTs from CP3 on, for hot paths that cannot afford `set_commands`.

        The command values of a drive begin two places behind its `place`.  Each phase-up creates a new list.
        """
        return self._values

    def read(self, address: int, idn: int, element: Element, done: Done) -> None:
        """Read an element over the service channel.  The request waits for CP2 and for those before it."""
        drive = self.drives[address]
        drive.client.read(idn, element, done)
        self._activate(drive)

    def write(self, address: int, idn: int, data: bytes, done: Done) -> None:
        drive = self.drives[address]
        drive.client.write(idn, data, done)
        self._activate(drive)

    def command(self, address: int, idn: int, done: Callable[[bool], None]) -> None:
        """Set a procedure command, wait for its end and clear it; `done` gets True if it succeeded."""
        client = self.drives[address].client

        def on_set(outcome: bytes | ServiceError) -> None:
            if isinstance(outcome, ServiceError):
                done(False)
            else:
                client.read(idn, Element.IDN, on_status)

        def on_status(outcome: bytes | ServiceError) -> None:
            if isinstance(outcome, ServiceError):
                done(False)
                return
            status = int.from_bytes(outcome, "little") & 0xF
            if status == Command.ACTIVE:
                client.read(idn, Element.IDN, on_status)
            else:
                client.write(idn, b"\0\0", lambda _outcome: done(status == Command.DONE))

        self.write(address, idn, b"\x03\0", on_set)

    def _activate(self, drive: Drive) -> None:
        if drive not in self._busy:
            self._busy.append(drive)

    # ---- cycles

    def _tick(self) -> None:
        self._number += 1
        period_ns = self.plan.cycle_ns if self.phase >= 3 else self._early_cycle_ns
        # late_ns alone is not enough: after a stall the clock continues from the present.
        late = (self._clock.now_ns() + self._clock.late_ns() - self._next_ns) // period_ns
        self.missed_cycles += late
        self.missed_ns += late * period_ns
        self._next_ns += period_ns * (1 + late)
        self._timer.at(self._next_ns, self._tick)
        self._link.send(Mst(self._number, bytes((BROADCAST, self.phase))))

    def _on_message(self, message: RingMessage) -> None:
        if not isinstance(message, Answers) or message.number != self._number & 0xFFFF_FFFF:
            return
        self.wrong_fcs += message.errors
        if message.ring_closed is not self._is_closed:
            self._on_ring(message.ring_closed)
        match self.phase:
            case 0:
                self._in_phase_0(message)
            case 1:
                self._in_phase_1(message)
            case 2:
                self._in_phase_2(message)
            case _:
                self._in_operation(message)

    def _on_ring(self, is_closed: bool) -> None:
        was_closed, self._is_closed = self._is_closed, is_closed
        self._closed_cycles = 0
        if is_closed:
            self._tell(Event.CLOSED)
        elif was_closed is not None or self.phase == 0:
            self._tell(Event.OPEN)

    def _in_operation(self, answers: Answers) -> None:
        drives = self.drives
        ats, heard = answers.ats, 0
        for at in ats:
            drive = drives.get(at[0])
            if drive is not None and len(at) == drive.at_length:
                drive.values = drive.values_of(at, 1)
                heard += 1
        if self._settling:
            self._settle(ats)
        elif heard != len(self._order):
            self._miss(ats)
        elif self._had_missed:
            self._forget_missed()
        if self._busy:
            self._serve()
        if self.phase == 4:
            self._on_cycle()
        if self.phase >= 3:
            self._link.send(Mdt(self._mdt_record.pack(*self._values)))
        else:
            self._link.send(Mdt(b""))

    def _settle(self, ats: Sequence[bytes]) -> None:
        """Tolerate missing ATs after a change of phase until every drive was heard once, as drives are busy then.

        In CP2 only the drive that was addressed answers, and only for one cycle.
        """
        self._settling -= 1
        heard = self._heard(ats)
        is_missed = False
        for drive in self._order:
            is_here = drive.address in heard
            is_missed |= not is_here
            drive.missed = int(not is_here and self._settling > 0)  # the service channel waits meanwhile
        self._had_missed = is_missed
        if not is_missed:
            self._settling = 0

    def _serve(self) -> None:
        """Serve the active service channels."""
        table = self._values
        for drive in tuple(self._busy):
            if self.phase < 3:  # an answer has brought the ring down
                return
            client = drive.client
            if drive.missed:
                client.wait()
            else:
                client.step(drive.status & STATUS_MASK, drive.info)
            if drive.place:
                table[drive.place] = drive.control & ~CONTROL_MASK | client.control
                table[drive.place + 1] = client.info
            if client.is_idle and drive in self._busy:
                self._busy.remove(drive)

    def _miss(self, ats: Sequence[bytes]) -> None:
        heard = self._heard(ats)
        self._had_missed = True
        is_down = False
        for drive in self._order:
            if drive.address in heard:
                drive.missed = 0
                continue
            drive.missed += 1
            drive.lost += 1
            if drive.missed <= MOST_MISSED:
                self._tell(Event.AT_FAILED, drive.address, code=drive.missed)
            is_down |= drive.missed >= MOST_MISSED
        if is_down:
            self._go_down()
            self._target = 0

    def _heard(self, ats: Sequence[bytes]) -> set[int]:
        """Return the addresses of the drives whose AT arrived with the right length."""
        return {at[0] for at in ats if at[0] in self.drives and len(at) == self.drives[at[0]].at_length}

    def _forget_missed(self) -> None:
        self._had_missed = False
        for drive in self._order:
            drive.missed = 0

    # ---- phase-up

    def _in_phase_0(self, answers: Answers) -> None:
        self._closed_cycles = self._closed_cycles + 1 if answers.ring_closed else 0
        if self._target > 0 and self._closed_cycles >= CLOSED_CYCLES:
            self._called = 0
            for drive in self._order:
                drive.calls, drive.is_here, drive.missed = 0, False, 0
            self._reach(1)
        self._link.send(Mdt(b""))

    def _in_phase_1(self, answers: Answers) -> None:
        """Address each drive until it answers, at most ten times."""
        if not answers.ring_closed:
            self._fall()
            return
        drive = self._order[self._called] if self._called < len(self._order) else None
        if drive is not None and drive.calls:
            drive.is_here = any(at[0] == drive.address for at in answers.ats)
            if not drive.is_here and drive.calls >= self._most_calls:
                self._tell(Event.MISSING, drive.address)
            if drive.is_here or drive.calls >= self._most_calls:
                self._called += 1
                drive = self._order[self._called] if self._called < len(self._order) else None
        if drive is not None:
            drive.calls += 1
            self._link.send(Mdt(bytes((drive.address, 0, 0, 0, 0))))
        elif all(drive.is_here for drive in self._order):
            self._link.send(Mdt(b""))
            if self._target > 1:
                self._reach(2)
            if self.phase == 2:
                self._called = 0
                self._begin_script()
        else:
            self._fall()

    def _in_phase_2(self, answers: Answers) -> None:
        if not answers.ring_closed:
            self._fall()
            return
        if self._called >= len(self._order):
            self._link.send(Mdt(b""))
            if self._target > 2:
                self._lay_out()
                self._reach(3)
                self._check_all()
            return
        drive = self._order[self._called]
        at = next(
            (telegram for telegram in answers.ats if telegram[0] == drive.address and len(telegram) == 1 + HEAD_BYTES),
            None,
        )
        if at is None:
            drive.client.wait()
        else:
            drive.client.step(int.from_bytes(at[1:3], "little") & STATUS_MASK, int.from_bytes(at[3:5], "little"))
        if self.phase == 2:
            head = drive.client.control.to_bytes(2, "little") + drive.client.info.to_bytes(2, "little")
            self._link.send(Mdt(bytes((drive.address,)) + head))
        else:
            self._link.send(Mdt(b""))

    def _begin_script(self) -> None:
        """Start the preparation of the next drive in CP2."""
        if self._called < len(self._order):
            drive = self._order[self._called]
            self._script = self.prepare(drive)
            self._go_on(drive, None)

    def _go_on(self, drive: Drive, answer: bytes | None) -> None:
        assert self._script is not None
        try:
            ask = next(self._script) if answer is None else self._script.send(answer)
        except StopIteration:
            self._called += 1
            self._begin_script()
            return

        def on_done(outcome: bytes | ServiceError) -> None:
            if self.phase != 2:
                return
            if isinstance(outcome, ServiceError):
                self._tell(Event.REFUSED, drive.address, ask.idn, outcome.code)
                self._fall()
            else:
                self._go_on(drive, outcome)

        if ask.data is None:
            drive.client.read(ask.idn, ask.element, on_done)
        else:
            drive.client.write(ask.idn, ask.data, on_done)

    def prepare(self, drive: Drive) -> Script:
        """Return the script that prepares a drive in CP2."""
        return preparation(drive, partial(self.plan.timing, drive))

    def needed_ns(self) -> int:
        """Shortest possible cycle with these drives."""
        return self.plan.needed_ns()

    def _lay_out(self) -> None:
        self._mdt_record, self._values = self.plan.lay_out()
        for drive in self._order:
            self._values[drive.place] = drive.control & ~CONTROL_MASK | drive.client.control
            self._values[drive.place + 1] = drive.client.info

    def _check_all(self) -> None:
        """Run S-0-0128 in every drive; the last one leads to CP4."""
        self._waiting_for = len(self._order)
        for drive in self._order:
            self.command(drive.address, std.CP4_TRANSITION_CHECK, partial(self._on_checked, drive))

    def _on_checked(self, drive: Drive, is_good: bool) -> None:
        if self.phase != 3:
            return
        if not is_good:
            self._tell(Event.REFUSED, drive.address, std.CP4_TRANSITION_CHECK)
            self._go_down()
            self._target = 0
            return
        self._waiting_for -= 1
        if not self._waiting_for and self._target > 3:
            self._reach(4)

    def _reach(self, phase: int) -> None:
        if phase == 2 and self.needed_ns() > self.plan.cycle_ns:
            self._tell(Event.NO_ROOM, code=self.needed_ns() // US)
            self._go_down()
            self._target = 0
            return
        self.phase = phase
        self._settling = MOST_SETTLING if phase >= 3 else 0
        self._tell(Event.PHASE, code=phase)

    def _fall(self) -> None:
        self._target = 0
        self._go_down()
        self._link.send(Mdt(b""))

    def _go_down(self) -> None:
        self.phase = 0
        self._closed_cycles = 0
        self._script = None
        self._busy.clear()
        for drive in self._order:
            drive.place = 0
            drive.client.reset()
        self._tell(Event.PHASE, code=0)

    def _tell(self, what: Event, address: int = 0, idn: int = 0, code: int = 0) -> None:
        self._on_event(RingEvent(what, address, idn, code))
