"""Looks at a program in front of each of its instructions and behind it: data breakpoints, and searches of its past.

A look changes nothing, so a rig does the same with it and without.  Instructions of all threads are counted: a
search names what it has found by the number of the instruction, and a goal stops in front of that one when the same
is repeated.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

from fieldrig.clock import Clock
from fieldrig.device import Value
from fieldrig_devices.languages.debugging.debuggee import At, Debuggee
from fieldrig_devices.languages.debugging.texts import text_of

MOST_PROBES: Final = 16
OUTSIDE: Final = "outside of the program"

Read = Callable[[], Value | None]


class Place(NamedTuple):
    """A breakpoint, with its condition; an empty one always holds."""

    file: str
    line: int
    condition: str


class Change(NamedTuple):
    """A variable that has got another value."""

    name: str
    before: str
    after: str
    at: At | None
    """The instruction that did it; None if it was no instruction of the program."""


@dataclass
class Found:
    """The last thing that a search has found."""

    number: int = 0
    """The number of the instruction, from 1; 0 for nothing."""
    at_ns: int = 0
    thread: int = 0
    at: At | None = None
    change: Change | None = None


@dataclass
class Search:
    """The request of a search: breakpoints, changes of variables, or the beginning of the line before."""

    places: Sequence[Place] = ()
    names: Sequence[str] = ()
    thread: int | None = None
    """The thread that is looked at for lines, which may have up to `depth` callers."""
    depth: int = 0
    found: Found = field(default_factory=Found)


class Values:
    """Variables whose changes are looked for."""

    def __init__(self, readers: Mapping[str, Read], text: Callable[[str], str]) -> None:
        """`text` returns the present value of a variable as its language writes it."""
        self._readers, self._text = dict(readers), text
        self._last = {name: read() for name, read in readers.items()}
        self._texts = {name: text(name) for name in readers}

    def changes(self, at: At | None) -> list[Change]:
        """Return what has changed since the last call."""
        found = []
        for name, read in self._readers.items():
            value, before = read(), self._last[name]
            if value is before or value == before:
                continue
            self._last[name], text = value, self._texts[name]
            self._texts[name] = self._text(name)
            if value is not None and before is not None:
                found.append(Change(name, text, self._texts[name], at))
        return found


class Probes:
    """All looks at the program of one device."""

    def __init__(self, clock: Clock, debuggee: Debuggee) -> None:
        self._clock, self._debuggee = clock, debuggee
        self._goals: dict[str, int] = {}
        """The numbers of the instructions in front of which the program stops, by the names of the goals."""
        self._reached: dict[str, int] = {}
        """The threads that have come to a goal, by its name."""
        self._counts: dict[str, int] = {}
        """The instructions since the beginning of each goal and search."""
        self._searches: dict[str, tuple[Search, Values]] = {}
        self._watched: Values | None = None
        self.names: Sequence[str] = ()
        """The names of the variables with a data breakpoint."""
        self._present: dict[int, At | None] = {}
        self._lines: dict[int, tuple[int, int]] = {}
        """The line and the depth of each thread in front of its last instruction."""
        self._due: list[Change] = []
        self.stopped: dict[int, str] = {}
        """Why threads have stopped at a data breakpoint, by their numbers."""
        self._halted: set[int] = set()
        """The threads that were stopped by a look, until `takes_stop`."""

    # ---- requests

    def _values(self, names: Sequence[str]) -> Values:
        for name in names:
            if self._debuggee.evaluate(name).value is None:
                raise ValueError(f"{name} is a group of values\nexpected a single value")
        return Values({name: self._debuggee.reader(name) for name in names}, self._text)

    def _text(self, name: str) -> str:
        try:
            variable = self._debuggee.evaluate(name)
        except ValueError:
            return ""
        return variable.text or text_of(variable.value)

    def watch(self, names: Sequence[str]) -> None:
        """Replace the data breakpoints.  ValueError for a name that has no single value."""
        self._watched = self._values(names) if names else None
        self.names = tuple(names)
        self._due.clear()
        self.stopped.clear()
        self._hook()

    def search(self, name: str, request: Search) -> None:
        """Begin a search.  ValueError for the name of a variable that has no single value."""
        values = self._values(request.names)
        self._make_room()
        self._searches[name] = request, values
        self._counts[name] = 0
        self._hook()

    def aim(self, name: str, number: int) -> None:
        """Stop the program in front of an instruction, counted from now on."""
        self._make_room()
        self._goals[name], self._counts[name] = number, 0
        self._hook()

    def found(self, name: str) -> Found:
        """Return what a search has found so far; nothing for an unknown one."""
        return self._searches[name][0].found if name in self._searches else Found()

    def reached_by(self, name: str) -> int | None:
        """Return the thread that has come to a goal; None for one that is not reached."""
        return self._reached.get(name)

    def takes_stop(self, thread: int) -> bool:
        """Return whether the stop of a thread that is reported now is that of a look."""
        is_own = thread in self._halted
        self._halted.discard(thread)
        return is_own

    @property
    def due(self) -> list[str]:
        """The names of the goals, also of those that are reached."""
        return [name for name in self._counts if name not in self._searches]

    def end(self, names: Sequence[str]) -> None:
        """End goals.  A search goes on: it is in a branch of the past, where this is repeated."""
        for name in names:
            self._goals.pop(name, None)
            self._reached.pop(name, None)
            if name not in self._searches:
                self._counts.pop(name, None)
        self._hook()

    def reload(self) -> None:
        """Look at a program that has just been loaded."""
        for known in (self._present, self._lines, self.stopped):
            known.clear()
        self._halted.clear()
        self._due.clear()
        self._hook()

    def _make_room(self) -> None:
        while len(self._counts) >= MOST_PROBES:
            name = next(iter(self._counts))
            del self._counts[name]
            self._goals.pop(name, None)
            self._reached.pop(name, None)
            self._searches.pop(name, None)

    def _hook(self) -> None:
        is_looking = self._goals or self._searches or self._watched is not None
        self._debuggee.look_on((self._ahead, self._behind) if is_looking else None)

    # ---- looks

    def _ahead(self, thread: int) -> None:
        """Look at a thread in front of its next instruction, and halt it for a goal or a data breakpoint."""
        self.stopped.pop(thread, None)
        self._halted.discard(thread)
        if self._is_due(thread):
            self._halt(thread)
            return
        at = self._present[thread] = self._debuggee.at(thread)
        for name, (search, values) in self._searches.items():
            number = self._counts[name] + 1
            for change in values.changes(None):
                search.found = Found(number, self._clock.now_ns(), thread, at, change)
            if at is not None and self._is_wanted(search, thread, at):
                search.found = Found(number, self._clock.now_ns(), thread, at)
        if at is not None:
            self._lines[thread] = at.line, at.depth

    def _halt(self, thread: int) -> bool:
        """Stop a thread; false if it has no instruction to stop in front of."""
        self._halted.add(thread)  # before it reports the stop
        if self._due:
            self.stopped[thread] = "; ".join(map(told, self._due))
        if self._debuggee.halt(thread):
            self._due.clear()
            return True
        self._halted.discard(thread)
        self.stopped.pop(thread, None)
        return False

    def _is_due(self, thread: int) -> bool:
        """Return whether the program has to stop here: at a goal, or because of a change that comes from outside."""
        if self._watched is not None:
            self._due += self._watched.changes(None)
        reached = [name for name, number in self._goals.items() if self._counts[name] + 1 == number]
        for name in reached:
            del self._goals[name]
            self._reached[name] = thread
        return bool(reached or self._due)

    def _behind(self, thread: int) -> None:
        """Look at a thread behind an instruction."""
        at = self._present.pop(thread, None)
        for name, (search, values) in self._searches.items():
            for change in values.changes(at):
                search.found = Found(self._counts[name] + 1, self._clock.now_ns(), thread, at, change)
        for name in self._counts:
            self._counts[name] += 1
        if self._debuggee.at(thread) is None:
            self._lines.pop(thread, None)
        if self._watched is not None and (changes := self._watched.changes(at)):
            self._due += changes
            self._halt(thread)

    def _is_wanted(self, search: Search, thread: int, at: At) -> bool:
        if search.thread is not None:
            return thread == search.thread and at.depth <= search.depth and self._is_another_line(thread, at)
        if not at.is_beginning:
            return False
        here = [place for place in search.places if (place.file, place.line) == (at.file, at.line)]
        return any(not place.condition or self._holds(place.condition, thread) for place in here)

    def _is_another_line(self, thread: int, at: At) -> bool:
        """Return whether a thread comes to a line, and not back into one from a call or from the lines of a body."""
        return at.is_beginning and self._lines.get(thread) != (at.line, at.depth)

    def _holds(self, condition: str, thread: int) -> bool:
        """A condition that cannot be evaluated stops the program, as it does at a breakpoint."""
        try:
            return self._debuggee.evaluate(condition, thread).value is not False
        except ValueError:
            return True


def told(change: Change) -> str:
    """Return a change in words, such as `count 4 -> 5 by count.st:7`."""
    where = f"{change.at.file}:{change.at.line}" if change.at is not None else OUTSIDE
    return f"{change.name} {change.before} -> {change.after} {'by' if change.at is not None else 'from'} {where}"


def shown(found: Found) -> dict[str, Any]:
    """Return what was found as an answer."""
    answer: dict[str, Any] = {"number": found.number, "at_ns": found.at_ns, "thread": found.thread}
    if found.at is not None:
        answer |= {"file": found.at.file, "line": found.at.line}
    if found.change is not None:
        change, at = found.change, found.change.at
        answer["change"] = {
            "name": change.name,
            "before": change.before,
            "after": change.after,
            "file": None if at is None else at.file,
            "line": None if at is None else at.line,
        }
    return answer
