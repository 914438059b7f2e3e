"""Statements of Structured Text and lines of Instruction List as text."""

import re
from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.instructions import CONDITIONAL, SPELLINGS
from fieldrig_devices.iec.printer.expressions import expression_text as text_of
from fieldrig_devices.iec.printer.lines import Lines

LONGEST_LINE = 120
_WORD: Final = re.compile(r"[^\W\d]\w*")


def statements(lines: Lines, block: Sequence[tree.AnyStatement]) -> None:
    for number, statement in enumerate(block):
        lines.front(statement, number == 0)
        _statement(lines, statement)
        lines.behind(statement)


def _block(lines: Lines, block: Sequence[tree.AnyStatement]) -> None:
    with lines.indented():
        statements(lines, block)


def _in_brackets(node: tree.Expression) -> str:
    made = text_of(node)
    return made if isinstance(node, tree.Assigned) else f"({made})"


def _statement(lines: Lines, statement: tree.AnyStatement) -> None:
    match statement:
        case tree.Assign(target, value, kind, others):
            parts = [text_of(part) for part in (target, *others, value)]
            lines.add(f"{f' {kind.value} '.join(parts)};")
        case tree.CallStatement(call):
            _call(lines, call)
        case tree.Return(condition):
            lines.add("RETURN;" if condition is None else f"RETURN {_in_brackets(condition)};")
        case tree.Exit():
            lines.add("EXIT;")
        case tree.Continue():
            lines.add("CONTINUE;")
        case tree.Empty():
            lines.add(";")
        case tree.Label(name):
            lines.add(f"{name}:")
        case tree.Jump(label):
            lines.add(f"JMP {label};")
        case tree.If():
            _if(lines, statement)
        case tree.Case():
            _case(lines, statement)
        case tree.For(variable, first, last, step, body):
            by = f" BY {text_of(step)}" if step is not None else ""
            lines.add(f"FOR {text_of(variable)} := {text_of(first)} TO {text_of(last)}{by} DO")
            _block(lines, body)
            lines.add("END_FOR;")
        case tree.While(condition, body):
            lines.add(f"WHILE {text_of(condition)} DO")
            _block(lines, body)
            lines.add("END_WHILE;")
        case tree.Repeat(body, until):
            lines.add("REPEAT")
            _block(lines, body)
            lines.add(f"UNTIL {text_of(until)}")
            lines.add("END_REPEAT;")
        case tree.Try():
            _try(lines, statement)


def _call(lines: Lines, call: tree.Call) -> None:
    """Add a call, with an argument in each line if it does not fit into one."""
    whole = f"{text_of(call)};"
    if len(lines.indentation) + len(whole) <= LONGEST_LINE or len(call.arguments) < 2:
        lines.add(whole)
        return
    parts = [text_of(tree.Call(tree.Name(""), (argument,)))[1:-1] for argument in call.arguments]
    lines.add(f"{text_of(tree.Call(call.called, ()))[:-1]}")
    with lines.indented():
        for part in parts[:-1]:
            lines.add(f"{part},")
        lines.add(f"{parts[-1]}")
    lines.add(");")


def _try(lines: Lines, statement: tree.Try) -> None:
    lines.add("__TRY")
    _block(lines, statement.body)
    if statement.caught is not None:
        lines.add("__CATCH" if statement.code is None else f"__CATCH ({text_of(statement.code)})")
        _block(lines, statement.caught)
    if statement.final is not None:
        lines.add("__FINALLY")
        _block(lines, statement.final)
    lines.add("__ENDTRY;")


def _if(lines: Lines, statement: tree.If) -> None:
    for number, branch in enumerate(statement.branches):
        lines.add(f"{'ELSIF' if number else 'IF'} {text_of(branch.condition)} THEN")
        if branch.remark:
            lines.append(f" {branch.remark}")
        _block(lines, branch.body)
    if statement.otherwise is not None:
        lines.add("ELSE")
        _block(lines, statement.otherwise)
    lines.add("END_IF;")


def _case(lines: Lines, statement: tree.Case) -> None:
    lines.add(f"CASE {text_of(statement.selector)} OF")
    with lines.indented():
        for number, branch in enumerate(statement.branches):
            if branch.is_spaced and number:
                lines.add("")
            lines.comments(branch.comments)
            lines.add(f"{', '.join(map(label_text, branch.labels))}:")
            if branch.remark:
                lines.append(f" {branch.remark}")
            _block(lines, branch.body)
    if statement.otherwise is not None:
        lines.add("ELSE")
        _block(lines, statement.otherwise)
    lines.add("END_CASE;")


def label_text(label: tree.Expression | tree.Range) -> str:
    if isinstance(label, tree.Range):
        return f"{text_of(label.low)}..{text_of(label.high)}"
    return text_of(label)


# ---- Instruction List


def instructions(lines: Lines, block: Sequence[tree.IlInstruction]) -> None:
    """Add lines of IL; labels stand one level to the left of them."""
    for number, instruction in enumerate(block):
        lines.front(instruction, number == 0)
        if instruction.label:
            lines.add(f"{instruction.label}:")
        if instruction.operator:
            with lines.indented():
                _instruction(lines, instruction)
        lines.behind(instruction)


def _instruction(lines: Lines, instruction: tree.IlInstruction) -> None:
    operator = instruction.operator
    if operator in CONDITIONAL and instruction.is_conditional:
        operator += "C"
    if instruction.is_negated:
        operator += "N"
    if instruction.deferred is None:
        operands = ", ".join(map(_operand, instruction.operands))
        lines.add(f"{operator} {operands}".rstrip())
        return
    first, *rest = instruction.deferred or (None,)
    if first is not None and _is_load(first):
        lines.add(f"{operator} ( {_operand(first.operands[0])}")
        if first.remark:
            lines.append(f" {first.remark}")
        lines.comments(first.after)
        instructions(lines, rest)
    else:
        lines.add(f"{operator} (")
        instructions(lines, instruction.deferred)
    lines.add(")")


def _operand(operand: tree.Expression) -> str:
    text = text_of(operand)
    return f"({text})" if isinstance(operand, tree.Binary) else text


def _is_load(first: tree.IlInstruction) -> bool:
    """True if the instruction behind a bracket is a plain load, whose operand is written alone.

    A variable with the name of an operator, such as R, would be read as that.
    """
    is_plain = first.operator == "LD" and not first.is_negated and not first.label and not first.comments
    if not is_plain or len(first.operands) != 1 or first.deferred is not None:
        return False
    word = _WORD.match(text_of(first.operands[0]))
    return word is None or word[0].upper() not in SPELLINGS
