"""Check and load generated Python, so that it cannot reach anything but what it is given.

Programs of users and folded matrices become Python text that runs in this process, so every text is checked before it
runs, whatever generated it.  The basic rules allow integers, the names that are given, and plain control flow:
no attribute, import, text, builtin, comprehension or exception handling.  From integers and lists of integers nothing
of the host can be reached.  `Arithmetic` adds what formulas need: floats, and named attributes of named objects.
`Values` adds what a language with reals and strings needs.  Under it a name is either a value, which can be read and
subscripted, or a function, which can only be called; so what the text computes with are the values in the given tables,
the results of the given functions, and constants.  As long as those are truth values, numbers, strings and lists of
them, there is nothing to reach: without attributes, imports and builtins, the operators lead from such values to such
values only, and neither a function nor a table of functions can be stored, passed on or returned.

Text that breaks a rule is a fault of its generator, hence the loud `ForbiddenPythonError`.

Left out on purpose: limits of time and memory.  `fieldrig_devices.languages.resumable` generates code that yields by
itself, and no text can make an object that lasts.
"""

import ast
from collections.abc import Callable, Collection, Iterable, Mapping, Set
from dataclasses import dataclass
from types import CodeType, FunctionType
from typing import Any, Final

ALLOWED: Final[frozenset[type]] = frozenset(
    {
        ast.arguments, ast.arg, ast.Return, ast.Pass,
        ast.If, ast.While, ast.Break, ast.Continue,
        ast.Expr, ast.Assign, ast.AugAssign, ast.Call, ast.Name, ast.Load, ast.Store, ast.Subscript, ast.Tuple,
        ast.Constant, ast.IfExp, ast.Compare, ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.USub, ast.Invert,
        ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.FloorDiv, ast.Mod, ast.BitAnd, ast.BitOr, ast.BitXor,
        ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn,
    }
)  # fmt: skip
CONSTANTS: Final[frozenset[type]] = frozenset({int})
ALLOWED_IN_FORMULAS: Final[frozenset[type]] = ALLOWED | {ast.Attribute, ast.Div, ast.NamedExpr}
CONSTANTS_IN_FORMULAS: Final[frozenset[type]] = CONSTANTS | {float, bool, type(None)}
ALLOWED_WITH_VALUES: Final[frozenset[type]] = ALLOWED | {ast.Div, ast.NamedExpr, ast.Slice}
CONSTANTS_OF_VALUES: Final[frozenset[type]] = CONSTANTS | {float, bool, str}


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Rules for formulas: floats, true division, truth values, None, `:=`, and the attributes that are named here."""

    attributes: Mapping[str, Collection[str]]
    """Attributes that may be read and set, by the name of their object: `{"axis": {"e", "v"}}`."""


@dataclass(frozen=True, slots=True)
class Values:
    """Rules for languages with reals and strings: floats, strings, truth values, true division, `:=` and slices."""

    values: frozenset[str]
    """The given names that are tables or constants.  All others are functions, and can only be called."""


Rules = Arithmetic | Values


class ForbiddenPythonError(Exception):
    """Generated code that must not run."""


def check(source: str, names: Collection[str], rules: Rules | None = None) -> ast.Module:
    """Return the tree of the text if it holds nothing but functions that use `names` and each other.

    ForbiddenPythonError, with the line, for anything else.
    """
    tree = ast.parse(source)
    own = {statement.name for statement in tree.body if isinstance(statement, ast.FunctionDef)}
    known: Set[str] = names if isinstance(names, Set) and own <= names else {*names, *own}
    for statement in tree.body:
        if not isinstance(statement, ast.FunctionDef):
            raise ForbiddenPythonError(f"line {statement.lineno}: not a function")
        _check_head(statement)
        _check_body(statement, known, rules)
    return tree


def load(source: str, names: Mapping[str, object], rules: Rules | None = None) -> dict[str, FunctionType]:
    """Return the functions of the text by name.  They see `names` and nothing else, not even the builtins."""
    return bind(compiled(source, names, rules), {**names})


def compiled(source: str, names: Collection[str], rules: Rules | None = None, file: str = "<generated>") -> CodeType:
    """Return the checked text in a form that `bind` takes, also in another process."""
    code = compile(check(source, names, rules), file, "exec")
    assert isinstance(code, CodeType)
    return code


def bind(code: CodeType, scope: dict[str, Any]) -> dict[str, FunctionType]:
    """Define the functions of checked code in `scope`, which is all that they see, and return them by name."""
    scope["__builtins__"] = {}
    exec(code, scope)
    return {name: scope[name] for name in code.co_names}


def _check_head(function: ast.FunctionDef) -> None:
    given = function.args
    notes = (function.returns, *(argument.annotation for argument in given.args))
    others = (given.posonlyargs, given.kwonlyargs, given.defaults, function.decorator_list)
    if given.vararg or given.kwarg or any(notes) or any(others):
        raise ForbiddenPythonError(f"line {function.lineno}: a function has parameters and a body, nothing else")


_CHILDREN: Final[Mapping[type[ast.AST], Callable[[Any], Iterable[ast.AST]]]] = {
    ast.Return: lambda part: _given(part.value),
    ast.If: lambda part: (part.test, *part.body, *part.orelse),
    ast.While: lambda part: (part.test, *part.body, *part.orelse),
    ast.Expr: lambda part: (part.value,),
    ast.Assign: lambda part: (*part.targets, part.value),
    ast.AugAssign: lambda part: (part.target, part.op, part.value),
    ast.NamedExpr: lambda part: (part.target, part.value),
    ast.Call: lambda part: (*part.args, *part.keywords),
    ast.Attribute: lambda part: (part.value,),
    ast.Subscript: lambda part: (part.value, part.slice),
    ast.Slice: lambda part: _given(part.lower, part.upper, part.step),
    ast.Tuple: lambda part: part.elts,
    ast.IfExp: lambda part: (part.test, part.body, part.orelse),
    ast.Compare: lambda part: (part.left, *part.ops, *part.comparators),
    ast.BoolOp: lambda part: (part.op, *part.values),
    ast.UnaryOp: lambda part: (part.op, part.operand),
    ast.BinOp: lambda part: (part.left, part.op, part.right),
}
"""The parts of each part that has any, apart from the name of a called function, which is checked with its call."""


def _given(*parts: ast.AST | None) -> list[ast.AST]:
    return [part for part in parts if part is not None]


def _check_body(function: ast.FunctionDef, names: Set[str], rules: Rules | None) -> None:
    """Pass once over the parts of the body, and then over the names that it reads."""
    allowed, constants = _allowed(rules)
    own = {argument.arg for argument in function.args.args}
    read: dict[str, ast.Name] = {}  # a place for each name that is read as a value
    parts: list[Any] = [*function.body]
    for part in parts:  # which grows meanwhile
        kind, reason = type(part), ""
        if kind is ast.Name:
            if type(part.ctx) is ast.Store:
                own.add(part.id)
            else:
                read[part.id] = part
        elif kind not in allowed:
            reason = f"{kind.__name__} is not allowed"
        elif kind is ast.Constant:
            reason = "" if type(part.value) in constants else f"the constant {part.value!r} is not allowed"
        elif kind in _CHILDREN:
            reason = _wrong(part, names, rules) if kind in _EXAMINED else ""
            parts += _CHILDREN[kind](part)
        if reason:
            raise ForbiddenPythonError(f"line {getattr(part, 'lineno', function.lineno)}: {reason}")
    if clash := own & names:
        raise ForbiddenPythonError(f"line {function.lineno}: {', '.join(sorted(clash))} must not be assigned")
    readable = rules.values if isinstance(rules, Values) else names
    for name, part in read.items():
        if name not in readable and name not in own:
            reason = "is not a value" if name in names else "is not known here"
            raise ForbiddenPythonError(f"line {part.lineno}: {name} {reason}")


_EXAMINED: Final = frozenset({ast.Attribute, ast.Call, ast.Subscript})
"""Parts that are allowed under conditions."""


def _allowed(rules: Rules | None) -> tuple[frozenset[type], frozenset[type]]:
    """Return the parts and the types of constants that these rules allow."""
    if isinstance(rules, Values):
        return ALLOWED_WITH_VALUES, CONSTANTS_OF_VALUES
    return (ALLOWED, CONSTANTS) if rules is None else (ALLOWED_IN_FORMULAS, CONSTANTS_IN_FORMULAS)


def _wrong(part: ast.Attribute | ast.Call | ast.Subscript, names: Set[str], rules: Rules | None) -> str:
    """Return why the part is forbidden, whatever it contains, or an empty text."""
    if isinstance(part, ast.Attribute):
        is_granted = isinstance(rules, Arithmetic) and _is_granted(part, rules)
        return "" if is_granted else f"the attribute {part.attr} is not allowed"
    if isinstance(part, ast.Call):
        return "" if _is_function(part.func, names, rules) else "only the given names may be called"
    return "" if _has_elements(part, names, rules) else "only the given tables have elements"


def _is_function(called: ast.expr, names: Set[str], rules: Rules | None) -> bool:
    if not isinstance(called, ast.Name) or called.id not in names:
        return False
    return not isinstance(rules, Values) or called.id not in rules.values


def _has_elements(part: ast.Subscript, names: Set[str], rules: Rules | None) -> bool:
    """True for elements of given tables; under `Values` also for parts of any value with a name, such as a string."""
    if not isinstance(part.value, ast.Name):
        return False
    return part.value.id in names or (isinstance(rules, Values) and isinstance(part.slice, ast.Slice))


def _is_granted(part: ast.Attribute, rules: Arithmetic) -> bool:
    return isinstance(part.value, ast.Name) and part.attr in rules.attributes.get(part.value.id, ())
