"""A debugger for the program in a card, with one command per line, for users and scripts.

It does not depend on a terminal: `do` executes a line and calls `say` with the output.  A KeyboardInterrupt during a
wait for the program pauses the program.
"""

from collections.abc import Callable
from typing import Final

from fieldrig.points.values import counted
from fieldrig_devices.arp.card_access import CardState
from fieldrig_devices.arp.user_port import quantities, wording
from fieldrig_devices.arp.user_port.client import ArpPort
from fieldrig_devices.arp.user_port.debugger_words import WORDS
from fieldrig_devices.arp.user_port.listing import Listing
from fieldrig_devices.arp.user_port.messages import Condition, ProgramCode
from fieldrig_devices.languages.debugging.prompt import NotStoppedError
from fieldrig_devices.languages.debugging.words import count, limit, none

EVENT_S: Final = 0.5
"""Time to wait for an event before the state is requested, in case the event was lost, in seconds."""
MOST_STEPS: Final = 25
"""Number of instructions after which a step gives up: one source line, or a WAIT that is not over."""
REACH: Final = 5
"""Number of lines shown above and below."""


class Debugger:
    def __init__(self, card: ArpPort, listing: Listing, say: Callable[[str], None], limit_s: float | None) -> None:
        """`limit_s` is the time to wait for a program that runs, in seconds; None means without limit."""
        self._card, self._listing, self._say, self._limit_s = card, listing, say, limit_s
        self._stops = set(card.breakpoints())
        self.is_over = False
        self._acts: dict[str, Callable[[list[str]], None]] = {
            "run": self._run,
            "continue": self._continue,
            "step": self._step,
            "next": self._next,
            "pause": self._pause,
            "break": self._break,
            "delete": self._delete,
            "list": self._list,
            "where": self._where,
            "print": self._print,
            "set": self._set,
            "state": self._state,
            "stop": self._stop,
            "reset": self._reset,
            "help": self._help,
            "quit": self._quit,
            "leave": self._leave,
        }

    def do(self, line: str) -> None:
        """Execute one command.

        Raises ValueError, which says what was expected, NotStoppedError, or an error of the client.
        """
        word, *arguments = line.split()
        self._acts[WORDS.find(word)](arguments)

    def show_place(self) -> None:
        condition = self._card.condition()
        if condition.program == ProgramCode.NONE:
            self._say(wording.PROGRAMS[ProgramCode.NONE])
            return
        name = wording.program_name(condition.program)
        self._say(f"{name} at {self._shown(condition.line)}")
        if condition.state == CardState.BLOCKED or condition.error:
            self._say(f"error {condition.error}: {wording.CODES.get(condition.error, 'reserved')}")

    # ---- going on

    def _run(self, arguments: list[str]) -> None:
        limit_s = limit(arguments, self._limit_s)
        self._card.ensure_stopped()
        self._card.run()
        self._wait(limit_s)

    def _continue(self, arguments: list[str]) -> None:
        limit_s = limit(arguments, self._limit_s)
        if self._card.condition().program != ProgramCode.PAUSED:
            raise ValueError("the program is not paused\n`run` starts it, `pause` pauses it")
        self._card.run()
        self._wait(limit_s)

    def _wait(self, limit_s: float | None) -> None:
        """Wait until the program stops; Ctrl-C pauses it."""
        try:
            if limit_s is None:
                self._say("the program runs; Ctrl-C pauses it")
            condition = self._until_it_stops(limit_s)
        except KeyboardInterrupt:
            self._card.pause()
            condition = self._card.condition()
        if condition.program == ProgramCode.RUNNING:
            raise NotStoppedError(f"the program still runs after {limit_s:g} s\n`pause` pauses it")
        self.show_place()

    def _until_it_stops(self, limit_s: float | None) -> Condition:
        self._card.events(True)  # request events again: after 10 s of silence the card ends them
        waits = 0
        while True:
            event = self._card.event(EVENT_S)
            condition = self._card.condition()
            if condition.program != ProgramCode.RUNNING:
                return condition
            waits += event is None
            if limit_s is not None and waits * EVENT_S >= limit_s:
                return condition

    def _step(self, arguments: list[str]) -> None:
        for _ in range(count(arguments)):
            self._step_once()
        self.show_place()

    def _next(self, arguments: list[str]) -> None:
        for _ in range(count(arguments)):
            depth = len(self._card.place())
            self._step_once()
            places = self._card.place()
            if len(places) > depth:
                self._leave_subprogram(places[1], depth)
        self.show_place()

    def _step_once(self) -> None:
        """Step to another line or another depth of calls."""
        before = self._card.place()
        for _ in range(MOST_STEPS):
            self._card.step()
            if self._card.place() != before:
                return
        self._say("the program waits on this line: its WAIT is not over, or an axis is busy")

    def _leave_subprogram(self, back: int, depth: int) -> None:
        """Run to the line after the call."""
        self._card.break_at(self._stops | {back})
        try:
            while True:
                self._card.run()
                if self._until_it_stops(self._limit_s).program != ProgramCode.PAUSED:
                    return
                place = self._card.place()
                if len(place) <= depth or place[0] in self._stops:
                    return
        finally:
            self._card.break_at(self._stops)

    def _pause(self, arguments: list[str]) -> None:
        none(arguments)
        self._card.pause()
        self.show_place()

    def _stop(self, arguments: list[str]) -> None:
        none(arguments)
        self._card.stop()
        self._state([])

    def _reset(self, arguments: list[str]) -> None:
        none(arguments)
        self._card.reset()
        self._state([])

    # ---- looking

    def _list(self, arguments: list[str]) -> None:
        here = self._card.condition().line
        line = self._listing.line_of(arguments[0]) if arguments else here
        for number, text in self._listing.around(line, REACH):
            mark = "*" if number in self._stops else " "
            self._say(f"{'>' if number == here else ' '}{mark}{number:5}  {text}")

    def _where(self, arguments: list[str]) -> None:
        none(arguments)
        place, *callers = self._card.place()
        self._say(self._shown(place))
        for line in callers:
            self._say(f"returns to {self._shown(line)}")

    def _print(self, arguments: list[str]) -> None:
        if not arguments:
            raise ValueError(f"nothing to print\nexpected {quantities.FORMS}")
        wanted = [self._listing.quantity(name) for name in arguments]
        for name, quantity, raw in zip(arguments, wanted, self._card.values(wanted), strict=True):
            own = quantities.name_of(quantity)
            shown = own if name.upper().lstrip("@#") == own.lstrip("@#") else f"{name.upper()} ({own})"
            self._say(f"{shown} = {quantities.text_of(quantity, raw)}")

    def _set(self, arguments: list[str]) -> None:
        if not arguments:
            raise ValueError("nothing to set\nexpected NAME=VALUE, such as V1=2.5")
        for argument in arguments:
            name, sign, value = argument.partition("=")
            if not sign:
                raise ValueError(f"{argument!r} has no value\nexpected {argument}=VALUE, without blanks")
            quantity = self._listing.quantity(name)
            self._card.set(quantity, quantities.raw_of(quantity, value))
        self._print([argument.partition("=")[0] for argument in arguments])

    def _state(self, arguments: list[str]) -> None:
        none(arguments)
        condition = self._card.condition()
        name = quantities.state_name(condition.state)
        self._say(f"{name}: {wording.STATES.get(name, '')}; program {wording.program_name(condition.program)}")
        for what, code in (("error", condition.error), ("warning", condition.warning)):
            if code:
                self._say(f"{what} {code}: {wording.CODES.get(code, 'reserved')}")

    def _shown(self, line: int) -> str:
        routine = self._listing.routine_at(line)
        text = self._listing.lines.get(line, "").strip()
        return f"{routine + ', ' if routine else ''}line {line}: {text}"

    # ---- where it stops

    def _break(self, arguments: list[str]) -> None:
        if arguments:
            self._stop_at(self._stops | {self._listing.line_of(argument) for argument in arguments})
        if not self._stops:
            self._say("no breakpoints")
        for line in sorted(self._stops):
            self._say(f"breakpoint at {self._shown(line)}")

    def _delete(self, arguments: list[str]) -> None:
        gone = {self._listing.line_of(argument) for argument in arguments} if arguments else self._stops
        if arguments and not gone <= self._stops:
            raise ValueError("there is no such breakpoint\n`break` lists them")
        self._stop_at(self._stops - gone)
        self._say(f"{counted(len(self._stops), 'breakpoint')} left")

    def _stop_at(self, lines: set[int]) -> None:
        self._stops = set(self._card.break_at(lines))

    # ---- leaving

    def _help(self, arguments: list[str]) -> None:
        none(arguments)
        for line in WORDS.lines():
            self._say(line)

    def _quit(self, arguments: list[str]) -> None:
        none(arguments)
        self.is_over = True
        if self._card.condition().program == ProgramCode.NONE:
            return
        self._stop_at(set())
        condition = self._card.condition()
        if condition.state == CardState.RUN and condition.program == ProgramCode.PAUSED:
            self._card.run()
            self._say("the program continues")

    def _leave(self, arguments: list[str]) -> None:
        none(arguments)
        self.is_over = True
