"""Emit ARP expressions as lines of Python with inline checks.

`value` and `bit` add the lines that compute an expression and return an atom: a name, an element or a literal.
Three-address code costs CPython no more than nested brackets and never exceeds the nesting depth of its parser.
Reading has no side effect apart from warnings, so an atom may follow lines that were added after it.
"""

from typing import Final

from fieldrig_devices.arp.fixed import LIMIT, SCALE
from fieldrig_devices.arp.language import tree
from fieldrig_devices.arp.language.bits import can_be_bit, is_bit
from fieldrig_devices.arp.language.instructions import CONSTANTS

INDENT: Final = "    "
COMPARE: Final = {"=": "==", "<>": "!=", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
FUNCTIONS: Final = {"SQR": "root", "INT": "integer", "SEN": "sine", "COS": "cosine"}
SHIFTS: Final = {"<<": "shifted_left", ">>": "shifted_right"}
READERS: Final = {
    "@POS": "position",
    "#VEL": "speed",
    "#LQOSP": "latch_rising",
    "#LQOSN": "latch_falling",
    "@FLAG": "flag_word",
    "@OUT": "output_word",
    "#INP": "input_word",
}


class Emitter:
    """Collects the lines of one instruction."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._temporaries = 0

    def _new(self, text: str) -> str:
        name = f"t{self._temporaries}"
        self._temporaries += 1
        self.lines.append(f"{name} = {text}")
        return name

    def _checked(self, name: str) -> str:
        self.lines += [f"if not -{LIMIT} <= {name} <= {LIMIT}:", f"{INDENT}{name} = saturated({name})"]
        return name

    # ---- numbers

    def value(self, expression: tree.Expression) -> str:
        """Add the lines that compute a number, and return an atom with its raw integer."""
        if is_bit(expression):
            return self._new(f"{self.bit(expression)} * {SCALE}")
        match expression:
            case tree.Number(raw):
                return str(raw) if raw >= 0 else f"({raw})"
            case tree.Constant(word):
                return str(CONSTANTS[word])
            case tree.Direct(letter, number):
                return f"{letter}[{number}]"
            case tree.Indexed():
                return self._element(expression)
            case tree.System():
                return self._new(_reader(expression))
            case tree.Unary(sign, operand):
                return self._unary(sign, operand)
            case tree.Function(word, operand):
                return self._new(f"{FUNCTIONS[word]}({self.value(operand)})")
            case tree.Binary(sign, left, right):
                return self._binary(sign, left, right)
            case tree.Name():
                raise AssertionError(f"{expression.text} is not resolved")

    def index(self, resource: tree.Direct | tree.Indexed) -> str:
        """Return an atom with the number of the element, without checking its range."""
        if isinstance(resource, tree.Direct):
            return str(resource.number)
        assert isinstance(resource.index, tree.Direct)
        return self._new(f"V[{resource.index.number}] // {SCALE}")  # negative values are invalid either way

    def _element(self, resource: tree.Indexed) -> str:
        index = self.index(resource)
        return self._new(f"{resource.letter}[{index}] if {inside(resource.letter, index)} else wrong_index()")

    def _unary(self, sign: str, operand: tree.Expression) -> str:
        value = self.value(operand)
        if sign == "!":
            return self._new(f"~{value}")
        return value if sign == "+" else self._checked(self._new(f"-{value}"))

    def _binary(self, sign: str, left: tree.Expression, right: tree.Expression) -> str:
        if sign == "/" and isinstance(right, tree.Number) and right.raw > 0 and right.raw % SCALE == 0:
            name = self._new(self.value(left))
            return self._truncated(name, right.raw // SCALE)
        if sign == "*" and isinstance(right, tree.Number) and right.raw % SCALE == 0:
            return self._checked(self._new(f"{self.value(left)} * {right.raw // SCALE}"))
        a, b = self.value(left), self.value(right)
        match sign:
            case "+" | "-":
                return self._checked(self._new(f"{a} {sign} {b}"))
            case "*":
                return self._truncated(self._new(f"{a} * {b}"), SCALE)
            case "/":
                return self._divided(self._new(f"{a} * {SCALE}"), "//", self._new(b))
            case "%":
                return self._divided(self._new(a), "%", self._new(b))
            case "<<" | ">>":
                return self._new(f"{SHIFTS[sign]}({a}, {b})")
        return self._new(f"{a} {sign} {b}")  # & | ^ stay within 32 bits

    def _truncated(self, name: str, divisor: int) -> str:
        if divisor != 1:
            self.lines.append(f"{name} = {name} // {divisor} if {name} >= 0 else -(-{name} // {divisor})")
        return self._checked(name)

    def _divided(self, a: str, sign: str, b: str) -> str:
        """Emit a truncated division of two temporaries; Python's own rounds toward minus infinity."""
        result = f"{a} {sign} {b} if ({a} >= 0) == ({b} > 0) else -(-{a} {sign} {b})"
        self.lines.append(f"{a} = ({result}) if {b} else divided_by_zero()")
        return self._checked(a)

    # ---- bits

    def bit(self, expression: tree.Expression) -> str:
        """Add the lines that compute a bit, and return an atom with 0 or 1.

        The expression must be able to be a bit.
        """
        match expression:
            case tree.Number(raw):
                return str(raw // SCALE)
            case tree.Constant(word):
                return str(CONSTANTS[word] // SCALE)
            case tree.Direct(letter, number):
                return f"{letter}[{number}]"
            case tree.Indexed():
                return self._element(expression)
            case tree.Unary(_, operand):
                return self._new(f"{self.bit(operand)} ^ 1")
            case tree.Binary(sign, left, right):
                a, b = self.bit(left), self.bit(right)
                return self._new(f"{a} {sign} {b}")
        raise AssertionError(f"{expression} is no bit")

    def condition(self, left: tree.Expression, relation: str, right: tree.Expression) -> str:
        if (is_bit(left) and can_be_bit(right)) or (is_bit(right) and can_be_bit(left)):
            a, b = self.bit(left), self.bit(right)
            if b in ("0", "1") and relation in ("=", "<>"):
                return a if (b == "1") is (relation == "=") else f"not {a}"
        else:
            a, b = self.value(left), self.value(right)
        return f"{a} {COMPARE[relation]} {b}"


def inside(letter: str, index: str) -> str:
    """Condition that is true if a computed number is the number of an element."""
    if letter in ("I", "O"):
        return f"{index} in terminals"
    return f"0 < {index} <= {1000 if letter == 'V' else 320}"


def _reader(system: tree.System) -> str:
    if system.word != "@PAR":
        return f"{READERS[system.word]}({system.number})"
    return f"general({system.index})" if system.number is None else f"parameter({system.number}, {system.index})"
