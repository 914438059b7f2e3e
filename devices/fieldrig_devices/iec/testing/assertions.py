"""Checks the statements of tests, and makes calls of native functions of them.

What an assertion compares is computed once, into hidden variables, so that both values can be shown when it fails.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.printer import expression_text
from fieldrig_devices.iec.program import (
    COMPARISONS,
    AnyStatement,
    Assign,
    Binary,
    CallFunction,
    Constant,
    Convert,
    Evaluate,
    Expression,
    Load,
    Loop,
    Operator,
    Place,
    Pou,
    Unary,
    Variable,
)
from fieldrig_devices.iec.testing import natives
from fieldrig_devices.iec.testing.arguments import matched
from fieldrig_devices.iec.testing.mocks import Mock, Mocks
from fieldrig_devices.iec.testing.natives import call_of, cell
from fieldrig_devices.iec.testing.reads import variables_of
from fieldrig_devices.iec.testing.texts import LONGEST
from fieldrig_devices.iec.testing.words import MESSAGE, WORDS, Word
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import ArrayType, BlockType, EnumType, StringType, StructType, Type

_OWN: Final = ("THIS", "SUPER")
DEEPEST: Final = 30
"""Conditions within conditions that are taken apart."""
TEXT: Final = StringType(255)
BOOL: Final = Elementary.BOOL
Given = Mapping[str, tree.Expression]


@dataclass(slots=True)
class Assertion:
    """One statement of a test."""

    word: str
    kind: Word
    file: str
    line: int
    source: str
    """The text of what is judged."""
    type: Type = BOOL
    """The type of both values, or that of the time."""
    shown: Type | None = None
    """The enumeration whose names are shown; None if the type says it all."""
    message: str = ""
    """A constant message."""
    other: str = ""
    """A second text: what a fault is."""
    names: tuple[str, ...] = ()
    """The paths of variables in the statement, for the signals around a failure."""
    operands: tuple[tuple[str, Type], ...] = ()
    """The texts and types of what a condition is made of; no text for a constant."""
    reads: frozenset[str] | None = None
    """The variables on which a condition over time depends, in small letters; None if it may be anything."""


class Assertions:
    """All statements of tests of one compilation."""

    def __init__(self, mocks: Mocks) -> None:
        self.all: list[Assertion] = []
        self._mocks = mocks
        self._natives: dict[str, Pou] = {name: natives.native_pou(name) for name in natives.NAMES}

    def begin(self, project: Project) -> None:
        project.pous.update({name: pou for name, pou in self._natives.items() if name != natives.MOCKED})

    def statement(
        self, checker: Checker, name: str, word: Word, node: tree.Call, line: int
    ) -> list[AnyStatement] | None:
        given = matched(checker, name, word, node)
        if given is None:
            return []
        shown = [text(given[part]) for part in word.parameters if part in given]
        names = tuple(dict.fromkeys(path for part in given.values() for path in paths(part)))
        made = Assertion(name, word, checker.context.file, line, ", ".join(shown), names=names)
        one = _One(self, checker, made, len(self.all), given)
        self.all.append(made)
        return _RULES.get(name, _One.compared if word.operator is not None else _One.condition)(one)

    def calls(self, checker: Checker, node: tree.Call) -> Expression | None:
        """Return how often a mock was called."""
        given = matched(checker, "MOCK_CALLS", Word(("mock",), has_message=False), node)
        mock = self.mock(checker, given["mock"]) if given is not None else None
        return Load(mock[0].place(mock[0].calls, mock[1])) if mock is not None else None

    def mock(self, checker: Checker, node: tree.Expression) -> tuple[Mock, Place | None] | None:
        """Return the mock of a function, a method or an instance, with the instance; None after a message."""
        named = checker.context.project.find(checker.context.key(text(node)))
        meaning = named if isinstance(named, Pou) and checker.context.find(text(node)) is named else None
        pou, instance = self._method(checker, node) if meaning is None else (meaning, None)
        is_standard = isinstance(node, tree.Name) and intrinsics.is_standard(node.text)
        if pou is None and is_standard and checker.context.find(text(node)) is None:
            what = f"{text(node)} is a standard function, which cannot be mocked"
            checker.context.say(node, what, "a function of the program")
            return None
        if pou is None:
            instance = checker.place(node)
            if instance is None:
                return None
            pou = instance.type.pou if isinstance(instance.type, BlockType) else None
        elif pou.instance is not None:
            instance = cell(pou.instance)
        if pou is None or pou.is_native or not self._mocks.may_be(pou):
            checker.context.say(
                node, f"{text(node)} cannot be mocked", "a function, or an instance of a block or its method"
            )
            return None
        if instance is None and pou.kind is not PouKind.FUNCTION:
            hint = f"an instance of it is a variable: x : {pou.name};"
            checker.context.say(node, f"{pou.name} is a type", "an instance of the block", hint)
            return None
        return self._mocks.of(pou), instance

    @staticmethod
    def _method(checker: Checker, node: tree.Expression) -> tuple[Pou | None, Place | None]:
        """Return a method or a property of an instance, with the instance; None for anything else."""
        if not isinstance(node, tree.Member):
            return None, None
        named = checker.context.find(node.of.text) if isinstance(node.of, tree.Name) else None
        owner: Place | None
        if isinstance(named, Pou):
            owner = cell(named.instance) if named.instance is not None else None
        else:
            owner = checker.place(node.of)
        if owner is None or not isinstance(owner.type, BlockType) or owner.type.pou is None:
            return None, None
        method = owner.type.pou.methods.get(checker.context.key(node.name))
        return method, owner if method is not None else None

    def call(self, native: str, number: int, *places: Place | None) -> CallFunction:
        return call_of(self._natives[native], number, *places)


class _One:
    """One statement while it is checked."""

    def __init__(self, whole: Assertions, checker: Checker, made: Assertion, number: int, given: Given) -> None:
        self._whole, self._checker, self._made, self._number, self._given = whole, checker, made, number, given
        self._before: list[AnyStatement] = []

    # ---- parts

    def _kept(self, value: Expression | None, kind: Type) -> Place | None:
        """Compute a value into a hidden variable."""
        if value is None:
            return None
        variable: Variable = self._checker.context.hidden("tested", kind)
        self._before.append(Assign(cell(variable), value, line=self._made.line))
        return cell(variable)

    def _bool(self, parameter: str) -> Place | None:
        return self._kept(self._checker.expression_as(self._given[parameter], BOOL), BOOL)

    def _text(self, parameter: str) -> Place | None:
        node = self._given.get(parameter)
        if node is None:
            return None
        if isinstance(node, tree.Literal) and isinstance(node.value, str):
            if parameter == MESSAGE:
                self._made.message = node.value
                return None
            return self._kept(self._checker.expression_as(node, TEXT), TEXT)
        return self._kept(self._checker.expression_as(node, TEXT), TEXT)

    def _time(self) -> Place | None:
        """Compute a duration, which is a time or a number of nanoseconds."""
        node = self._given["time"]
        value = self._checker.expression(node)
        if value is None:
            return None
        kind = value.type
        if isinstance(value, Untyped):
            value = Constant(value.value, kind)
        is_time = isinstance(kind, Elementary) and (kind.family is Family.TIME or kind.is_integer)
        if not is_time:
            what = f"the time {text(node)} is {a(kind)}"
            self._checker.context.say(node, what, "a TIME such as T#100ms, or nanoseconds")
            return None
        self._made.type = kind
        return self._kept(value, kind)

    def _call(self, native: str, *places: Place | None) -> list[AnyStatement]:
        call = self._whole.call(native, self._number, *places)
        return [*self._before, Evaluate(call, line=self._made.line)]

    # ---- statements

    def condition(self) -> list[AnyStatement]:
        """ASSERT_TRUE, ASSERT_FALSE."""
        value = self._checker.expression_as(self._given["condition"], BOOL)
        if value is None:
            return []
        parts: list[tuple[Place, tuple[str, Type]]] = []
        value = self._apart(value, self._given["condition"], parts)
        judged, message = self._kept(value, BOOL), self._text(MESSAGE)
        self._made.operands = tuple(operand for _, operand in parts)
        places = [place for place, _ in parts]
        for first in range(0, len(places), natives.MOST_ADDRESSES):
            some = places[first : first + natives.MOST_ADDRESSES]
            self._before.append(Evaluate(self._whole.call(natives.NOTE, self._number, *some), line=self._made.line))
        return self._call(natives.JUDGE, judged, None, None, message)

    def _apart(
        self, value: Expression, node: tree.Expression, parts: list[tuple[Place, tuple[str, Type]]], depth: int = 0
    ) -> Expression:
        """Return a condition over hidden variables, into which its operands are computed first, to be shown.

        All of them are always computed, apart from those behind AND_THEN and OR_ELSE, which stay as they are.
        """
        if depth > DEEPEST:
            return value
        if isinstance(value, Unary) and isinstance(node, tree.Unary):
            inner = self._apart(value.operand, node.operand, parts, depth + 1)
            return Unary(value.operator, inner, value.type)
        if not isinstance(value, Binary) or not isinstance(node, tree.Binary):
            return self._shown(value, node, parts) if depth and value.type == BOOL else value
        left, right = value.left, value.right
        if value.operator in COMPARISONS:
            if not all(isinstance(side.type, Elementary | StringType | EnumType) for side in (left, right)):
                return value
        elif value.type == BOOL:
            left = self._apart(left, node.left, parts, depth + 1)
            if value.operator in (Operator.AND_THEN, Operator.OR_ELSE):
                return Binary(value.operator, left, right, value.type)
            return Binary(value.operator, left, self._apart(right, node.right, parts, depth + 1), value.type)
        left = self._shown(left, node.left, parts)
        return Binary(value.operator, left, self._shown(right, node.right, parts), value.type)

    def _shown(
        self, value: Expression, node: tree.Expression, parts: list[tuple[Place, tuple[str, Type]]]
    ) -> Expression:
        """Compute an operand into a hidden variable, and return what reads it; a constant stays as it is."""
        if isinstance(value, Constant):
            return value
        place = self._kept(value, value.type)
        assert place is not None
        parts.append((place, _operand(value, node)))
        return Load(place)

    def compared(self) -> list[AnyStatement]:
        """ASSERT_EQ and all that compare two values of one type."""
        sides = self._sides()
        if sides is None:
            return []
        kind = sides[0].type
        self._made.type = kind
        actual, expected = (self._kept(side, kind) for side in sides)
        tolerance = None
        if "tolerance" in self._given:
            tolerance = self._kept(self._checker.expression_as(self._given["tolerance"], kind), kind)
            if tolerance is None:
                return []
        message = self._text(MESSAGE)
        return self._call(natives.JUDGE, actual, expected, tolerance, message)

    def _sides(self) -> tuple[Expression, Expression] | None:
        """Return both values in one type; None after a message."""
        checker, operator = self._checker, self._made.kind.operator
        assert operator is not None
        nodes = self._given["actual"], self._given["expected"]
        actual = checker.expression(nodes[0])
        expected = checker.expression(nodes[1], None if actual is None else actual.type)
        if actual is None or expected is None:
            return None
        if isinstance(actual.type, StructType | ArrayType | BlockType):
            return self._whole_sides(actual, expected, nodes)
        if isinstance(actual.type, EnumType) and expected.type == actual.type:
            self._made.shown = actual.type
        shown = tree.Binary(operator.value, nodes[0], nodes[1], position=nodes[0].position)
        both = checker.operate(operator, actual, expected, shown)
        if isinstance(both, Binary):
            return _plain(both.left), _plain(both.right)
        return (_plain(actual), _plain(expected)) if both is not None else None

    def _whole_sides(
        self, actual: Expression, expected: Expression, nodes: tuple[tree.Expression, tree.Expression]
    ) -> tuple[Expression, Expression] | None:
        """Compare structures and arrays, for equality only."""
        say, kind = self._checker.context.say, actual.type
        if isinstance(kind, BlockType):
            say(nodes[0], f"{text(nodes[0])} is an instance of {kind}", "a variable of it")
        elif self._made.kind.operator not in (Operator.EQ, Operator.NE) or "tolerance" in self._given:
            say(nodes[0], f"{text(nodes[0])} is {a(kind)}", "ASSERT_EQ or ASSERT_NEQ")
        elif expected.type != kind:
            say(nodes[1], f"{text(nodes[1])} is {a(expected.type)}", str(kind))
        else:
            return actual, expected
        return None

    def fail(self) -> list[AnyStatement]:
        return self._call(natives.JUDGE, None, None, None, self._text(MESSAGE))

    def over_time(self) -> list[AnyStatement]:
        """ASSERT_WITHIN and its kin: the condition is computed again after everything that happens."""
        duration, message = self._time(), self._text(MESSAGE)
        begin = self._call(natives.BEGIN, duration)
        self._before = []
        condition = self._bool("condition")
        end = self._bool("end") if "end" in self._given else None
        if duration is None or condition is None or ("end" in self._given and end is None):
            return []
        computed = [variables_of(one.value) for one in self._before if isinstance(one, Assign)]
        known = [names for names in computed if names is not None]
        self._made.reads = frozenset().union(*known) if len(known) == len(self._before) else None
        line = self._made.line
        goes_on = cell(self._checker.context.hidden("again", BOOL))
        again = self._whole.call(natives.AGAIN, self._number, condition, end, None, message)
        body: list[AnyStatement] = [*self._before, Assign(goes_on, again, line=line)]
        until = self._checker.negate(Operator.NOT, Load(goes_on), self._given["condition"])
        return [*begin, Loop(body, until=until, line=line)]

    def wait(self) -> list[AnyStatement]:
        duration = self._time()
        return self._call(natives.WAIT, duration) if duration is not None else []

    def act(self) -> list[AnyStatement]:
        """PRINT, FAULT and CLEAR_FAULTS."""
        parts = [self._text(part) for part in (*self._made.kind.parameters, MESSAGE) if part in self._given]
        if self._made.message:
            parts = [self._kept(Constant(self._made.message, TEXT), TEXT)]
        return self._call(natives.ACT, *parts)

    def mock(self) -> list[AnyStatement]:
        found = self._whole.mock(self._checker, self._given["mock"])
        if found is None:
            return []
        mock, instance = found
        line, node = self._made.line, self._given.get("returns")
        made: list[AnyStatement] = []
        if node is not None:
            if mock.value is None:
                self._checker.context.say(node, f"{mock.pou.name} has no result", "MOCK and its name alone")
                return []
            value = self._checker.expression_as(node, mock.value.type)
            if value is None:
                return []
            made.append(Assign(cell(mock.value), value, line=line))
        return [*made, Assign(mock.place(mock.is_on, instance), Constant(True, BOOL), line=line)]

    def verify(self) -> list[AnyStatement]:
        found = self._whole.mock(self._checker, self._given["mock"])
        if found is None:
            return []
        self._made.type = Elementary.DINT
        calls = self._kept(Load(found[0].place(found[0].calls, found[1])), Elementary.DINT)
        expected = None
        if "expected" in self._given:
            value = self._checker.expression_as(self._given["expected"], Elementary.DINT)
            expected = self._kept(value, Elementary.DINT)
            if expected is None:
                return []
        return self._call(natives.JUDGE, calls, expected, None, self._text(MESSAGE))


def _operand(side: Expression, node: tree.Expression) -> tuple[str, Type]:
    """Return the text of a side of a comparison and the type that shows its value; no text for a constant."""
    source = "" if isinstance(side, Constant) else expression_text(node)
    inside = side.operand.type if isinstance(side, Convert) else side.type
    return source if len(source) <= LONGEST else text(node), inside if isinstance(inside, EnumType) else side.type


def _plain(value: Expression) -> Expression:
    """Return a constant without a type of its own in the type that it would have."""
    return Constant(value.value, value.type) if isinstance(value, Untyped) else value


def paths(node: tree.Expression) -> list[str]:
    """Return the paths of the variables in an expression.  No recursion: expressions may be long."""
    waiting: list[tuple[tree.Expression, str]] = [(node, "")]
    found: list[str] = []
    while waiting:
        part, behind = waiting.pop()
        match part:
            case tree.Name(text=name):
                found.append(f"{name}{behind}")
            case tree.Member(of=tree.Dereference(of=tree.Name(text=word)), name=name) if word.upper() in _OWN:
                found.append(f"{name}{behind}")
            case tree.Member(of=of, name=name):
                waiting.append((of, f".{name}{behind}"))
            case tree.Index(of=of, indices=indices):
                numbers = [_number(index) for index in indices]
                if None in numbers:
                    waiting += [(index, "") for index in indices]  # which element it is, is known at run time
                else:
                    waiting.append((of, f"[{','.join(map(str, numbers))}]{behind}"))
            case tree.Unary(operand=operand):
                waiting.append((operand, behind))
            case tree.Binary(left=left, right=right):
                waiting += [(right, behind), (left, behind)]
            case tree.Call(arguments=arguments):
                waiting += [(one.value, behind) for one in reversed(arguments) if one.value is not None]
    return found


def _number(index: tree.Expression) -> int | None:
    """Return an index that is a number in the text; None for any other."""
    match index:
        case tree.Literal(kind=tree.LiteralKind.INTEGER, value=int(value)):
            return value
        case tree.Unary(operator="-", operand=tree.Literal(kind=tree.LiteralKind.INTEGER, value=int(value))):
            return -value
    return None


_RULES: Final[Mapping[str, Callable[[_One], list[AnyStatement]]]] = {
    "ASSERT_FAIL": _One.fail,
    "ASSERT_WITHIN": _One.over_time,
    "ASSERT_NEVER": _One.over_time,
    "ASSERT_STAYS": _One.over_time,
    "ASSERT_UNTIL": _One.over_time,
    "ADVANCE_TIME": _One.wait,
    "RUN_FOR": _One.wait,
    "PRINT": _One.act,
    "FAULT": _One.act,
    "CLEAR_FAULTS": _One.act,
    "MOCK": _One.mock,
    "MOCK_FUNCTION": _One.mock,
    "MOCK_VERIFY_CALLED": _One.verify,
    "MOCK_VERIFY_CALL_COUNT": _One.verify,
}
assert WORDS.keys() >= _RULES.keys()
