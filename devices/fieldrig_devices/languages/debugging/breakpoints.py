"""The breakpoints of a program, which stay where they are when another program is loaded.

A breakpoint goes with the text of its line: after a load it is at the nearest line of the same text in the same file,
and it is removed where there is none.
"""

from bisect import bisect_left
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from fieldrig_devices.languages.debugging.debuggee import Debuggee
from fieldrig_devices.languages.debugging.stops import Stop

Place = tuple[str, int]
"""A file and a line."""


@dataclass(slots=True)
class Breakpoints:
    """The breakpoints of a program, which stay where they are in its text when it is loaded again."""

    stops: dict[Place, Stop] = field(default_factory=dict)
    moves: dict[Place, int | None] = field(default_factory=dict)
    """The effect of the last load on each breakpoint that was there: its new line, or None if its text is gone."""
    _texts: dict[Place, str] = field(default_factory=dict)

    def replace(self, debuggee: Debuggee, file: str, wanted: Mapping[int, Stop]) -> set[int]:
        """Replace the breakpoints of one file; return the lines that have an instruction to stop at.

        One that is the same as before goes on counting.
        """
        others = {place: stop for place, stop in self.stops.items() if place[0] != file}
        own = {(file, line): stop for line, stop in wanted.items()}
        known = {place: self.stops[place] for place, stop in own.items() if self.stops.get(place) == stop}
        self._set(debuggee, others | own | known)
        return self.lines(file)

    def next_lines(self, debuggee: Debuggee, file: str, wanted: Collection[int]) -> dict[int, int | None]:
        """Return for each of these lines the one where its breakpoint is; None for one behind the last instruction.

        That is the line itself if it has an instruction, the line where a statement begins that goes over several
        lines, or else the next line with an instruction.
        """
        count = len(debuggee.files.get(file, "").splitlines())
        every = self._by_file(self.stops) | {file: set(range(1, count + 1))}
        stops = sorted(debuggee.break_at(every).get(file, ()))
        return {line: _place(debuggee, file, stops, line) for line in wanted}

    def where(self, debuggee: Debuggee, file: str, lines: Sequence[int]) -> list[int | None]:
        """Return the same for each of these lines in turn, and keep the breakpoints that there are."""
        places = self.next_lines(debuggee, file, lines)
        self._set(debuggee, self.stops)
        return [places[line] for line in lines]

    def lines(self, file: str) -> set[int]:
        return {line for name, line in self.stops if name == file}

    def reload(self, debuggee: Debuggee) -> None:
        """Set the breakpoints in a program that has just been loaded."""
        if not self.stops:
            self.moves = {}
            return
        texts = {name: text.splitlines() for name, text in debuggee.files.items()}
        before, moved = self.stops, dict[Place, Place]()
        for place in before:
            line = nearest(texts.get(place[0], []), self._texts.get(place, ""), place[1])
            if line:
                moved[place] = place[0], line
        self._set(debuggee, {after: before[place] for place, after in moved.items()})
        self.moves = {
            place: moved[place][1] if place in moved and moved[place] in self.stops else None for place in before
        }

    def _set(self, debuggee: Debuggee, wanted: Mapping[Place, Stop]) -> None:
        lines = debuggee.break_at(self._by_file(wanted))
        self.stops = {place: stop for place, stop in wanted.items() if place[1] in lines.get(place[0], ())}
        texts = {file: debuggee.files.get(file, "").splitlines() for file, _ in self.stops}
        self._texts = {(file, line): _line(texts[file], line) for file, line in self.stops}

    @staticmethod
    def _by_file(places: Iterable[Place]) -> dict[str, set[int]]:
        lines: dict[str, set[int]] = {}
        for file, line in places:
            lines.setdefault(file, set()).add(line)
        return lines


def _place(debuggee: Debuggee, file: str, stops: Sequence[int], line: int) -> int | None:
    after = bisect_left(stops, line)
    if after < len(stops) and stops[after] == line:
        return line
    if after > 0 and debuggee.goes_on(file, stops[after - 1], line):
        return stops[after - 1]
    return stops[after] if after < len(stops) else None


def nearest(lines: list[str], text: str, line: int) -> int:
    """Return the line, from 1, with this text that is nearest to a line; 0 if there is none."""
    wanted = text.strip()
    alike = [number for number, other in enumerate(lines, 1) if other.strip() == wanted]
    return min(alike, key=lambda number: abs(number - line), default=0)


def _line(lines: list[str], line: int) -> str:
    return lines[line - 1] if 0 < line <= len(lines) else ""
