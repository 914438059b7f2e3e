"""Instruction List: lines become expressions and statements.

Source: PacDrive manual 1264 to 1363.  The accumulator is an expression that grows from line to line.  It is stored in a
variable of its own where its value has to outlive what follows: a store, a call, a conditional jump, or a label that is
reached from several places.  Brackets hold a list of their own, whose accumulator is the operand.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import program, tree
from fieldrig_devices.iec.check import blocks, constants, enable
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import Expressions
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.instructions import SPELLINGS, SYMBOLS
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.program import AnyStatement, Expression
from fieldrig_devices.iec.types import BlockType, Type

LARGEST: Final = 32
"""Operations in one expression; a longer list is computed in parts."""
_OPERATORS: Final = frozenset(operator for operator, _, _ in SPELLINGS.values())
_PASSING: Final = frozenset({"", "CAL", "JMP", "RET"})
"""Operators that leave the accumulator as it is and do not read it, if they are not conditional."""
_ACTING: Final = frozenset({"ST", "S", "R", "CAL", "JMP", "RET"})
_INPUTS: Final = frozenset({"S", "R", "S1", "R1", "CLK", "CU", "CD", "PV", "IN", "PT"})
"""Inputs of the standard function blocks that are operators (IEC 61131-3, tables of IL)."""
_NO_BLANK: Final = re.compile(
    r"(LD|ST|AND|OR|XOR|ADD|SUB|MUL|DIV|MOD|GT|GE|EQ|NE|LE|LT|NOT|ROL|ROR|SHL|SHR)(\w+)", re.IGNORECASE
)


def lower_il(body: tree.IlBody, context: Context) -> list[AnyStatement]:
    """Return the statements of a body."""
    return _Instructions(context).body(body.instructions)


@dataclass(slots=True)
class _Lines:
    """A list of lines: a body, or the inside of brackets."""

    lines: Sequence[tree.IlInstruction]
    is_operand: bool
    """True in brackets, where the accumulator is used at the end."""
    labels: dict[str, int] = field(default_factory=dict)

    def reads(self, start: int, key: "dict[str, str]") -> bool:
        """True if the accumulator is used from a line on before it is loaded again."""
        seen: set[int] = set()
        at = start
        while at < len(self.lines):
            line = self.lines[at]
            if at in seen:
                return False
            seen.add(at)
            if line.operator == "LD":
                return False
            if line.operator not in _PASSING or line.is_conditional:
                return True
            if line.operator == "RET":
                return False
            at = self._target(line, key) if line.operator == "JMP" else at + 1
        return self.is_operand

    def _target(self, line: tree.IlInstruction, key: "dict[str, str]") -> int:
        label = line.operands[0] if line.operands else None
        name = key.get(label.text, "") if isinstance(label, tree.Name) else ""
        return self.labels.get(name, len(self.lines))


class _Instructions:
    def __init__(self, context: Context) -> None:
        self._context = context
        self._expressions = Expressions(context)
        self._made: list[AnyStatement] = []
        self._accumulator: tree.Expression | None = None
        self._is_lost = False
        """True behind a mistake, so that no message about an empty accumulator follows from it."""
        self._size = 0
        self._list = _Lines((), False)
        self._keys: dict[str, str] = {}
        self._at_labels: dict[str, tree.Name] = {}
        """The variables that hold the accumulator at labels."""

    def body(self, lines: Sequence[tree.IlInstruction]) -> list[AnyStatement]:
        self._list = _Lines(lines, False)
        for number, line in enumerate(lines):
            if line.label:
                self._declare_label(line, number)
            if line.operator == "JMP" and line.operands and isinstance(line.operands[0], tree.Name):
                self._keys[line.operands[0].text] = self._context.key(line.operands[0].text)
        self._run()
        return self._made

    def _declare_label(self, line: tree.IlInstruction, number: int) -> None:
        name = self._context.key(line.label)
        if name in self._list.labels:
            where = self._list.lines[self._list.labels[name]].position.line
            self._context.say(line, f"the label {line.label} exists already in line {where}", "another name")
            return
        self._list.labels[name] = number

    def _run(self) -> None:
        for number, line in enumerate(self._list.lines):
            if line.label:
                self._label(line, number)
            if line.operator:
                self._line(line, number)

    def _line(self, line: tree.IlInstruction, number: int) -> None:
        if self._is_input(line):
            self._feed(line, number)
            return
        match line.operator:
            case "LD":
                self._load(line)
            case "ST":
                self._store(line, number)
            case "S" | "R":
                self._set(line, number)
            case "JMP":
                self._jump(line, number)
            case "CAL":
                self._call(line, number)
            case "RET":
                self._return(line, number)
            case "NOT":
                self._not(line)
            case _:
                self._operate(line)

    # ---- the accumulator

    def _needed(self, line: tree.IlInstruction) -> tree.Expression | None:
        """Return the accumulator, or None after a message that it is empty."""
        if self._accumulator is None and not self._is_lost:
            self._context.say(line, f"{line.operator} has no value to work with", "LD in a line before it")
            self._is_lost = True
        return self._accumulator

    def _become(self, value: tree.Expression | None) -> None:
        self._accumulator = value
        self._is_lost = value is None

    def _keep(self, line: tree.IlInstruction) -> None:
        """Store the accumulator in a variable, so that what follows cannot change it."""
        value = self._accumulator
        if value is None or isinstance(value, tree.Literal) or self._is_stored(value):
            return
        self._become(self._stored(value, line))

    def _is_stored(self, value: tree.Expression) -> bool:
        return isinstance(value, tree.Name) and value.text.startswith("the accumulator")

    def _stored(self, value: tree.Expression, line: tree.IlInstruction) -> tree.Name | None:
        """Assign a value to a new variable, and return its name; None after a message."""
        checked = self._expressions.expression(value)
        if checked is None:
            return None
        whole = constants.whole(checked)
        kind = _typed(whole)
        name = self._variable(kind, line)
        if whole is not checked:
            self._context.names[self._context.key(name.text)].narrow = checked.type
        self._assign(name, whole, kind, line)
        return name

    def _variable(self, kind: Type, line: tree.IlInstruction) -> tree.Name:
        shown = f"the accumulator of line {line.position.line}"
        while self._context.key(shown) in self._context.names:
            shown = f"{shown}'"
        self._context.names[self._context.key(shown)] = self._context.hidden("accumulator", kind)
        return tree.Name(shown, position=line.position)

    def _assign(self, name: tree.Name, value: Expression, kind: Type, line: tree.IlInstruction) -> None:
        place = self._expressions.target(name)
        converted = self._expressions.convert(value, kind, line)
        if place is not None and converted is not None:
            self._made.append(program.Assign(place, converted, line=line.position.line))

    # ---- values

    def _load(self, line: tree.IlInstruction) -> None:
        self._size = 0
        if len(line.operands) != 1:
            self._context.say(line, f"LD has {_count(line)}", "one operand")
            self._become(None)
            return
        self._become(_negated(line.operands[0], line))

    def _not(self, line: tree.IlInstruction) -> None:
        value = self._needed(line)
        if line.operands:
            self._context.say(
                line, "NOT has an operand", "NOT alone", "NOT inverts the accumulator. LDN loads inverted."
            )
        elif value is not None:
            self._grow(line)
            self._become(tree.Unary("NOT", self._accumulator or value, position=line.position))

    def _operate(self, line: tree.IlInstruction) -> None:
        operands = self._operands(line)
        if operands is None:
            self._become(None)
            return
        symbol = SYMBOLS.get(line.operator)
        if symbol is None:
            self._function(line, operands)
            return
        value = self._needed(line)
        if not operands:
            self._context.say(line, f"{line.operator} has no operand", "an operand")
            self._become(None)
        elif value is not None and len(operands) > 1 and symbol in ("=", "<>", "<", ">", "<=", ">="):
            self._function(line, operands)
        elif value is not None:
            for operand in operands:
                self._grow(line)
                if self._accumulator is None:
                    return
                value = tree.Binary(symbol, self._accumulator, _negated(operand, line), position=line.position)
                self._become(value)

    def _grow(self, line: tree.IlInstruction) -> None:
        """Store the accumulator from time to time, so that expressions stay small."""
        self._size += 1
        if self._size > LARGEST:
            self._size = 0
            self._keep(line)

    def _function(self, line: tree.IlInstruction, operands: list[tree.Expression]) -> None:
        """Call a function, with the accumulator as its first argument."""
        name = line.operator
        if self._context.find(name) is None and not intrinsics.is_standard(name) and name.upper() not in _SPECIAL:
            parts = _NO_BLANK.fullmatch(name)
            hint = f"Write {parts[1].upper()} {parts[2]}, with a blank." if parts else ""
            self._context.say(
                line, f"{name} is neither an operator of IL nor a function", "LD, ST or another operator", hint
            )
            self._become(None)
            return
        if self._accumulator is None and self._is_lost:
            return
        values = ([self._accumulator] if self._accumulator is not None else []) + operands
        arguments = tuple(tree.Argument(value, position=value.position) for value in values)
        self._grow(line)
        self._become(tree.Call(tree.Name(name, position=line.position), arguments, position=line.position))

    def _operands(self, line: tree.IlInstruction) -> list[tree.Expression] | None:
        if line.deferred is None:
            return list(line.operands)
        if any(_acts(inner) for inner in line.deferred):
            self._keep(line)
        outer, accumulator, size = self._list, self._accumulator, self._size
        self._list = _Lines(line.deferred, True)
        self._accumulator, self._size = None, 0
        self._run()
        inner = self._accumulator
        is_lost = self._is_lost
        self._list, self._accumulator, self._size = outer, accumulator, size + self._size
        if inner is None and not is_lost:
            self._context.say(line, "the brackets contain no value", "LD behind the opening bracket")
        self._is_lost = accumulator is None and self._is_lost
        return [inner] if inner is not None else None

    # ---- stores

    def _store(self, line: tree.IlInstruction, number: int) -> None:
        if self._needed(line) is None or not self._has_one_operand(line):
            return
        if self._is_read_behind(number):
            self._keep(line)
        target = self._expressions.target(line.operands[0])
        if target is None or self._accumulator is None:
            return
        value = self._expressions.expression_as(_negated(self._accumulator, line), target.type)
        if value is not None:
            at = line.position.line
            self._made += enable.statements(value, lambda made: program.Assign(target, made, line=at), at)

    def _set(self, line: tree.IlInstruction, number: int) -> None:
        """S sets the operand if the accumulator is TRUE, and R resets it."""
        if self._needed(line) is None or not self._has_one_operand(line):
            return
        if self._is_read_behind(number):
            self._keep(line)
        condition = self._condition(line)
        target = self._expressions.target(line.operands[0])
        if target is None or condition is None:
            return
        if target.type is not Elementary.BOOL:
            shown = f"{text(line.operands[0])} is {a(target.type)}"
            self._context.say(line.operands[0], shown, f"a BOOL behind {line.operator}")
            return
        value = program.Constant(line.operator == "S", Elementary.BOOL)
        at = line.position.line
        self._made.append(program.If(condition, [program.Assign(target, value, line=at)], line=at))

    def _has_one_operand(self, line: tree.IlInstruction) -> bool:
        if len(line.operands) == 1:
            return True
        self._context.say(line, f"{line.operator} has {_count(line)}", "one variable")
        return False

    def _is_read_behind(self, number: int) -> bool:
        return self._list.reads(number + 1, self._keys)

    def _condition(self, line: tree.IlInstruction, is_negated: bool = False) -> Expression | None:
        """Return the accumulator as a BOOL; None after a message."""
        value = self._needed(line)
        if value is None:
            return None
        if is_negated:
            value = tree.Unary("NOT", value, position=line.position)
        return self._expressions.expression_as(value, Elementary.BOOL)

    # ---- jumps and calls

    def _label(self, line: tree.IlInstruction, number: int) -> None:
        name = self._context.key(line.label)
        if self._list.is_operand:
            self._context.say(line, "a label is in brackets", "a label in front of the operator with the bracket")
            return
        if self._list.labels.get(name) != number:
            return
        if self._list.reads(number, self._keys):
            self._hand_over(name, line)
            self._become(self._at_labels.get(name))
        else:
            self._become(None)
            self._is_lost = False
        self._size = 0
        self._made.append(program.Label(name, line=line.position.line))

    def _hand_over(self, label: str, line: tree.IlInstruction) -> None:
        """Store the accumulator in the variable of a label."""
        if self._accumulator is None:
            return
        value = self._expressions.expression(self._accumulator)
        if value is None:
            return
        if label not in self._at_labels:
            self._at_labels[label] = self._variable(_typed(value), line)
        name = self._at_labels[label]
        variable = self._context.names[self._context.key(name.text)]
        self._assign(name, value, variable.type, line)

    def _jump(self, line: tree.IlInstruction, number: int) -> None:
        label = line.operands[0] if line.operands else None
        if not isinstance(label, tree.Name) or self._list.is_operand:
            self._context.say(line, "JMP is in brackets" if label else "JMP has no label", "JMP label")
            return
        name = self._keys.get(label.text, "")
        if name not in self._list.labels:
            hint = self._context.project.reports.closest(label.text, self._list.labels)
            self._context.say(label, f"there is no label {label.text}", f"a line {label.text}: in the same body", hint)
            return
        if line.is_conditional and self._is_read_behind(number):
            self._keep(line)
        if self._list.reads(self._list.labels[name], self._keys):
            if line.is_conditional:
                self._keep(line)
            self._hand_over(name, line)
        condition = self._condition(line, line.is_negated) if line.is_conditional else None
        if condition is not None or not line.is_conditional:
            self._made.append(program.Jump(name, condition, line=line.position.line))
        if not line.is_conditional:
            self._become(None)
            self._is_lost = False

    def _call(self, line: tree.IlInstruction, number: int) -> None:
        call = line.operands[0] if line.operands else None
        if not isinstance(call, tree.Call):
            self._context.say(line, "CAL has no operand", "an instance, a program or an action")
            return
        if self._is_read_behind(number):
            self._keep(line)
        condition = self._condition(line, line.is_negated) if line.is_conditional else None
        made = blocks.call_statement(self._expressions, call, line.position.line)
        if not line.is_conditional:
            self._made += made
        elif condition is not None:
            self._made.append(program.If(condition, made, line=line.position.line))

    def _is_input(self, line: tree.IlInstruction) -> bool:
        """True for an operator that is an input of its operand, an instance of a function block: CU counter."""
        if not self._context.project.dialect.has_input_operators or line.operator.upper() not in _INPUTS:
            return False
        operand = line.operands[0] if len(line.operands) == 1 else None
        known = self._context.find(operand.text) if isinstance(operand, tree.Name) else None
        kind = known.type if isinstance(known, program.Variable) else None
        if not isinstance(kind, BlockType) or kind.pou is None:
            return False
        given = kind.pou.variables.get(self._context.key(line.operator))
        return given is not None and given.section is tree.Section.INPUT

    def _feed(self, line: tree.IlInstruction, number: int) -> None:
        """Call the instance with the accumulator as the input."""
        if self._needed(line) is None:
            return
        if self._is_read_behind(number):
            self._keep(line)
        if self._accumulator is not None:
            argument = tree.Argument(self._accumulator, line.operator, position=line.position)
            call = tree.Call(line.operands[0], (argument,), position=line.position)
            self._made += blocks.call_statement(self._expressions, call, line.position.line)

    def _return(self, line: tree.IlInstruction, number: int) -> None:
        back = program.Return(line=line.position.line)
        if not line.is_conditional:
            self._made.append(back)
            self._become(None)
            self._is_lost = False
            return
        if self._is_read_behind(number):
            self._keep(line)
        condition = self._condition(line, line.is_negated)
        if condition is not None:
            self._made.append(program.If(condition, [back], line=line.position.line))


_SPECIAL: Final = frozenset({"ADR", "SIZEOF", "XSIZEOF", "INDEXOF"})


def _negated(value: tree.Expression, line: tree.IlInstruction) -> tree.Expression:
    return tree.Unary("NOT", value, position=line.position) if line.is_negated else value


def _count(line: tree.IlInstruction) -> str:
    return "no operand" if not line.operands else f"{len(line.operands)} operands"


def _acts(line: tree.IlInstruction) -> bool:
    return (
        line.operator in _ACTING
        or line.operator.upper() in _INPUTS
        or any(_acts(inner) for inner in line.deferred or ())
    )


def _typed(value: Expression) -> Type:
    """Return the type of a variable for a value; a number without a type is an INT, a DINT or a REAL."""
    if type(value) is not Untyped:
        return value.type
    if value.is_real:
        return Elementary.REAL
    fits = Elementary.INT.low <= int(value.value) <= Elementary.INT.high
    return Elementary.INT if fits else Elementary.DINT
