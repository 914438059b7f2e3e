"""The program of a card for the debugging service: lines, values by their names, forced terminals, and a download.

Source: manual 3.3, 5.2, 5.10; digest chapters 10, 11 and 17.  The USER port has its own protocol for the same things,
and both see the same program: breakpoints set at one place replace those of the other.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Final

from fieldrig.device import Value
from fieldrig.loop.background import Background, Failure
from fieldrig_devices.arp import debug_sources
from fieldrig_devices.arp.card_access import CardAccess, CardState, RefusedError
from fieldrig_devices.arp.debug_sources import Prepared, SourceText
from fieldrig_devices.arp.debug_values import CardValues
from fieldrig_devices.arp.language.files import ObjectError
from fieldrig_devices.arp.language.loading import Unusable
from fieldrig_devices.arp.runtime.program import ArpProgram
from fieldrig_devices.arp.runtime.program import ProgramState as Activity
from fieldrig_devices.arp.user_port.debugging import WHY_NOT, line_of
from fieldrig_devices.arp.user_port.wording import CODES
from fieldrig_devices.languages.debugging.debuggee import (
    At,
    Frame,
    Looks,
    ProgramState,
    Reset,
    Step,
    ThreadView,
    Variable,
    evaluated,
)

THREAD: Final = 1
_RUNNING: Final = "the program is running: expected `stop` first"
_STATES: Final = {
    Activity.HELD: ProgramState.HELD,
    Activity.RUNNING: ProgramState.RUNNING,
    Activity.PAUSED: ProgramState.PAUSED,
    Activity.ENDED: ProgramState.ENDED,
    Activity.FAILED: ProgramState.FAILED,
}


class ArpDebuggee:
    """The program of one card.  The card calls `force_inputs`, `force_outputs` and `tick` in each control loop."""

    language = "ARP BASIC"

    def __init__(self, card: CardAccess, background: Background, first: tuple[bytes, SourceText] | None) -> None:
        """`first` is the program that the rig file names, as object and source; that in the card may be another."""
        self._card, self._background = card, background
        self.on_stop: Callable[[], None] = lambda: None
        self.on_load: Callable[[], None] = lambda: None
        self.progress = self.problem = ""
        self._downloads = 0
        self._values = CardValues(card, lambda: self._source.equs)
        self._watched: ArpProgram | None = None
        self._looks: Looks | None = None
        self._known: dict[bytes, SourceText] = {}
        self._shown: tuple[bytes, SourceText] = b"", SourceText("", "")
        self.force_inputs, self.force_outputs = self._values.force_inputs, self._values.force_outputs
        if first is not None:
            data, source = first
            self._known[data] = source
            self._compile(source, lambda _data: None)

    def tick(self) -> None:
        """Look for another program; call it last in each control loop."""
        if self._card.program is not self._watched:
            self._watch()

    def _watch(self) -> None:
        self._watched = self._card.program
        if self._watched is not None:
            self._watched.on_stop = lambda: self.on_stop()
            self.look_on(self._looks)
            self.on_load()

    def _program(self) -> ArpProgram:
        program = self._card.program
        if program is None:
            raise ValueError("the card has no program: expected a download first")
        if program is not self._watched:
            self._watch()
        return program

    # ---- the program

    @property
    def state(self) -> ProgramState:
        """A stopped program begins again at its first instruction, so it is held."""
        program, state = self._card.program, self._card.state
        if program is None:
            return ProgramState.NONE
        if state is CardState.BLOCKED:
            return ProgramState.FAILED
        if state is not CardState.RUN and program.state is Activity.PAUSED:
            return ProgramState.HELD
        return _STATES[program.state]

    @property
    def _source(self) -> SourceText:
        """The text of the program in the card, as far as it is known."""
        data = self._card.program_object
        known = self._known.get(data)
        if known is not None:
            return known
        if self._shown[0] != data:
            self._shown = data, debug_sources.of_object(data)
        return self._shown[1]

    @property
    def files(self) -> Mapping[str, str]:
        source = self._source
        return {source.name: source.text} if self._card.program is not None else {}

    def threads(self) -> Sequence[ThreadView]:
        if self._card.program is None:
            return []
        error = self._card.errors.error
        about = f"error {error}: {CODES.get(error, 'reserved')}" if error else ""
        return [ThreadView(THREAD, self._card.program_name, self.state, about)]

    def stack(self, thread: int) -> Sequence[Frame]:
        program, file = self._program(), self._source.name
        place = program.place
        callers = [Frame(caller.routine, file, caller.line) for caller in reversed(program.calls)]
        return [Frame(place.routine, file, line_of(program)), *callers]

    def break_at(self, places: Mapping[str, set[int]]) -> Mapping[str, set[int]]:
        program, own = self._program(), self._source.name
        stops = program.break_at(places.get(own, set()))
        return {file: stops if file == own else set() for file in places}

    def look_on(self, looks: Looks | None) -> None:
        self._looks, program = looks, self._card.program
        if program is not None:
            program.looks = None if looks is None else (partial(looks[0], THREAD), partial(looks[1], THREAD))

    def at(self, thread: int) -> At | None:
        program = self._program()
        if not program.is_within:
            return None
        line, is_beginning = program.at
        return At(self._source.name, line, len(program.calls), is_beginning)

    def halt(self, thread: int) -> bool:
        return self._program().halt()

    def goes_on(self, file: str, first: int, last: int) -> bool:
        return False  # each line of a program is a statement

    # ---- going on

    def start(self) -> None:
        self._program()
        if not self._card.run_program():
            raise ValueError(WHY_NOT.get(self._card.state, "the program cannot start now"))

    def stop(self) -> None:
        if not self._card.stop_program():
            raise ValueError(f"the card is {self._card.state.name}: expected a program that runs")

    def reset(self, kind: Reset) -> None:
        """Reset as Ctrl-F2 does; variables are permanent, so warm and cold are alike."""
        if kind is Reset.ORIGIN:
            raise ValueError("a card cannot delete its program: expected a download of another one")
        self._card.reset()

    def pause(self) -> None:
        program = self._program()
        if program.state is not Activity.RUNNING:
            raise ValueError("the program is not running")
        program.pause()

    def go_on(self) -> None:
        self._paused().go_on()

    def step(self, thread: int, kind: Step) -> None:
        self._paused().step_to(kind)

    def _paused(self) -> ArpProgram:
        program = self._program()
        if self._card.state is not CardState.RUN or program.state is not Activity.PAUSED:
            raise ValueError(f"the program is {self.state.value}: expected one that is paused")
        return program

    # ---- values

    def variables(self, path: str) -> Sequence[Variable]:
        return self._values.variables(path)

    def evaluate(self, text: str, thread: int | None = None, frame: int = 0) -> Variable:
        return self._values.evaluate(text)

    def reader(self, text: str) -> Callable[[], Value | None]:
        return evaluated(self, text)

    def write(self, path: str, value: Value) -> None:
        self._values.write(path, value)

    def force(self, path: str, value: Value | None) -> None:
        self._values.force(path, value)

    def forced(self) -> Sequence[Variable]:
        return self._values.forced()

    # ---- download

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        if is_online:
            raise ValueError("a card has no online change: expected `stop`, then a download")
        if len(files) != 1:
            raise ValueError(f"a card has one program in one file: expected 1 file, got {len(files)}")
        if self._card.state in (CardState.INIT, CardState.RUN):
            raise ValueError(_RUNNING)
        [(name, text)] = files.items()
        self._downloads += 1
        self._compile(SourceText(name, text), self._load)

    def _compile(self, source: SourceText, on_compiled: Callable[[bytes], None]) -> None:
        """Compile a source beside the card, and remember it by its object.  A later download takes its place."""
        self.progress, number = "compiling 0 %", self._downloads

        def on_done(outcome: Prepared | Unusable | Failure) -> None:
            if isinstance(outcome, Prepared):
                self._remember(outcome.data, SourceText(source.name, source.text, outcome.equs))
            if number != self._downloads:
                return
            self.progress, self.problem = "", ""
            if isinstance(outcome, Prepared):
                on_compiled(outcome.data)
            else:
                self.problem = outcome.why

        def on_progress(what: str, done: int, steps: int) -> None:
            if number == self._downloads:
                self.progress = f"{what} {100 * done // max(steps, 1)} %"

        order, takes_ns = (source, self._card.number), source.duration_ns
        self._background.run(debug_sources.prepare, order, on_done, on_progress, virtual_ns=takes_ns)

    def _remember(self, data: bytes, source: SourceText) -> None:
        """Keep the source of the program in the card and this one."""
        present = self._card.program_object
        self._known = {known: text for known, text in self._known.items() if known == present}
        self._known[data] = source

    def _load(self, data: bytes) -> None:
        """Give the card the object, which it compiles again, as from its USER port."""
        self.progress, number = "loading", self._downloads

        def on_loaded(why_not: RefusedError | ObjectError | None) -> None:
            if number != self._downloads:
                return
            self.progress = ""
            self.problem = "" if why_not is None else str(why_not)

        self._card.load(data, on_loaded)
