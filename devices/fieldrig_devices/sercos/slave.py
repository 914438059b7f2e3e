"""The ring interface of a drive: phases, telegrams, failures.

Source: IEC 61491 by its public facts.  CP0: the ring is closed by MSTs alone.  CP1: the master addresses each drive.
CP2: parameters over the service channel.  CP3: telegrams have their final form, but their values are not used.  CP4:
operation.  A phase may only be left for the next one, or for CP0; into CP3 and CP4 only after the commands S-0-0127 and
S-0-0128 have found everything right.  Two MSTs or two MDTs missing in a row bring the drive back to CP0 with a class 1
diagnostic.  In CP3 and CP4 the drive times the MSTs itself, so it notices a master that has fallen silent.
Left out: phase 5 (firmware download), and multiplexed data.
"""

import logging
from collections.abc import Callable
from functools import partial
from typing import Final, Protocol

from fieldrig.clock import NEVER_NS, US, Clock
from fieldrig.link import Link, patience_of
from fieldrig.shortcuts import Shortcut
from fieldrig_bus.ring.sercos.message import BROADCAST, Cycle, RingMessage
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.communication import Communication
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.service import CONTROL_MASK, ServiceServer
from fieldrig_devices.sercos.telegram import AT_HEAD, HEAD_BYTES, Telegrams, record

log = logging.getLogger(__name__)

UNDISTURBED: Final = Shortcut(
    "sercos.undisturbed", "a cycle of CP4 like the last one takes no look at phase and failures"
)
MOST_MISSED: Final = 2
"""Missing telegrams in a row that end CP3 and CP4."""
MOST_MISSED_EARLY: Final = 10
"""Missing MSTs in a row that end CP1 and CP2; our choice."""
TOLERANCE_SHARE: Final = 2
"""An MST counts as missing when it is late by the cycle divided by this."""

RUNNING_MST: Final = bytes((BROADCAST, 4))
"""The MST of CP4."""

HEAD_VALUES: Final = 2
"""Number of values before the command values: control word and service channel."""


class Application(Protocol):
    """The application of the drive behind its ring interface."""

    def on_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        """Return the status word, without the service channel's bits, and the feedback values.

        It is called once per cycle in CP4.

        `values` are those of the MDT: control word, service channel, and from `HEAD_VALUES` on the command values.
        """

    def on_missed_cycle(self, values: tuple[int, ...]) -> tuple[int, bytes]:
        """Called in CP4 instead of `on_cycle` if MST or MDT is missing; `values` are those of the last MDT."""

    def status(self) -> int:
        """Return the status word in CP1 to CP3."""

    def feedback(self) -> bytes:
        """Return the feedback values in CP3."""

    def on_phase(self, phase: int) -> None:
        """Called when a phase has been entered."""

    def on_ring_failure(self) -> None:
        """Called after the fall back to CP0, because telegrams failed in CP3 or CP4 or because of a wrong phase."""

    def check(self, phase: int) -> list[int]:
        """Return the IDNs whose values prevent this phase, 3 or 4."""


class SercosSlave:
    """The ring interface of a drive."""

    __slots__ = (
        "_application", "_at_head", "_change_bit", "_clock", "_commands", "_control_seen", "_data", "_failed_in",
        "_forgiven", "_is_checked", "_is_fast", "_leave", "_may_be_fast", "_mdt_length", "_missed_mdts",
        "_missed_msts", "_offset", "_patience_ns", "_service", "_status", "_waits_for_0", "address", "end_of_cycle",
        "failures", "heard", "layout", "phase", "places", "table", "values", "values_of", "watchdog", "window_ns",
    )  # fmt: skip

    def __init__(
        self, clock: Clock, link: Link[RingMessage], address: int, table: IdnTable, application: Application
    ) -> None:
        """The slave adds the communication's own data to `table`; `address` is 1 to 254."""
        self._clock, self._leave, self.address, self.table = clock, link.send, address, table
        self._application = application
        self.end_of_cycle: Callable[[], None] | None = None
        """Called after the answer to each cycle, if it is set."""
        self.phase = 0
        self.failures = 0
        """Failure bits of S-0-0014 until `clear_failures`; its phase is that of the first failure."""
        self._service = ServiceServer(table, lambda: self.phase)
        self._failed_in = 0
        """Phase of the first failure."""
        self._data = Communication(table, self._interface_status, self._check, self._on_command_end)
        self._commands = list(self._data.commands)
        self._change_bit = 0
        self._control_seen = 0
        self.values: tuple[int, ...] = (0, 0)
        """Values of the last MDT: control word, service channel, command values."""
        self._missed_msts = self._missed_mdts = 0
        self._is_checked = {3: False, 4: False}
        self._waits_for_0 = True
        """True after power-on and after a failure: the drive waits for CP0 before it takes part again."""
        self._is_fast, self._may_be_fast = False, UNDISTURBED.is_taken
        self.layout = self._data.layout()
        """Layout of its record in the MDT, constant from CP3 on."""
        self._offset, self._mdt_length = 0, 0
        self.places: dict[int, int] = {}
        """Positions of the command values among the values of the MDT, by IDN; constant from CP3 on."""
        self.values_of = record(()).unpack_from
        """Unpacks the values of its record from an MDT."""
        self._status: int | None = None
        """Status word in the head of the AT, or None if the head has to be packed again."""
        self._at_head = b""
        self.heard = 0
        """Number of cycles heard."""
        self._forgiven = -1
        """Value of `heard` when this process was late and waited for cycles that may already be queued."""
        self.watchdog = clock.watch(self._on_silence)
        """Expires when two MSTs are missing; every MST restarts it with `window_ns`."""
        self.window_ns = NEVER_NS
        self._patience_ns = patience_of(link)
        """Grace time for a busy host."""
        link.on_receive(self._on_message, [["drive", address]])

    @property
    def telegrams(self) -> Telegrams:
        """IDNs in its records, constant from CP3 on."""
        return self._data.telegrams

    def _interface_status(self) -> int:
        """Return S-0-0014."""
        return self._failed_in | self.failures if self.failures else self.phase

    def clear_failures(self) -> None:
        """Clear the failures (S-0-0099, reset of class 1 diagnostics)."""
        self.failures = 0

    # ---- cycles

    def _on_message(self, message: RingMessage) -> None:
        if message.__class__ is not Cycle:
            return
        mdt = message.mdt
        if not self._is_fast or message.mst != RUNNING_MST or len(mdt) != self._mdt_length or mdt[0] != BROADCAST:
            self._on_cycle(message)
            if self.end_of_cycle is not None:
                self.end_of_cycle()
            return
        self.heard += 1
        self.watchdog.due_ns = self._clock.now_ns() + self.window_ns
        self.values = values = self.values_of(mdt, self._offset)
        control = values[0]
        if (control ^ self._control_seen) & CONTROL_MASK:
            self._on_service(control, values[1])
        status, feedback = self._application.on_cycle(values)
        if status != self._status:
            self._lay_head(status)
        self._leave(self._at_head + feedback)
        if self.end_of_cycle is not None:
            self.end_of_cycle()

    def _on_cycle(self, cycle: Cycle) -> None:
        """Handle any cycle that is not an undisturbed cycle of CP4."""
        self.heard += 1
        if cycle.mst:
            self._missed_msts = 0
            self.watchdog.due_ns = self._clock.now_ns() + self.window_ns
            self._on_mst_phase(cycle.mst[1] & 7 if len(cycle.mst) > 1 else 0)
        else:
            self._miss_mst()
        match self.phase:
            case 1 | 2:
                self._on_early_cycle(cycle)
            case 3 | 4:
                self._on_late_cycle(cycle)

    def _on_early_cycle(self, cycle: Cycle) -> None:
        """Handle a cycle of CP1 or CP2, with an MDT for one drive, and its AT."""
        mdt = cycle.mdt
        if cycle.mst and len(mdt) == 1 + HEAD_BYTES and mdt[0] == self.address:
            if self.phase == 2:
                self._on_service(int.from_bytes(mdt[1:3], "little"), int.from_bytes(mdt[3:5], "little"))
            self._send(self._application.status(), b"")

    def _on_late_cycle(self, cycle: Cycle) -> None:
        is_heard = bool(cycle.mst) and len(cycle.mdt) == self._mdt_length and cycle.mdt[0] == BROADCAST
        if is_heard:
            self._missed_mdts = 0
            self.values = self.values_of(cycle.mdt, self._offset)
            self._on_service(self.values[0], self.values[1])
        elif cycle.mst and not self._miss_mdt():
            return
        self._is_fast = self._may_be_fast and self.phase == 4 and is_heard
        if self.phase == 4:
            go_on = self._application.on_cycle if is_heard else self._application.on_missed_cycle
            self._send(*go_on(self.values))
        elif self.phase == 3:
            self._send(self._application.status(), self._application.feedback())

    def _on_service(self, control: int, info: int) -> None:
        self._control_seen = control
        self._service.step(control, info)
        self._status = None

    def _send(self, status: int, feedback: bytes) -> None:
        self._lay_head(status)
        self._leave(self._at_head + feedback)

    def _lay_head(self, status: int) -> None:
        service = self._service
        self._status = status
        self._at_head = AT_HEAD.pack(self.address, status | self._change_bit | service.status, service.info)

    # ---- failures

    def _miss_mst(self) -> None:
        self._is_fast = False
        self._missed_msts += 1
        if self.phase >= 3:
            self._data.count_mst_failure()
            if self._missed_msts >= MOST_MISSED:
                self._fail(words.MST_FAILED)
        elif self.phase >= 1 and self._missed_msts >= MOST_MISSED_EARLY:
            self._enter(0)

    def _miss_mdt(self) -> bool:
        """Count a missing MDT; True if the ring is still up."""
        self._is_fast = False
        self._missed_mdts += 1
        self._data.count_mdt_failure()
        if self._missed_mdts < MOST_MISSED:
            return True
        self._fail(words.MDT_FAILED)
        return False

    def _fail(self, failure: int) -> None:
        if not self.failures:
            self._failed_in = self.phase
        self.failures |= failure
        self._waits_for_0 = True
        was_in_use = self.phase >= 3
        self._enter(0)
        if was_in_use or failure > words.MDT_FAILED:
            log.info("drive %d: the ring has failed in phase %d", self.address, self._failed_in)
            self._application.on_ring_failure()

    def _on_silence(self) -> None:
        """Fail because the master is silent: without telegrams, the chip reports no cycles.

        If this process is late, cycles may already be queued, and they are handled first.
        """
        late_ns, cycle_ns = self._clock.late_ns(), self._data.cycle_us * US
        if late_ns * TOLERANCE_SHARE > cycle_ns and self._forgiven != self.heard:
            self._forgiven = self.heard
            self.watchdog.due_ns = self._clock.now_ns() + late_ns + cycle_ns
        else:
            self._fail(words.MST_FAILED | words.MDT_FAILED)

    # ---- phases

    def _on_mst_phase(self, phase: int) -> None:
        if phase == 0:
            self._waits_for_0 = False
        if phase == self.phase or self._waits_for_0:
            return
        if phase == 0:
            self._enter(0)
        elif phase > 4:
            self._fail(words.INVALID_PHASE)
        elif phase < self.phase:
            self._fail(words.WRONG_RETURN)
        elif phase > self.phase + 1:
            self._fail(words.WRONG_ADVANCE)
        elif phase >= 3 and not self._is_checked[phase]:
            self._fail(words.NOT_ACKNOWLEDGED)
        else:
            self._enter(phase)

    def _enter(self, phase: int) -> None:
        self.phase = phase
        self._is_fast = False
        self._missed_mdts = 0
        self._watch(phase >= 3)
        if phase <= 1:
            self._service.reset()
            for command in self._commands:
                command.reset()
            self._control_seen = self._change_bit = 0
            self._is_checked = {3: False, 4: False}
        elif phase == 3:
            self._data.clear_counters()
            self._lay_out()
        self._application.on_phase(phase)

    def _watch(self, is_on: bool) -> None:
        cycle_ns = self._data.cycle_us * US
        silence_ns = MOST_MISSED * cycle_ns + cycle_ns // TOLERANCE_SHARE + self._patience_ns
        self.window_ns = silence_ns if is_on else NEVER_NS
        self.watchdog.due_ns = self._clock.now_ns() + self.window_ns

    def _lay_out(self) -> None:
        self.layout = layout = self._data.layout()
        self._offset, self._mdt_length = layout.position, 1 + layout.mdt_length
        self.values_of = record(layout.mdt).unpack_from
        self.values = (0,) * (HEAD_VALUES + len(layout.mdt))
        self.table.cyclic = self.places = {idn: place for place, idn in enumerate(self.telegrams.mdt, HEAD_VALUES)}
        for idn in self.places:
            datum = self.table[idn]
            datum.reader = partial(self._command_value, datum)

    def _command_value(self, datum: Datum) -> bytes:
        """Return a command value: that of the last MDT, if it contains it."""
        place = self.places.get(datum.idn) if self.phase >= 3 else None
        return datum.data if place is None else datum.encoded(self.values[place])

    def _check(self, phase: int, command: Command) -> None:
        """Carry out S-0-0127 or S-0-0128, the check before the next phase."""
        if self.phase != phase - 1:
            command.finish(is_good=False)
            return
        invalid = self._application.check(phase)
        if phase == 3:
            invalid = sorted({*invalid, *self._data.invalid()})
        self._data.show_invalid(phase, invalid)
        self._is_checked[phase] = not invalid
        command.finish(is_good=self._is_checked[phase])

    def _on_command_end(self, has_ended: bool) -> None:
        self._change_bit = words.COMMAND_CHANGED if has_ended else 0
        self._status = None

    def command(self, idn: int, start: Callable[[Command], None], cancel: Callable[[], None] | None = None) -> Command:
        """Make the datum `idn` a procedure command of the application."""
        command = Command(self.table[idn], start, self._on_command_end, cancel)
        self._commands.append(command)
        return command
