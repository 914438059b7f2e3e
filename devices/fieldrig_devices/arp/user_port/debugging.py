"""Requests about the program: run, stop, reset, breakpoints, pause, step, and its place."""

from collections.abc import Callable, Iterable
from typing import Final

from fieldrig_devices.arp.card_access import CardAccess, CardState
from fieldrig_devices.arp.runtime.program import ArpProgram, ProgramState
from fieldrig_devices.arp.user_port.handlers import Handlers, bare
from fieldrig_devices.arp.user_port.messages import (
    LINE,
    MOST_BREAKPOINTS,
    Command,
    Condition,
    ProgramCode,
    RequestError,
    Status,
)

CODES: Final = {
    ProgramState.HELD: ProgramCode.HELD,
    ProgramState.RUNNING: ProgramCode.RUNNING,
    ProgramState.PAUSED: ProgramCode.PAUSED,
    ProgramState.ENDED: ProgramCode.ENDED,
    ProgramState.FAILED: ProgramCode.FAILED,
}
WHY_NOT: Final = {
    CardState.INIT: "the card is starting",
    CardState.RESET_ENABLE: "Enable (I108) is open: close it to run the program",
    CardState.RUN: "the program is already running",
    CardState.BLOCKED: "the card is blocked by an error: open and close Enable, or reset",
}


def line_of(program: ArpProgram) -> int:
    """Source line of the next instruction."""
    if program.state is ProgramState.HELD:
        return program.code.line(program.code.numbers[program.compiled.main], 0)
    return program.place.line


def condition(card: CardAccess) -> Condition:
    program, errors = card.program, card.errors
    code = ProgramCode.NONE if program is None else CODES[program.state]
    line = 0 if program is None else line_of(program)
    count = 0 if program is None else min(len(program.breakpoints), 255)
    return Condition(card.state, code, errors.error, errors.error_axis, errors.warning, line, count)


def news(card: CardAccess) -> object:
    """State of which every change causes an event.  The line is not part of it: only RUN and STEP change the line."""
    program, errors = card.program, card.errors
    state = None if program is None else program.state
    return card.state, program, state, errors.error, errors.error_axis, errors.warning


class DebugRequests:
    def __init__(self, card: CardAccess, on_go: Callable[[], None]) -> None:
        """`on_go` is called when a request has started the program."""
        self._card, self._on_go = card, on_go
        self.handlers: Handlers = {
            Command.STATE: bare(self._state),
            Command.RUN: bare(self._run),
            Command.STOP: bare(self._stop),
            Command.RESET: bare(self._reset),
            Command.BREAKPOINTS_SET: self._set_breakpoints,
            Command.BREAKPOINTS_GET: bare(self._breakpoints),
            Command.PAUSE: bare(self._pause),
            Command.STEP: bare(self._step),
            Command.PLACE: bare(self._place),
        }

    def _state(self) -> bytes:
        return condition(self._card).encode()

    def _run(self) -> bytes:
        self._program()
        if not self._card.run_program():
            raise RequestError(Status.REFUSED, WHY_NOT.get(self._card.state, ""))
        self._on_go()
        return b""

    def _stop(self) -> bytes:
        if not self._card.stop_program():
            raise RequestError(Status.REFUSED, "no program is running")
        return b""

    def _reset(self) -> bytes:
        self._card.reset()
        return b""

    def _set_breakpoints(self, data: bytes) -> bytes:
        lines = {line for (line,) in LINE.iter_unpack(data)}
        if len(lines) > MOST_BREAKPOINTS:
            raise RequestError(Status.LENGTH, f"at most {MOST_BREAKPOINTS} breakpoints")
        return _packed(sorted(self._program().break_at(lines)))

    def _breakpoints(self) -> bytes:
        return _packed(sorted(self._program().breakpoints))

    def _pause(self) -> bytes:
        program = self._program()
        if program.state is not ProgramState.RUNNING:
            raise RequestError(Status.REFUSED, "the program is not running")
        program.pause()
        return b""

    def _step(self) -> bytes:
        program = self._program()
        if self._card.state is not CardState.RUN or program.state is not ProgramState.PAUSED:
            raise RequestError(Status.REFUSED, "the program is not paused")
        program.step()
        self._on_go()
        return b""

    def _place(self) -> bytes:
        """Answer PLACE: the next line, then those of the callers, innermost first."""
        program = self._program()
        return _packed([line_of(program), *(place.line for place in reversed(program.calls))])

    def _program(self) -> ArpProgram:
        program = self._card.program
        if program is None:
            raise RequestError(Status.NO_PROGRAM, "the card has no program; download one")
        return program


def _packed(lines: Iterable[int]) -> bytes:
    return b"".join(map(LINE.pack, lines))
