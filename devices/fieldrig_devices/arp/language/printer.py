"""An ARP program as text again: what `parser` reads back to the same tree."""

from collections.abc import Iterator

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.language.expression import PRECEDENCE
from fieldrig_devices.arp.language.tree import (
    Argument,
    Assign,
    Binary,
    BitCondition,
    Call,
    Command,
    Constant,
    Direct,
    Equ,
    Function,
    Goto,
    If,
    Indexed,
    Line,
    Mode,
    Name,
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


def program_text(program: Program) -> str:
    lines = [line_text(line) for line in program.outside]
    for routine in program.routines:
        lines += (text for _, text in routine_lines(routine))
    return "".join(f"{line}\n" for line in lines)


def routine_lines(routine: Routine) -> Iterator[tuple[int, str]]:
    """The lines of a routine with the numbers they have in the source."""
    suffix = "A" if routine.is_interrupt else ""
    yield routine.number, f"BEG{suffix} {routine.name}"
    for line in routine.lines:
        yield line.number, line_text(line)
    yield routine.end_number, f"END{suffix}"


def line_text(line: Line) -> str:
    label = f"{line.label}:" if line.label is not None else ""
    content = line.content
    if content is None:
        return label
    text = f"{content.name} EQU {argument_text(content.meaning)}" if isinstance(content, Equ) else _statement(content)
    return f"{label} {text}" if label else text


def argument_text(one: Argument) -> str:
    """Any value of an instruction."""
    match one:
        case Number(raw, True):
            return f"H{raw & 0xFFFF_FFFF:08X}"
        case Number(raw):
            return fixed.to_text(raw)
        case Constant(word) | Name(word) | Mode(word):
            return word
        case Direct(letter, number):
            return f"{letter}{number}"
        case Indexed(letter, index):
            return f"{letter}[{argument_text(index)}]"
        case System(word, number, None):
            return f"{word}{number}"
        case System(word, number, index):
            return f"{word}{number if number is not None else ''}[{index}]"
        case Text(text):
            return f'"{text}"'
        case Function(word, operand):
            return f"{word}({argument_text(operand)})"
        case Unary(sign, operand):
            text = argument_text(operand)
            return f"{sign}({text})" if isinstance(operand, Unary | Binary) else f"{sign}{text}"
        case Binary(sign, left, right):
            own = PRECEDENCE[sign]
            return f"{_operand(left, own)} {sign} {_operand(right, own + 1)}"


def _operand(one: Argument, lowest: int) -> str:
    text = argument_text(one)
    return f"({text})" if isinstance(one, Binary) and PRECEDENCE[one.sign] < lowest else text


def _statement(statement: Statement) -> str:
    match statement:
        case Assign(target, sign, value):
            text = _read(value) if isinstance(value, Read) else argument_text(value)
            return f"{argument_text(target)} {sign} {text}"
        case Goto(label, is_bare):
            return label if is_bare else f"GOTO {label}"
        case Call(routine):
            return f"CALL {routine}"
        case If(left, relation, right, then):
            return f"IF {argument_text(left)} {relation} {argument_text(right)}, {_statement(then)}"
        case OnEvent(number, enable, condition, routine):
            return f"ON{number} {argument_text(enable)} & ({_condition(condition)}) {routine}"
        case Command(word, arguments, number):
            head = f"{word}{number}" if number is not None else word
            return f"{head} {', '.join(map(argument_text, arguments))}".rstrip()


def _read(read: Read) -> str:
    return read.word if read.number is None else f"{read.word} {argument_text(read.number)}"


def _condition(condition: BitCondition | PositionCondition) -> str:
    match condition:
        case BitCondition(edge, bit):
            return f"{edge}{argument_text(bit)}"
        case PositionCondition(axis, relation, variable):
            return f"{argument_text(axis)} {relation} {argument_text(variable)}"
