"""Lower a checked ARP program to resumable instructions (`languages.resumable`).

The Python in them calls only the names in `NAMES`, which `runtime` provides.  Texts and routines are passed by number,
so no text from the program's author gets into generated code.
"""

import dataclasses
from dataclasses import dataclass, field
from typing import Final

from fieldrig.coverage import collecting
from fieldrig.coverage.marks import HIT, SuiteMarks, hit
from fieldrig.coverage.places import Kind, Marked, Place
from fieldrig_devices.arp.language import instructions, tree
from fieldrig_devices.arp.language.emit import FUNCTIONS as _FUNCTIONS
from fieldrig_devices.arp.language.emit import INDENT, READERS, SHIFTS, Emitter, inside
from fieldrig_devices.arp.language.instructions import Value
from fieldrig_devices.languages import instructions as resumable
from fieldrig_devices.languages.instructions import Branch, Do, End, Hold, Instruction, Jump, Pause

WRITERS: Final = {"@POS": "set_position", "@FLAG": "set_flag_word", "@OUT": "set_output_word"}
EDGES: Final = {"": 0, "!": 1, "/": 2, "\\": 3}
MODES: Final = {"E": 1, "P": 2}
BUSY: Final = {1: "F[263]", 2: "F[295]"}  # movement running (manual 4.6)

_CALLS: Final = {
    "DAC": {2: "dac", 3: "dac_slope"},
    "STIM": {1: "stim", 3: "stim_flag"},
    "TERM": {0: "term_clear", 2: "term_erase", 4: "term_show", 5: "term_value", 6: "term_edit"},
    "PRINT": {1: "print_message", 2: "print_value"},
    "CAM": {0: "cam_off", 4: "cam"},
    "ON": {0: "on_off"},
}
"""Function that an instruction calls, by the number of its values, if it is not the instruction's own word in lower
case."""

_PLAIN: Final = ("HOME", "VEL", "ACC", "DEC", "PAC", "PRC", "PVC", "PST", "STOP", "PID", "MSG")

NAMES: Final = frozenset(
    {
        "V", "F", "I", "O", "terminals", "wrong_index", "saturated", "divided_by_zero", "wait",
        "general", "parameter", "set_parameter", "set_flag", "adc", "tim", "error", "warning", "on_bit", "on_position",
        *READERS.values(), *WRITERS.values(), *_FUNCTIONS.values(), *SHIFTS.values(),
        *(word.lower() for word in _PLAIN), *(name for names in _CALLS.values() for name in names.values()),
    }
)  # fmt: skip
"""All names that generated code may use, apart from its own temporaries."""


@dataclass
class Lowered:
    routines: dict[str, list[Instruction]] = field(default_factory=dict)
    texts: list[str] = field(default_factory=list)
    """Texts of the MSG instructions, by number."""
    marked: Marked = field(default_factory=Marked)
    """The marks in the code; empty unless coverage is wanted."""


def lower(program: tree.Program) -> Lowered:
    lowered = Lowered()
    numbers = {routine.name: number for number, routine in enumerate(program.routines)}
    for routine in program.routines:
        lowered.routines[routine.name] = _RoutineLowerer(routine, numbers, lowered).instructions
    return lowered


class _RoutineLowerer:
    def __init__(self, routine: tree.Routine, numbers: dict[str, int], lowered: Lowered) -> None:
        self._name, self._numbers, self._texts, self._marked = routine.name, numbers, lowered.texts, lowered.marked
        self._marks = SuiteMarks(self._mark, is_on=collecting.is_on())
        self.instructions: list[Instruction] = []
        self._labels: dict[str, int] = {}
        self._waiting: dict[int, str] = {}
        """Label that each unresolved jump refers to, by the index of the jump."""
        self._line = 0
        for line in routine.lines:
            self._line = line.number
            if line.label is not None:
                self._labels[line.label] = len(self.instructions)
                self._marks.leave()
            if line.content is not None and not isinstance(line.content, tree.Equ):
                self._count(Kind.STATEMENT)
                self._whole_statement(line.content)
        self.instructions.append(End(routine.end_number))
        for pc, label in self._waiting.items():
            self._set_target(pc, self._labels[label])
        self._marked.places += self._marks.places

    # ---- marks of coverage

    def _mark(self) -> int:
        """Add a mark, which costs the program no time; return its number."""
        number = self._marked.new()
        self.instructions.append(Do(self._line, (hit(number),), 0))
        return number

    def _place(self, kind: Kind, what: str = "") -> Place:
        return Place("", self._name, kind, self._line, 0, self._line if kind is Kind.BRANCH else 0, what)

    def _count(self, kind: Kind) -> None:
        self._marks.add(self._place(kind))

    def _arms(self, condition: str) -> tuple[str, ...]:
        """Count both ways out of an IF, and return the lines that mark the one that is taken."""
        if not self._marks.is_on:
            return ()
        taken, other = self._marked.new(), self._marked.new()
        self._marks.alone(taken, self._place(Kind.BRANCH, "IF"))
        self._marks.alone(other, self._place(Kind.BRANCH, "no IF"))
        return (f"{HIT}[{taken} if {condition} else {other}] = 1",)

    def _whole_statement(self, statement: tree.Statement) -> None:
        """Add a statement; the next one has a mark of its own if it may not run, or run later."""
        before = len(self.instructions)
        self._statement(statement)
        if any(not isinstance(one, Do) for one in self.instructions[before:]):
            self._marks.leave()

    # ---- instructions

    def _set_target(self, pc: int, target: int) -> None:
        jump = self.instructions[pc]
        assert isinstance(jump, Branch | Jump)
        self.instructions[pc] = dataclasses.replace(jump, target=target)

    def _do(self, emitter: Emitter, *lines: str) -> None:
        self.instructions.append(Do(self._line, (*emitter.lines, *lines)))

    def _statement(self, statement: tree.Statement) -> None:
        match statement:
            case tree.Assign():
                self._assign(statement)
            case tree.Goto(label):
                self._waiting[len(self.instructions)] = label
                self.instructions.append(Jump(self._line, -1))
            case tree.Call(routine):
                self.instructions.append(resumable.Call(self._line, routine))
            case tree.If():
                self._if(statement)
            case tree.OnEvent():
                self._on_event(statement)
            case tree.Command():
                self._command(statement)

    def _if(self, statement: tree.If) -> None:
        emitter = Emitter()
        condition = emitter.condition(statement.left, statement.relation, statement.right)
        emitter.lines += self._arms(condition)
        own = len(self.instructions)
        if isinstance(statement.then, tree.Goto):
            self._waiting[own] = statement.then.label
            self.instructions.append(Branch(self._line, tuple(emitter.lines), condition, -1))
            return
        self.instructions.append(Branch(self._line, tuple(emitter.lines), f"not ({condition})", -1))
        self._statement(statement.then)
        then = self.instructions[own + 1]
        if len(self.instructions) == own + 2 and isinstance(then, Do):
            del self.instructions[own:]
            self._do(emitter, f"if {condition}:", *(INDENT + line for line in then.python))
        else:
            self._set_target(own, len(self.instructions))

    # ---- assignments

    def _assign(self, node: tree.Assign) -> None:
        target = node.target
        emitter = Emitter()
        if isinstance(target, tree.Direct | tree.Indexed) and target.letter != "V":
            self._assign_bit(node, target, emitter)
            return
        value = self._assigned(node, emitter)
        match target:
            case tree.Direct(_, number):
                self._do(emitter, f"V[{number}] = {value}")
            case tree.Indexed():
                index = emitter.index(target)
                self._do(emitter, *_guarded("V", index, f"V[{index}] = {value}"))
            case tree.System("@PAR", axis, parameter):
                self._do(emitter, f"set_parameter({axis}, {parameter}, {value})")
            case tree.System(word, number):
                self._do(emitter, f"{WRITERS[word]}({number}, {value})")

    def _assigned(self, node: tree.Assign, emitter: Emitter) -> str:
        if isinstance(node.value, tree.Read):
            number = node.value.number
            argument = str(number.raw // 1000) if isinstance(number, tree.Number) else ""
            return f"{node.value.word.lower()}({argument})"
        if node.sign == "==":
            return emitter.value(node.value)
        return emitter.value(tree.Binary(node.sign[:-1], node.target, node.value))

    def _assign_bit(self, node: tree.Assign, target: tree.Direct | tree.Indexed, emitter: Emitter) -> None:
        assert not isinstance(node.value, tree.Read)
        whole = node.value if node.sign == "==" else tree.Binary(node.sign[:-1], target, node.value)
        self._write_bit(target, emitter.bit(whole), emitter)

    def _write_bit(self, target: tree.Direct | tree.Indexed, bit: str, emitter: Emitter) -> None:
        index = emitter.index(target)
        if isinstance(target, tree.Direct):
            self._do(emitter, f"{target.letter}[{index}] = {bit}")
        elif target.letter == "F":
            self._do(emitter, f"set_flag({index}, {bit})")
        else:
            self._do(emitter, *_guarded("O", index, f"O[{index}] = {bit}"))

    # ---- instructions with values

    def _command(self, node: tree.Command) -> None:
        emitter = Emitter()
        if node.word in ("SET", "RES"):
            (target,) = node.arguments
            assert isinstance(target, tree.Direct | tree.Indexed)
            self._write_bit(target, "1" if node.word == "SET" else "0", emitter)
            return
        values = [str(node.number)] if node.number is not None else []
        places = instructions.SIGNATURES[node.word].values
        for argument, place in zip(node.arguments, places, strict=False):
            values += self._argument(argument, place, emitter)
        if node.word == "WAIT":
            self.instructions.append(Pause(self._line, tuple(emitter.lines), f"wait({values[0]})"))
            return
        if node.word in instructions.MOVES:
            self.instructions.append(Hold(self._line, BUSY[int(values[instructions.MOVES[node.word]])]))
        called = _CALLS[node.word][len(node.arguments)] if node.word in _CALLS else node.word.lower()
        self._do(emitter, f"{called}({', '.join(values)})")

    def _argument(self, argument: tree.Argument, place: Value, emitter: Emitter) -> list[str]:
        match argument:
            case tree.Text(text):
                self._texts.append(text)
                return [str(len(self._texts) - 1)]
            case tree.Mode(word):
                return [str(MODES[word])]
            case tree.Unary("!", (tree.Direct() | tree.Indexed()) as bit) if place is Value.CAM_BIT:
                return ["1", str(int(bit.letter == "O")), emitter.index(bit)]
            case tree.Direct() | tree.Indexed() if place is Value.CAM_BIT:
                return ["0", str(int(argument.letter == "O")), emitter.index(argument)]
            case tree.Direct() | tree.Indexed() if place in (Value.VARIABLE, Value.FLAG):
                return [emitter.index(argument)]
            case tree.Number(raw) if place in instructions.CONSTANT and place not in instructions.OR_VARIABLE:
                return [str(raw // 1000)]
        return [emitter.value(argument)]

    # ---- events

    def _on_event(self, node: tree.OnEvent) -> None:
        emitter = Emitter()
        routine = self._numbers[node.routine]
        assert isinstance(node.enable, tree.Direct | tree.Indexed)
        head = f"{node.number}, {routine}, {emitter.index(node.enable)}"
        match node.condition:
            case tree.BitCondition(edge, (tree.Direct() | tree.Indexed()) as bit):
                self._do(emitter, f"on_bit({head}, {EDGES[edge]}, {int(bit.letter == 'I')}, {emitter.index(bit)})")
            case tree.PositionCondition(tree.Number(raw), relation, (tree.Direct() | tree.Indexed()) as variable):
                is_above = int(relation == ">")
                self._do(emitter, f"on_position({head}, {raw // 1000}, {is_above}, {emitter.index(variable)})")


def _guarded(letter: str, index: str, line: str) -> tuple[str, ...]:
    return f"if {inside(letter, index)}:", INDENT + line, "else:", f"{INDENT}wrong_index()"
