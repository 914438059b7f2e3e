"""ARP expressions as lines of Python with the checks in line.

`value` and `bit` return an atom, a name or an element or a literal, after they have added the lines that compute it:
three-address code costs CPython no more than nested brackets, and never nests deeper than its parser allows.  Reading
has no side effect but warnings, so an atom may stand behind lines that were added after it.
"""

from typing import Final

from fieldrig_devices.arp.fixed import LIMIT, SCALE
from fieldrig_devices.arp.language.bits import can_be_bit, is_bit
from fieldrig_devices.arp.language.instructions import CONSTANTS
from fieldrig_devices.arp.language.tree import (
    Binary,
    Constant,
    Direct,
    Expression,
    Function,
    Indexed,
    Name,
    Number,
    System,
    Unary,
)

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
    """The lines of one instruction."""

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

    def value(self, one: Expression) -> str:
        """An atom with the raw integer."""
        if is_bit(one):
            return self._new(f"{self.bit(one)} * {SCALE}")
        match one:
            case Number(raw):
                return str(raw) if raw >= 0 else f"({raw})"
            case Constant(word):
                return str(CONSTANTS[word])
            case Direct(letter, number):
                return f"{letter}[{number}]"
            case Indexed():
                return self._element(one)
            case System():
                return self._new(_reader(one))
            case Unary(sign, operand):
                return self._unary(sign, operand)
            case Function(word, operand):
                return self._new(f"{FUNCTIONS[word]}({self.value(operand)})")
            case Binary(sign, left, right):
                return self._binary(sign, left, right)
            case Name():
                raise AssertionError(f"{one.text} is not resolved")

    def index(self, one: Direct | Indexed) -> str:
        """An atom with the number of the element, not yet held against its range."""
        if isinstance(one, Direct):
            return str(one.number)
        assert isinstance(one.index, Direct)
        return self._new(f"V[{one.index.number}] // {SCALE}")  # below 0 it is no index either way

    def _element(self, one: Indexed) -> str:
        index = self.index(one)
        return self._new(f"{one.letter}[{index}] if {inside(one.letter, index)} else wrong_index()")

    def _unary(self, sign: str, operand: Expression) -> str:
        value = self.value(operand)
        if sign == "!":
            return self._new(f"~{value}")
        return value if sign == "+" else self._checked(self._new(f"-{value}"))

    def _binary(self, sign: str, left: Expression, right: Expression) -> str:
        if sign == "/" and isinstance(right, Number) and right.raw > 0 and right.raw % SCALE == 0:
            name = self._new(self.value(left))
            return self._truncated(name, right.raw // SCALE)
        if sign == "*" and isinstance(right, Number) and right.raw % SCALE == 0:
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
        """Truncated division of two temporaries, where Python's own rounds toward minus infinity."""
        result = f"{a} {sign} {b} if ({a} >= 0) == ({b} > 0) else -(-{a} {sign} {b})"
        self.lines.append(f"{a} = ({result}) if {b} else divided_by_zero()")
        return self._checked(a)

    # ---- bits

    def bit(self, one: Expression) -> str:
        """An atom with 0 or 1, of an expression that can be a bit."""
        match one:
            case Number(raw):
                return str(raw // SCALE)
            case Constant(word):
                return str(CONSTANTS[word] // SCALE)
            case Direct(letter, number):
                return f"{letter}[{number}]"
            case Indexed():
                return self._element(one)
            case Unary(_, operand):
                return self._new(f"{self.bit(operand)} ^ 1")
            case Binary(sign, left, right):
                a, b = self.bit(left), self.bit(right)
                return self._new(f"{a} {sign} {b}")
        raise AssertionError(f"{one} is no bit")

    def condition(self, left: Expression, relation: str, right: Expression) -> str:
        if (is_bit(left) and can_be_bit(right)) or (is_bit(right) and can_be_bit(left)):
            a, b = self.bit(left), self.bit(right)
            if b in ("0", "1") and relation in ("=", "<>"):
                return a if (b == "1") is (relation == "=") else f"not {a}"
        else:
            a, b = self.value(left), self.value(right)
        return f"{a} {COMPARE[relation]} {b}"


def inside(letter: str, index: str) -> str:
    """The test whether a computed number is that of an element."""
    if letter in ("I", "O"):
        return f"{index} in terminals"
    return f"0 < {index} <= {1000 if letter == 'V' else 320}"


def _reader(one: System) -> str:
    if one.word != "@PAR":
        return f"{READERS[one.word]}({one.number})"
    return f"general({one.index})" if one.number is None else f"parameter({one.number}, {one.index})"
