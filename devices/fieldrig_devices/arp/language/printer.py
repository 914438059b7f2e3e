"""Print an ARP program as text that `parser` reads back to the same tree."""

from collections.abc import Iterator

from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.language import tree
from fieldrig_devices.arp.language.expression import PRECEDENCE


def routine_lines(routine: tree.Routine) -> Iterator[tuple[int, str]]:
    """The lines of a routine with their numbers in the source."""
    suffix = "A" if routine.is_interrupt else ""
    yield routine.number, f"BEG{suffix} {routine.name}"
    for line in routine.lines:
        yield line.number, line_text(line)
    yield routine.end_number, f"END{suffix}"


def line_text(line: tree.Line) -> str:
    label = f"{line.label}:" if line.label is not None else ""
    content = line.content
    if content is None:
        return label
    text = (
        f"{content.name} EQU {argument_text(content.meaning)}" if isinstance(content, tree.Equ) else _statement(content)
    )
    return f"{label} {text}" if label else text


def argument_text(argument: tree.Argument) -> str:
    """Print any value of an instruction."""
    match argument:
        case tree.Number(raw, True):
            return f"H{raw & 0xFFFF_FFFF:08X}"
        case tree.Number(raw):
            return fixed.to_text(raw)
        case tree.Constant(word) | tree.Name(word) | tree.Mode(word):
            return word
        case tree.Direct(letter, number):
            return f"{letter}{number}"
        case tree.Indexed(letter, index):
            return f"{letter}[{argument_text(index)}]"
        case tree.System(word, number, None):
            return f"{word}{number}"
        case tree.System(word, number, index):
            return f"{word}{number if number is not None else ''}[{index}]"
        case tree.Text(text):
            return f'"{text}"'
        case tree.Function(word, operand):
            return f"{word}({argument_text(operand)})"
        case tree.Unary(sign, operand):
            text = argument_text(operand)
            return f"{sign}({text})" if isinstance(operand, tree.Unary | tree.Binary) else f"{sign}{text}"
        case tree.Binary(sign, left, right):
            own = PRECEDENCE[sign]
            return f"{_operand(left, own)} {sign} {_operand(right, own + 1)}"


def _operand(operand: tree.Argument, lowest: int) -> str:
    text = argument_text(operand)
    return f"({text})" if isinstance(operand, tree.Binary) and PRECEDENCE[operand.sign] < lowest else text


def _statement(statement: tree.Statement) -> str:
    match statement:
        case tree.Assign(target, sign, value):
            text = _read(value) if isinstance(value, tree.Read) else argument_text(value)
            return f"{argument_text(target)} {sign} {text}"
        case tree.Goto(label, is_bare):
            return label if is_bare else f"GOTO {label}"
        case tree.Call(routine):
            return f"CALL {routine}"
        case tree.If(left, relation, right, then):
            return f"IF {argument_text(left)} {relation} {argument_text(right)}, {_statement(then)}"
        case tree.OnEvent(number, enable, condition, routine):
            return f"ON{number} {argument_text(enable)} & ({_condition(condition)}) {routine}"
        case tree.Command(word, arguments, number):
            head = f"{word}{number}" if number is not None else word
            return f"{head} {', '.join(map(argument_text, arguments))}".rstrip()


def _read(read: tree.Read) -> str:
    return read.word if read.number is None else f"{read.word} {argument_text(read.number)}"


def _condition(condition: tree.BitCondition | tree.PositionCondition) -> str:
    match condition:
        case tree.BitCondition(edge, bit):
            return f"{edge}{argument_text(bit)}"
        case tree.PositionCondition(axis, relation, variable):
            return f"{argument_text(axis)} {relation} {argument_text(variable)}"
