"""The text of the program in a card: its source, or the object that the card returns."""

from bisect import bisect_left
from collections.abc import Iterator
from pathlib import Path

from fieldrig.text.source_text import decoded
from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.compiler import Compiled, compile_text
from fieldrig_devices.arp.language.printer import argument_text, routine_lines
from fieldrig_devices.arp.user_port import quantities
from fieldrig_devices.arp.user_port.messages import Quantity


class Listing:
    def __init__(self, compiled: Compiled, lines: dict[int, str], title: str) -> None:
        """`lines` are the texts by line number."""
        self._compiled, self.lines, self.title = compiled, lines, title
        lowered = compiled.lowered.routines.values()
        self._executable = sorted({instruction.line for instructions in lowered for instruction in instructions})

    def routine_at(self, line: int) -> str:
        for routine in self._compiled.program.routines:
            if routine.number <= line <= routine.end_number:
                return routine.name
        return ""

    def line_of(self, text: str) -> int:
        """The first line with an instruction at or after a line number or the name of a routine.

        Raises ValueError, which says what was expected, if there is none.
        """
        if text.isdecimal() and len(text) < 9:
            index = bisect_left(self._executable, int(text))
            if index == len(self._executable):
                raise ValueError(
                    f"there is no instruction at or after line {text}\nexpected a line up to {self._executable[-1]}"
                )
            return self._executable[index]
        instructions = self._compiled.lowered.routines.get(text.upper())
        if instructions is None:
            known = ", ".join(self._compiled.lowered.routines)
            raise ValueError(f"{text!r} is not a line or a routine\nexpected the number of a line, or one of {known}")
        return instructions[0].line

    @property
    def first(self) -> int:
        """Line of the first instruction."""
        return self.line_of(self._compiled.main)

    def quantity(self, name: str) -> Quantity:
        """Find a quantity by its own name or by a name that the source defines by EQU.

        Raises ValueError for an unknown name.
        """
        meaning = self._compiled.symbols.equs.get(name.strip().upper())
        return quantities.named(name if meaning is None else argument_text(meaning))

    def around(self, line: int, reach: int) -> Iterator[tuple[int, str]]:
        for number in sorted(self.lines):
            if abs(number - line) <= reach:
                yield number, self.lines[number]

    def is_of(self, data: bytes) -> bool:
        """True if the object from a card is this program."""
        there = files.decode(data)
        return files.encode(self._compiled, there.name, there.system) == data


def of_source(path: Path) -> Listing:
    """Listing of a source file.  Raises CompileError if it cannot be compiled."""
    text = decoded(path.read_bytes())
    return Listing(compile_text(text), dict(enumerate(text.splitlines(), 1)), path.name)


def of_object(data: bytes) -> Listing:
    """Listing of an object.  Raises ObjectError for data that are not an object."""
    decoded = files.decode(data)
    lines = {number: text for routine in decoded.compiled.program.routines for number, text in routine_lines(routine)}
    return Listing(decoded.compiled, lines, f"program {decoded.name}, from the card")
