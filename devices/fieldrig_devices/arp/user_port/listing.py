"""The program in a card as text: of its source, or, without one, of the object that the card gives back."""

from bisect import bisect_left
from collections.abc import Iterator
from pathlib import Path

from fieldrig_devices.arp.language import files
from fieldrig_devices.arp.language.compiler import Compiled, compile_text
from fieldrig_devices.arp.language.printer import argument_text, routine_lines
from fieldrig_devices.arp.user_port import quantities
from fieldrig_devices.arp.user_port.messages import Quantity


class Listing:
    def __init__(self, compiled: Compiled, lines: dict[int, str], title: str) -> None:
        """`lines` by their numbers."""
        self._compiled, self.lines, self.title = compiled, lines, title
        lowered = compiled.lowered.routines.values()
        self._executable = sorted({one.line for instructions in lowered for one in instructions})

    def routine_at(self, line: int) -> str:
        for routine in self._compiled.program.routines:
            if routine.number <= line <= routine.end_number:
                return routine.name
        return ""

    def line_of(self, text: str) -> int:
        """The line with an instruction that a line number or the name of a routine stands for, itself or the next.

        ValueError, with what would be right, if there is none.
        """
        if text.isdecimal() and len(text) < 9:
            place = bisect_left(self._executable, int(text))
            if place == len(self._executable):
                raise ValueError(
                    f"there is no instruction from line {text} on\nthe last one is in line {self._executable[-1]}"
                )
            return self._executable[place]
        instructions = self._compiled.lowered.routines.get(text.upper())
        if instructions is None:
            known = ", ".join(self._compiled.lowered.routines)
            raise ValueError(f"{text!r} is no line and no routine\nthe number of a line is right, or one of {known}")
        return instructions[0].line

    @property
    def first(self) -> int:
        """The line of the first instruction."""
        return self.line_of(self._compiled.main)

    def quantity(self, name: str) -> Quantity:
        """By its own name, or one that the source gives it by EQU.  ValueError, with what would be right."""
        meaning = self._compiled.symbols.equs.get(name.strip().upper())
        return quantities.named(name if meaning is None else argument_text(meaning))

    def around(self, line: int, reach: int) -> Iterator[tuple[int, str]]:
        for number in sorted(self.lines):
            if abs(number - line) <= reach:
                yield number, self.lines[number]

    def is_of(self, data: bytes) -> bool:
        """Whether the object that a card has is this program."""
        there = files.decode(data)
        return files.encode(self._compiled, there.name, there.system) == data


def of_source(path: Path) -> Listing:
    """CompileError if it can't be compiled."""
    text = path.read_text(encoding="utf-8", errors="replace")
    return Listing(compile_text(text), dict(enumerate(text.splitlines(), 1)), path.name)


def of_object(data: bytes) -> Listing:
    """ObjectError for what is none."""
    found = files.decode(data)
    lines = {number: text for one in found.compiled.program.routines for number, text in routine_lines(one)}
    return Listing(found.compiled, lines, f"program {found.name}, from the card")
