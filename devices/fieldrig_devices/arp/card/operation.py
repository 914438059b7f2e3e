"""The operation of the card in its states: power-on, reset, run, stop, blocking errors, and its memory.

Source: manual 2.3, 3.3, 5.2; digest chapter 10.  While the card is held at reset or by a blocking error, axes are off,
every output is 0 (digest ARP-122) and the program does not run.  Every reset and every fresh run reads the parameters
from flash again.  A fresh run starts with flags and limits as at power-on and with nothing armed; a run that follows a
stop continues with the state that the stop left.  A blocked program keeps its place for inspection.
"""

import hashlib
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from fieldrig.loop.background import Background, Coarse, Failure, Job
from fieldrig.real import progress
from fieldrig.storage.store import StoreError
from fieldrig_devices.arp import card_errors as codes
from fieldrig_devices.arp.card.memory import MemoryFaultError
from fieldrig_devices.arp.card.parts import Parts
from fieldrig_devices.arp.card.permanent import Ram
from fieldrig_devices.arp.card.program_side import ProgramSide
from fieldrig_devices.arp.card.settings import ParameterSettings
from fieldrig_devices.arp.card.states import HELD, Event, States
from fieldrig_devices.arp.card_access import CardState, OnLoaded, Progress, RefusedError
from fieldrig_devices.arp.fixed import MEMORY_BLANK
from fieldrig_devices.arp.language.files import ArpObject, ObjectError, decode, encode
from fieldrig_devices.arp.language.loading import NS_PER_OCTET, Loaded, Unusable
from fieldrig_devices.arp.language.loading import load as load_object
from fieldrig_devices.arp.parameters import PARAMETERS, ParameterValues
from fieldrig_devices.arp.runtime.program import ArpProgram, Executable, ProgramState

log = logging.getLogger(__name__)

_RUNNING: Final = "the program is running: stop it or open Enable, then load"
KEYS: Final = slice(225, 257)
"""Flags of the terminal's keys, which the card does not clear."""


class Operation:
    def __init__(
        self,
        parts: Parts,
        first_parameters: ParameterSettings,
        program: bytes | None,
        source: Path | None,
        background: Background,
    ) -> None:
        """`program` is the object file that the rig file names, `source` the file it is made of, if that is a source.

        `background` compiles downloaded programs.
        """
        self._background = background
        self._parts, self._first_parameters, self._first_program = parts, first_parameters, program
        self._source = source
        self._states = States(self._on_change)
        self._side = ProgramSide(parts)
        self._is_enabled: bool | None = None
        self.program: ArpProgram | None = None
        self.program_name = ""
        self.program_object = b""
        self.loading: Progress | None = None

    @property
    def state(self) -> CardState:
        return self._states.state

    # ---- power-on

    def power_on(self) -> None:
        """Power on: state INIT, until the scheduler has checked Enable for the first time."""
        parts = self._parts
        self._load_variables()
        self._load_flash()
        parts.parameters.load()
        self._load_program()
        parts.analog_inputs.start()
        parts.axes.start()

    def _load_variables(self) -> None:
        try:
            state = self._parts.permanent.load()
        except StoreError as cause:
            log.warning("variables are lost at power-off: %s", cause.strerror)
            state = Ram.DAMAGED
        if state is Ram.DAMAGED:
            self._parts.errors.fail(codes.EEPROM)
        elif state is Ram.BLANK:
            self._parts.errors.warn(MEMORY_BLANK)

    def _load_flash(self) -> None:
        """Load the stored content, and apply the rig file to it.  A damaged memory is left as it is."""
        memory, errors = self._parts.memory, self._parts.errors
        try:
            is_new = not memory.read()
            if is_new:
                errors.warn(MEMORY_BLANK)
            if self._put_first_content() or is_new:
                memory.write()
        except MemoryFaultError as cause:
            log.warning("E03: %s", cause)
            self._put_first_content()
            errors.fail(codes.EEPROM)
        self._parts.parameters.flash = memory.content.parameters

    def _put_first_content(self) -> bool:
        """Apply values of the rig file that have changed since they were last applied.  True if any have."""
        content = self._parts.memory.content
        values = self._first_parameters.raw()
        mark = _mark(json.dumps(sorted(values.items())).encode())
        is_changed = bool(values) and mark != content.parameters_mark
        if is_changed:
            for (group, number), raw in values.items():
                content.parameters[group][number] = raw
            content.parameters_mark = mark
        if self._first_program is not None and _mark(self._first_program) != content.program_mark:
            content.program, content.program_mark = self._first_program.decode(), _mark(self._first_program)
            is_changed = True
        return is_changed

    def _load_program(self) -> None:
        text = self._parts.memory.content.program
        if not text:
            return
        try:
            decoded = self._decoded(text.encode())
        except ObjectError as cause:
            log.warning("the program in memory cannot be run: %s", cause)
            return
        # Before the card runs, the time that this takes does not matter.
        self.program, self.program_name = self._program(decoded.compiled, decoded.name, text.encode()), decoded.name
        self.program_object = encode(decoded.compiled, decoded.name, decoded.system)

    def _program(self, compiled: Executable, name: str, data: bytes) -> ArpProgram:
        """Return a program that can run; the source of the one in the rig file is known."""
        is_first = self._source is not None and data == self._first_program
        return ArpProgram(compiled, self._side, str(self._source) if is_first else name)

    # ---- events

    def look_at_enable(self, is_enabled: bool) -> None:
        """Handle a change of Enable; the scheduler calls it in each pass."""
        was_enabled, self._is_enabled = self._is_enabled, is_enabled
        if self.state is CardState.INIT or was_enabled not in (None, is_enabled):
            self._states.handle(Event.CLOSED if is_enabled else Event.OPENED)

    def look_at_program(self) -> None:
        """Handle the end of the program; call it after a slice."""
        if self.program is not None and self.program.state is ProgramState.ENDED:
            self._states.handle(Event.ENDED)

    def on_blocking(self, code: int) -> None:
        if code != codes.RESET:
            self._states.handle(Event.FAILED)

    def run_program(self) -> bool:
        program = self.program
        if self.state is CardState.RUN and program is not None and program.state is ProgramState.PAUSED:
            program.go_on()
            return True
        return self._states.handle(Event.STARTED)

    def stop_program(self) -> bool:
        return self._states.handle(Event.STOPPED)

    def reset(self) -> None:
        if not self._states.handle(Event.RESET) and self.state is not CardState.INIT:
            self._reload_parameters()  # the card is already held at reset

    def _on_change(self, before: CardState, after: CardState) -> None:
        parts = self._parts
        if after is CardState.RUN:
            self._run(before)
            return
        if after is CardState.STOPPED:
            if self.program is not None:
                self.program.pause()
            return
        self._hold()
        if after is CardState.BLOCKED:
            return
        if before is not CardState.INIT:
            self._reload_parameters()
        if self.program is not None:
            self.program.reset()
        parts.terminal.release()
        if after is CardState.RESET_ENABLE:
            parts.errors.fail(codes.RESET)
        else:
            parts.errors.clear()

    def _run(self, before: CardState) -> None:
        parts = self._parts
        if before in HELD and not self._start_afresh(is_power_on=before is CardState.INIT):
            return
        if self.program is None:
            parts.errors.fail(codes.STOPPED_PROGRAM)
            return
        if before in HELD:
            parts.axes.engage()
            if parts.remote_io is not None:
                parts.remote_io.release()
        self.program.start()

    def _start_afresh(self, is_power_on: bool) -> bool:
        """Establish the initial state of the system (manual 3.3).  False if the memory fails."""
        parts = self._parts
        if not is_power_on:
            parts.errors.clear()
            parts.permanent.find_ram()
            if not self._reload_parameters():
                parts.errors.fail(codes.EEPROM)
                return False
            keys = parts.F[KEYS]
            parts.F[:] = [0] * len(parts.F)
            parts.F[KEYS] = keys
        parts.parameters.load()
        parts.axes.start()
        return True

    def _reload_parameters(self) -> bool:
        """Load the parameters from flash again (manual 2.3, 4.2.2).

        Returns False, with the parameters that were read last, if flash cannot be read.
        """
        parts, is_readable = self._parts, True
        try:
            is_new = not parts.memory.read()
        except MemoryFaultError as cause:
            log.warning("E03: %s", cause)
            is_readable = False
        else:
            if self._put_first_content() or is_new:  # the store has not accepted it so far
                with suppress(MemoryFaultError):
                    parts.memory.write()
        parts.parameters.flash = parts.memory.content.parameters
        parts.parameters.load()
        return is_readable

    def _hold(self) -> None:
        """Switch axes off, set outputs to 0, disarm everything, and interrupt a running program."""
        parts = self._parts
        if self.program is not None:
            self.program.pause()
        parts.axes.release()
        parts.cam_switches.reset()
        parts.regulators.reset()
        parts.analog_outputs.release()
        parts.O[:] = [0] * len(parts.O)
        if parts.remote_io is not None:
            parts.remote_io.freeze()

    # ---- memory

    def save_parameter(self, group: int, number: int, raw: int) -> bool:
        parameters = self._parts.parameters
        is_valid = group in range(len(PARAMETERS)) and parameters.takes(group, number, raw)
        return is_valid and self._keep({(group, number): raw}) and parameters.set_ram(group, number, raw)

    def save_parameters(self, values: ParameterValues) -> bool:
        """See `CardAccess.save_parameters`."""
        return not values or self._keep(values)

    @contextmanager
    def saving(self, values: ParameterValues) -> Iterator[None]:
        """See `CardAccess.saving`.  The node's section is in the same memory, which is written as a whole."""
        before = self._put(values)
        try:
            yield
        except Exception:
            self._put(before)
            raise

    def _keep(self, values: ParameterValues) -> bool:
        before = self._put(values)
        if self._write():
            return True
        self._put(before)
        return False

    def _put(self, values: ParameterValues) -> ParameterValues:
        """Put values into the content of the memory, but not yet into the store.  Returns the previous values."""
        tables = self._parts.memory.content.parameters
        before = {(group, number): tables[group][number] for group, number in values}
        for (group, number), raw in values.items():
            tables[group][number] = raw
        return before

    def load(self, data: bytes, on_loaded: OnLoaded) -> Job:
        """See `CardAccess.load`."""
        if self.state in (CardState.INIT, CardState.RUN):
            on_loaded(RefusedError(_RUNNING))
            return _NoJob()

        def on_progress(what: str, done: int, steps: int) -> None:
            self.loading = Progress(what, done, steps)

        def on_done(outcome: Loaded | Unusable | Failure) -> None:
            self.loading = None
            on_loaded(self._loaded(data, outcome))

        self.loading = Progress("starting", 0, 1)
        job = self._background.run(
            load_object, (data, self._parts.number), on_done, on_progress, virtual_ns=len(data) * NS_PER_OCTET
        )
        return _LoadJob(self, job)

    def _loaded(self, data: bytes, outcome: Loaded | Unusable | Failure) -> RefusedError | ObjectError | None:
        """Replace the program, and return None; or return the reason why not."""
        if isinstance(outcome, Failure):
            return RefusedError(f"the card could not compile the program: {outcome.why}")
        if isinstance(outcome, Unusable):
            return ObjectError(outcome.why)
        if self.state in (CardState.INIT, CardState.RUN):  # it was started meanwhile
            return RefusedError(_RUNNING)
        content = self._parts.memory.content
        before, content.program = content.program, data.decode()
        if not self._write():
            content.program = before
            return RefusedError("the memory cannot be written: E03")
        self.program, self.program_name = self._program(outcome, outcome.name, data), outcome.name
        self.program_object = bytes(outcome.text.data)
        return None

    def on_memory_fault(self) -> None:
        self._parts.errors.fail(codes.EEPROM)

    def _write(self) -> bool:
        try:
            self._parts.memory.write()
        except MemoryFaultError as cause:
            log.debug("E03: %s", cause)
            self.on_memory_fault()
            return False
        return True

    def _decoded(self, data: bytes) -> ArpObject:
        loaded = decode(data, Coarse(progress.report))
        if loaded.system != self._parts.number:
            raise ObjectError(f"the object is for card {loaded.system:02}, and this is card {self._parts.number:02}")
        return loaded


class _NoJob:
    """The job of a program that was refused at once."""

    def cancel(self) -> None:
        """Do nothing."""


class _LoadJob:
    def __init__(self, operation: Operation, job: Job) -> None:
        self._operation, self._job = operation, job

    def cancel(self) -> None:
        self._operation.loading = None
        self._job.cancel()


def _mark(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
