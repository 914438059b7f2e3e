"""From a checked ARP program to resumable instructions (`languages.resumable`).

The Python in them calls by name what `runtime` provides: the words of `NAMES`, nothing else.  Texts and routines are
passed by their numbers, so no text of the program's author ever stands in generated code.
"""

import dataclasses
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.arp.language import instructions
from fieldrig_devices.arp.language.emit import FUNCTIONS as _FUNCTIONS
from fieldrig_devices.arp.language.emit import INDENT, READERS, SHIFTS, Emitter, inside
from fieldrig_devices.arp.language.instructions import Value
from fieldrig_devices.arp.language.tree import (
    Argument,
    Assign,
    Binary,
    BitCondition,
    Call,
    Command,
    Direct,
    Equ,
    Goto,
    If,
    Indexed,
    Mode,
    Number,
    OnEvent,
    PositionCondition,
    Program,
    Read,
    Routine,
    Statement,
    System,
    Text,
    Unary,
)
from fieldrig_devices.languages import resumable
from fieldrig_devices.languages.resumable import Branch, Do, End, Hold, Instruction, Jump, Pause

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
"""What an instruction calls by the count of its values, where that is not its own word in small letters."""

_PLAIN: Final = ("HOME", "VEL", "ACC", "DEC", "PAC", "PRC", "PVC", "PST", "STOP", "PID", "MSG")

NAMES: Final = frozenset(
    {
        "V", "F", "I", "O", "terminals", "wrong_index", "saturated", "divided_by_zero", "wait",
        "general", "parameter", "set_parameter", "set_flag", "adc", "tim", "error", "warning", "on_bit", "on_position",
        *READERS.values(), *WRITERS.values(), *_FUNCTIONS.values(), *SHIFTS.values(),
        *(word.lower() for word in _PLAIN), *(name for names in _CALLS.values() for name in names.values()),
    }
)  # fmt: skip
"""All names that generated code may use, beside its own temporaries."""


@dataclass
class Lowered:
    routines: dict[str, list[Instruction]] = field(default_factory=dict)
    texts: list[str] = field(default_factory=list)
    """Of MSG, by their numbers."""


def lower(program: Program) -> Lowered:
    lowered = Lowered()
    numbers = {routine.name: number for number, routine in enumerate(program.routines)}
    for routine in program.routines:
        lowered.routines[routine.name] = _RoutineLowerer(routine, numbers, lowered.texts).instructions
    return lowered


class _RoutineLowerer:
    def __init__(self, routine: Routine, numbers: dict[str, int], texts: list[str]) -> None:
        self._numbers, self._texts = numbers, texts
        self.instructions: list[Instruction] = []
        self._labels: dict[str, int] = {}
        self._waiting: dict[int, str] = {}
        """Jumps that wait for the place of their label."""
        self._line = 0
        for line in routine.lines:
            self._line = line.number
            if line.label is not None:
                self._labels[line.label] = len(self.instructions)
            if line.content is not None and not isinstance(line.content, Equ):
                self._statement(line.content)
        self.instructions.append(End(routine.end_number))
        for pc, label in self._waiting.items():
            self._set_target(pc, self._labels[label])

    def _set_target(self, pc: int, target: int) -> None:
        jump = self.instructions[pc]
        assert isinstance(jump, Branch | Jump)
        self.instructions[pc] = dataclasses.replace(jump, target=target)

    def _do(self, emitter: Emitter, *lines: str) -> None:
        self.instructions.append(Do(self._line, (*emitter.lines, *lines)))

    def _statement(self, statement: Statement) -> None:
        match statement:
            case Assign():
                self._assign(statement)
            case Goto(label):
                self._waiting[len(self.instructions)] = label
                self.instructions.append(Jump(self._line, -1))
            case Call(routine):
                self.instructions.append(resumable.Call(self._line, routine))
            case If():
                self._if(statement)
            case OnEvent():
                self._on_event(statement)
            case Command():
                self._command(statement)

    def _if(self, statement: If) -> None:
        emitter = Emitter()
        condition = emitter.condition(statement.left, statement.relation, statement.right)
        own = len(self.instructions)
        if isinstance(statement.then, Goto):
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

    def _assign(self, node: Assign) -> None:
        target = node.target
        emitter = Emitter()
        if isinstance(target, Direct | Indexed) and target.letter != "V":
            self._assign_bit(node, target, emitter)
            return
        value = self._assigned(node, emitter)
        match target:
            case Direct(_, number):
                self._do(emitter, f"V[{number}] = {value}")
            case Indexed():
                index = emitter.index(target)
                self._do(emitter, *_guarded("V", index, f"V[{index}] = {value}"))
            case System("@PAR", axis, parameter):
                self._do(emitter, f"set_parameter({axis}, {parameter}, {value})")
            case System(word, number):
                self._do(emitter, f"{WRITERS[word]}({number}, {value})")

    def _assigned(self, node: Assign, emitter: Emitter) -> str:
        if isinstance(node.value, Read):
            number = node.value.number
            argument = str(number.raw // 1000) if isinstance(number, Number) else ""
            return f"{node.value.word.lower()}({argument})"
        if node.sign == "==":
            return emitter.value(node.value)
        return emitter.value(Binary(node.sign[:-1], node.target, node.value))

    def _assign_bit(self, node: Assign, target: Direct | Indexed, emitter: Emitter) -> None:
        assert not isinstance(node.value, Read)
        whole = node.value if node.sign == "==" else Binary(node.sign[:-1], target, node.value)
        self._write_bit(target, emitter.bit(whole), emitter)

    def _write_bit(self, target: Direct | Indexed, bit: str, emitter: Emitter) -> None:
        index = emitter.index(target)
        if isinstance(target, Direct):
            self._do(emitter, f"{target.letter}[{index}] = {bit}")
        elif target.letter == "F":
            self._do(emitter, f"set_flag({index}, {bit})")
        else:
            self._do(emitter, *_guarded("O", index, f"O[{index}] = {bit}"))

    # ---- instructions with values

    def _command(self, node: Command) -> None:
        emitter = Emitter()
        if node.word in ("SET", "RES"):
            (target,) = node.arguments
            assert isinstance(target, Direct | Indexed)
            self._write_bit(target, "1" if node.word == "SET" else "0", emitter)
            return
        values = [str(node.number)] if node.number is not None else []
        places = instructions.SIGNATURES[node.word].values
        for one, place in zip(node.arguments, places, strict=False):
            values += self._argument(one, place, emitter)
        if node.word == "WAIT":
            self.instructions.append(Pause(self._line, tuple(emitter.lines), f"wait({values[0]})"))
            return
        if node.word in instructions.MOVES:
            self.instructions.append(Hold(self._line, BUSY[int(values[instructions.MOVES[node.word]])]))
        called = _CALLS[node.word][len(node.arguments)] if node.word in _CALLS else node.word.lower()
        self._do(emitter, f"{called}({', '.join(values)})")

    def _argument(self, one: Argument, place: Value, emitter: Emitter) -> list[str]:
        match one:
            case Text(text):
                self._texts.append(text)
                return [str(len(self._texts) - 1)]
            case Mode(word):
                return [str(MODES[word])]
            case Unary("!", (Direct() | Indexed()) as bit) if place is Value.CAM_BIT:
                return ["1", str(int(bit.letter == "O")), emitter.index(bit)]
            case Direct() | Indexed() if place is Value.CAM_BIT:
                return ["0", str(int(one.letter == "O")), emitter.index(one)]
            case Direct() | Indexed() if place in (Value.VARIABLE, Value.FLAG):
                return [emitter.index(one)]
            case Number(raw) if place in instructions.CONSTANT and place not in instructions.OR_VARIABLE:
                return [str(raw // 1000)]
        return [emitter.value(one)]

    # ---- events

    def _on_event(self, node: OnEvent) -> None:
        emitter = Emitter()
        routine = self._numbers[node.routine]
        assert isinstance(node.enable, Direct | Indexed)
        head = f"{node.number}, {routine}, {emitter.index(node.enable)}"
        match node.condition:
            case BitCondition(edge, (Direct() | Indexed()) as bit):
                self._do(emitter, f"on_bit({head}, {EDGES[edge]}, {int(bit.letter == 'I')}, {emitter.index(bit)})")
            case PositionCondition(Number(raw), relation, (Direct() | Indexed()) as variable):
                is_above = int(relation == ">")
                self._do(emitter, f"on_position({head}, {raw // 1000}, {is_above}, {emitter.index(variable)})")


def _guarded(letter: str, index: str, line: str) -> tuple[str, ...]:
    return f"if {inside(letter, index)}:", INDENT + line, "else:", f"{INDENT}wrong_index()"
