"""Whether a program that could be read also makes sense: ranges, kinds of values, targets of jumps and calls.

Source: digest chapter 3 (compile-time checks), chapters 5 to 8, and 18 for its readings.  Works on a resolved tree
(`names`), so what it says of a name is about what the name means.
"""

import dataclasses
from collections.abc import Iterator

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.language import instructions
from fieldrig_devices.arp.language.bits import can_be_bit, is_constant
from fieldrig_devices.arp.language.instructions import CONSTANT, OR_VARIABLE, READS, SIGNATURES, Value
from fieldrig_devices.arp.language.mistakes import Mistake
from fieldrig_devices.arp.language.names import Symbols
from fieldrig_devices.arp.language.tree import (
    Argument,
    Assign,
    BitCondition,
    Call,
    Command,
    Direct,
    Equ,
    Goto,
    If,
    Indexed,
    Node,
    Number,
    OnEvent,
    PositionCondition,
    Program,
    Read,
    Routine,
    System,
    Text,
    Unary,
)

LONGEST_TEXT = 16  # manual 5.12
DEEPEST_CALL = 10  # manual 5.5


def check(program: Program, symbols: Symbols) -> list[Mistake]:
    checker = _Checker(symbols)
    for routine in program.routines:
        checker.routine(routine)
    checker.calls(program)
    return checker.mistakes


def check_equs(program: Program) -> list[Mistake]:
    """Of the program as it was read: what a name stands for has to be there, also if nothing uses the name."""
    checker = _Checker(Symbols())
    for line in (*program.outside, *(line for routine in program.routines for line in routine.lines)):
        if isinstance(line.content, Equ):
            checker.equ(line.number, line.content)
    return checker.mistakes


def _walk(node: Node) -> Iterator[Node]:
    yield node
    for part in dataclasses.fields(node):
        value = getattr(node, part.name)
        for one in value if isinstance(value, tuple) else (value,):
            if isinstance(one, Node):
                yield from _walk(one)


class _Checker:
    def __init__(self, symbols: Symbols) -> None:
        self._symbols = symbols
        self.mistakes: list[Mistake] = []
        self._line = 0
        self._routine = ""

    def _say(self, node: Node, what: str, expected: str = "", is_note: bool = False) -> None:
        self.mistakes.append(Mistake(self._line, node.column, what, expected, is_note))

    def routine(self, routine: Routine) -> None:
        self._routine = routine.name
        for line in routine.lines:
            self._line = line.number
            if line.content is not None and not isinstance(line.content, Equ):
                for node in _walk(line.content):
                    self._node(node)

    def equ(self, line: int, equ: Equ) -> None:
        self._line = line
        for node in _walk(equ.meaning):
            self._node(node)

    def _node(self, node: Node) -> None:
        match node:
            case Direct(letter, number):
                if number not in instructions.numbers(letter):
                    self._say(node, f"there is no {letter}{number}", _range_text(letter))
            case System():
                self._system(node)
            case Assign():
                self._assign(node)
            case Read(word, Node() as number):
                first, last = READS[word] or (0, 0)
                self._constant(number, first, last, f"{word} with {first} to {last}")
            case If():
                if is_constant(node.left) and is_constant(node.right):
                    self._say(node.left, "two constants are compared", "a variable or a bit on one side")
            case Goto():
                self._goto(node)
            case Call():
                self._call(node)
            case OnEvent():
                self._on_event(node)
            case Command():
                for place, argument in enumerate(node.arguments):
                    self._argument(argument, SIGNATURES[node.word].values[place])

    def _system(self, node: System) -> None:
        if node.word == "@PAR":
            last = instructions.GENERAL_PARAMETERS if node.number is None else instructions.AXIS_PARAMETERS
            if node.number not in (None, 1, 2):
                self._say(node, f"there is no axis {node.number}", "@PAR1 or @PAR2")
            if node.index is None or not 1 <= node.index <= last:
                self._say(node, f"there is no parameter {node.index}", f"1 to {last}")
            return
        first, last = instructions.SYSTEM[node.word]
        if node.number is None or not first <= node.number <= last:
            self._say(node, f"there is no {node.word}{node.number}", f"{first} to {last}")

    # ---- assignments

    def _assign(self, node: Assign) -> None:
        target = node.target
        if isinstance(target, Direct | Indexed) and target.letter in ("F", "O"):
            self._writable(target)
            self._assign_bit(node)
        elif isinstance(target, Direct | Indexed) and target.letter == "I":
            self._say(target, "an input can't be written", "a variable, a flag or an output")
        elif isinstance(target, System) and target.word.startswith("#"):
            self._say(target, f"{target.word}{target.number} can only be read", "a variable, or one that begins with @")
        elif isinstance(target, System) and target.word == "@PAR" and target.number is None:
            self._say(target, "a program can't change general parameters (manual 2.2)", "@PAR1[...] or @PAR2[...]")
        elif not isinstance(target, Direct | Indexed | System):
            self._say(target, "a number can't be assigned to", "a name for a variable, a flag or an output")

    def _assign_bit(self, node: Assign) -> None:
        if node.sign not in ("==", "&=", "|=", "^="):
            self._say(node, f"{node.sign} is for variables, and this is one bit", "==, &=, |= or ^=")
        if isinstance(node.value, Read):
            self._say(node.value, f"{node.value.word} is a number, and this is one bit", "a variable V before ==")
        elif not can_be_bit(node.value):
            self._say(node.value, "a number can't be assigned to one bit", "flags, inputs, outputs, HI or LO")

    def _writable(self, target: Direct | Indexed) -> None:
        if not isinstance(target, Direct) or target.letter != "F" or target.number > 320:
            return
        if target.number in instructions.numbers("F") and target.number not in instructions.WRITABLE:
            self._say(target, f"only the system writes F{target.number}", "a flag that is R/W (manual 4.6)")

    # ---- jumps and calls

    def _goto(self, node: Goto) -> None:
        home = self._symbols.labels.get(node.label)
        if home == self._routine:
            return
        if home is not None:
            self._say(node, f"the label {node.label} stands in {home}", "a label of the same routine (manual 5.5)")
        elif node.label in self._symbols.routines:
            self._say(node, f"{node.label} is a routine", f"CALL {node.label}, or a label")
        else:
            self._say(node, f"there is no label {node.label}", f"a line {node.label}: in {self._routine}")

    def _call(self, node: Call) -> None:
        routine = self._symbols.routines.get(node.routine)
        if routine is None:
            self._say(node, f"there is no subprogram {node.routine}", f"BEG {node.routine} ... END")
        elif routine.is_interrupt:
            self._say(node, f"{node.routine} is an interrupt routine, which only ONn runs", "a subprogram with BEG")
        elif routine is next(iter(self._symbols.routines.values())):
            self._say(node, f"{node.routine} is the main program", "a subprogram")

    def calls(self, program: Program) -> None:
        """Manual 5.5: subprograms call each other up to 10 levels."""
        edges = {routine.name: list(_calls(routine)) for routine in program.routines}
        for routine in program.routines:
            levels = _levels(routine.name, edges)
            is_first = routine is program.routines[0] or routine.is_interrupt
            if routine.name in levels and routine is not program.routines[0]:
                what = f"{routine.name} calls itself; the eleventh level stops the program with E12"
                self.mistakes.append(Mistake(routine.number, 1, what, is_note=True))
            elif is_first and max(levels.values(), default=0) > DEEPEST_CALL:
                what = f"calls are nested {max(levels.values())} deep from {routine.name}"
                self.mistakes.append(Mistake(routine.number, 1, what, f"at most {DEEPEST_CALL}"))

    # ---- events and values of instructions

    def _on_event(self, node: OnEvent) -> None:
        self._resource(node.enable, "F", "a flag that enables the event")
        routine = self._symbols.routines.get(node.routine)
        if routine is None:
            self._say(node, f"there is no interrupt routine {node.routine}", f"BEGA {node.routine} ... ENDA")
        elif not routine.is_interrupt:
            self._say(node, f"{node.routine} is no interrupt routine", "one that begins with BEGA")
        match node.condition:
            case BitCondition(bit=bit):
                self._resource(bit, "FI", "a flag or an input")
            case PositionCondition(axis=axis, variable=variable):
                self._constant(axis, 1, 2, Value.AXIS.value)
                self._resource(variable, "V", "a variable V")

    def _resource(self, node: Node, letters: str, expected: str) -> None:
        if not isinstance(node, Direct | Indexed) or node.letter not in letters:
            self._say(node, "this can't stand here", expected)

    def _constant(self, node: Node, first: int, last: int, expected: str) -> None:
        if not isinstance(node, Number):
            self._say(node, "only a constant may stand here", expected)
        elif node.raw % fixed.SCALE or not first <= node.raw // fixed.SCALE <= last:
            self._say(node, f"{fixed.to_text(node.raw)} can't stand here", expected)

    def _argument(self, node: Argument, value: Value) -> None:
        if value in OR_VARIABLE and isinstance(node, Direct | Indexed):
            self._resource(node, "V", value.value)
        elif value in (Value.LINE, Value.COLUMN) and isinstance(node, Number) and node.raw % fixed.SCALE == 0:
            first, last = CONSTANT[value]
            if not first <= node.raw // fixed.SCALE <= last:  # digest I-27: W03, and the text is cut
                what = f"{fixed.to_text(node.raw)} is off the screen of 8 lines and 16 columns: W03 when it runs"
                self._say(node, what, is_note=True)
        elif value in CONSTANT:
            self._constant(node, *CONSTANT[value], value.value)
        elif value is Value.VARIABLE:
            self._resource(node, "V", value.value)
        elif value in (Value.FLAG, Value.BIT):
            self._resource(node, "F" if value is Value.FLAG else "FO", value.value)
            if isinstance(node, Direct | Indexed):
                self._writable(node)
        elif value is Value.CAM_BIT:
            inner = node.operand if isinstance(node, Unary) and node.sign == "!" else node
            self._argument(inner, Value.BIT)
        elif isinstance(node, Text) and len(node.text) > LONGEST_TEXT:
            what = f"the message has {len(node.text)} characters; the terminal keeps {LONGEST_TEXT}"
            self._say(node, what, is_note=True)


def _range_text(letter: str) -> str:
    return " or ".join(f"{letter}{first} to {letter}{last}" for first, last in instructions.RANGES[letter])


def _calls(routine: Routine) -> Iterator[str]:
    for line in routine.lines:
        if line.content is not None:
            yield from (node.routine for node in _walk(line.content) if isinstance(node, Call))


def _levels(start: str, edges: dict[str, list[str]]) -> dict[str, int]:
    """The routines that `start` may come to, each with the levels of the longest way there without a circle."""
    deepest: dict[str, int] = {}
    ways: list[tuple[str, tuple[str, ...]]] = [(start, ())]
    while ways:
        name, path = ways.pop()
        for called in edges.get(name, ()):
            if called not in path and deepest.get(called, 0) < len(path) + 1:
                deepest[called] = len(path) + 1
                ways.append((called, (*path, called)))
    return deepest
