"""Check a parsed program: ranges, kinds of values, and the targets of jumps and calls.

Source: digest chapter 3 (compile-time checks), chapters 5 to 8, and chapter 18 for its interpretations.  It works on a
resolved tree (`names`), so a mistake in a name is reported for what the name means.
"""

import dataclasses
from collections.abc import Iterator

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.language import instructions, tree
from fieldrig_devices.arp.language.bits import can_be_bit, is_constant
from fieldrig_devices.arp.language.instructions import CONSTANT, OR_VARIABLE, READS, SIGNATURES, Value
from fieldrig_devices.arp.language.names import Symbols
from fieldrig_devices.languages.mistakes import Mistake

LONGEST_TEXT = 16  # manual 5.12
DEEPEST_CALL = 10  # manual 5.5


def check(program: tree.Program, symbols: Symbols) -> list[Mistake]:
    checker = _Checker(symbols)
    for routine in program.routines:
        checker.routine(routine)
    checker.calls(program)
    return checker.mistakes


def check_equs(program: tree.Program) -> list[Mistake]:
    """Check the EQU lines of a program as it was read: their targets must exist even if no line uses the name."""
    checker = _Checker(Symbols())
    for line in (*program.outside, *(line for routine in program.routines for line in routine.lines)):
        if isinstance(line.content, tree.Equ):
            checker.equ(line.number, line.content)
    return checker.mistakes


def _walk(node: tree.Node) -> Iterator[tree.Node]:
    yield node
    for part in dataclasses.fields(node):
        value = getattr(node, part.name)
        for child in value if isinstance(value, tuple) else (value,):
            if isinstance(child, tree.Node):
                yield from _walk(child)


class _Checker:
    def __init__(self, symbols: Symbols) -> None:
        self._symbols = symbols
        self.mistakes: list[Mistake] = []
        self._line = 0
        self._routine = ""

    def _say(self, node: tree.Node, what: str, expected: str = "", is_note: bool = False) -> None:
        self.mistakes.append(Mistake(self._line, node.column, what, expected, is_note))

    def routine(self, routine: tree.Routine) -> None:
        self._routine = routine.name
        for line in routine.lines:
            self._line = line.number
            if line.content is not None and not isinstance(line.content, tree.Equ):
                for node in _walk(line.content):
                    self._node(node)

    def equ(self, line: int, equ: tree.Equ) -> None:
        self._line = line
        for node in _walk(equ.meaning):
            self._node(node)

    def _node(self, node: tree.Node) -> None:
        match node:
            case tree.Direct(letter, number):
                if number not in instructions.numbers(letter):
                    self._say(node, f"there is no {letter}{number}", _range_text(letter))
            case tree.System():
                self._system(node)
            case tree.Assign():
                self._assign(node)
            case tree.Read(word, tree.Node() as number):
                first, last = READS[word] or (0, 0)
                self._constant(number, first, last, f"{word} with {first} to {last}")
            case tree.If():
                if is_constant(node.left) and is_constant(node.right):
                    self._say(node.left, "two constants are compared", "a variable or a bit on one side")
            case tree.Goto():
                self._goto(node)
            case tree.Call():
                self._call(node)
            case tree.OnEvent():
                self._on_event(node)
            case tree.Command():
                for index, argument in enumerate(node.arguments):
                    self._argument(argument, SIGNATURES[node.word].values[index])

    def _system(self, node: tree.System) -> None:
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

    def _assign(self, node: tree.Assign) -> None:
        target = node.target
        if isinstance(target, tree.Direct | tree.Indexed) and target.letter in ("F", "O"):
            self._writable(target)
            self._assign_bit(node)
        elif isinstance(target, tree.Direct | tree.Indexed) and target.letter == "I":
            self._say(target, "an input cannot be written", "a variable, a flag or an output")
        elif isinstance(target, tree.System) and target.word.startswith("#"):
            self._say(target, f"{target.word}{target.number} can only be read", "a variable, or one that begins with @")
        elif isinstance(target, tree.System) and target.word == "@PAR" and target.number is None:
            self._say(target, "a program cannot change general parameters (manual 2.2)", "@PAR1[...] or @PAR2[...]")
        elif not isinstance(target, tree.Direct | tree.Indexed | tree.System):
            self._say(target, "a number cannot be assigned to", "a name for a variable, a flag or an output")

    def _assign_bit(self, node: tree.Assign) -> None:
        if node.sign not in ("==", "&=", "|=", "^="):
            self._say(node, f"{node.sign} is for variables, and this is one bit", "==, &=, |= or ^=")
        if isinstance(node.value, tree.Read):
            self._say(node.value, f"{node.value.word} is a number, and this is one bit", "a variable V before ==")
        elif not can_be_bit(node.value):
            self._say(node.value, "a number cannot be assigned to one bit", "flags, inputs, outputs, HI or LO")

    def _writable(self, target: tree.Direct | tree.Indexed) -> None:
        if not isinstance(target, tree.Direct) or target.letter != "F" or target.number > 320:
            return
        if target.number in instructions.numbers("F") and target.number not in instructions.WRITABLE:
            self._say(target, f"only the system writes F{target.number}", "a flag that is R/W (manual 4.6)")

    # ---- jumps and calls

    def _goto(self, node: tree.Goto) -> None:
        home = self._symbols.labels.get(node.label)
        if home == self._routine:
            return
        if home is not None:
            self._say(node, f"the label {node.label} is in {home}", "a label of the same routine (manual 5.5)")
        elif node.label in self._symbols.routines:
            self._say(node, f"{node.label} is a routine", f"CALL {node.label}, or a label")
        else:
            self._say(node, f"there is no label {node.label}", f"a line {node.label}: in {self._routine}")

    def _call(self, node: tree.Call) -> None:
        routine = self._symbols.routines.get(node.routine)
        if routine is None:
            self._say(node, f"there is no subprogram {node.routine}", f"BEG {node.routine} ... END")
        elif routine.is_interrupt:
            self._say(node, f"{node.routine} is an interrupt routine; only ONn runs it", "a subprogram with BEG")
        elif routine is next(iter(self._symbols.routines.values())):
            self._say(node, f"{node.routine} is the main program", "a subprogram")

    def calls(self, program: tree.Program) -> None:
        """Check the depth of calls: subprograms call each other up to 10 levels (manual 5.5)."""
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

    def _on_event(self, node: tree.OnEvent) -> None:
        self._resource(node.enable, "F", "a flag that enables the event")
        routine = self._symbols.routines.get(node.routine)
        if routine is None:
            self._say(node, f"there is no interrupt routine {node.routine}", f"BEGA {node.routine} ... ENDA")
        elif not routine.is_interrupt:
            self._say(node, f"{node.routine} is no interrupt routine", "one that begins with BEGA")
        match node.condition:
            case tree.BitCondition(bit=bit):
                self._resource(bit, "FI", "a flag or an input")
            case tree.PositionCondition(axis=axis, variable=variable):
                self._constant(axis, 1, 2, Value.AXIS.value)
                self._resource(variable, "V", "a variable V")

    def _resource(self, node: tree.Node, letters: str, expected: str) -> None:
        if not isinstance(node, tree.Direct | tree.Indexed) or node.letter not in letters:
            self._say(node, "this is not allowed here", expected)

    def _constant(self, node: tree.Node, first: int, last: int, expected: str) -> None:
        if not isinstance(node, tree.Number):
            self._say(node, "only a constant is allowed here", expected)
        elif node.raw % fixed.SCALE or not first <= node.raw // fixed.SCALE <= last:
            self._say(node, f"{fixed.to_text(node.raw)} is not allowed here", expected)

    def _argument(self, node: tree.Argument, value: Value) -> None:
        if value in OR_VARIABLE and isinstance(node, tree.Direct | tree.Indexed):
            self._resource(node, "V", value.value)
        elif value in (Value.LINE, Value.COLUMN) and isinstance(node, tree.Number) and node.raw % fixed.SCALE == 0:
            first, last = CONSTANT[value]
            if not first <= node.raw // fixed.SCALE <= last:  # digest I-27: W03, and the text is cut
                what = f"{fixed.to_text(node.raw)} is off the screen of 8 lines and 16 columns: it causes W03"
                self._say(node, what, is_note=True)
        elif value in CONSTANT:
            self._constant(node, *CONSTANT[value], value.value)
        elif value is Value.VARIABLE:
            self._resource(node, "V", value.value)
        elif value in (Value.FLAG, Value.BIT):
            self._resource(node, "F" if value is Value.FLAG else "FO", value.value)
            if isinstance(node, tree.Direct | tree.Indexed):
                self._writable(node)
        elif value is Value.CAM_BIT:
            inner = node.operand if isinstance(node, tree.Unary) and node.sign == "!" else node
            self._argument(inner, Value.BIT)
        elif isinstance(node, tree.Text) and len(node.text) > LONGEST_TEXT:
            what = f"the message has {len(node.text)} characters; the terminal keeps {LONGEST_TEXT}"
            self._say(node, what, is_note=True)


def _range_text(letter: str) -> str:
    return " or ".join(f"{letter}{first} to {letter}{last}" for first, last in instructions.RANGES[letter])


def _calls(routine: tree.Routine) -> Iterator[str]:
    for line in routine.lines:
        if line.content is not None:
            yield from (node.routine for node in _walk(line.content) if isinstance(node, tree.Call))


def _levels(start: str, edges: dict[str, list[str]]) -> dict[str, int]:
    """Levels of calls for every routine reachable from `start`, along the longest path without a cycle."""
    deepest: dict[str, int] = {}
    paths: list[tuple[str, tuple[str, ...]]] = [(start, ())]
    while paths:
        name, path = paths.pop()
        for called in edges.get(name, ()):
            if called not in path and deepest.get(called, 0) < len(path) + 1:
                deepest[called] = len(path) + 1
                paths.append((called, (*path, called)))
    return deepest
