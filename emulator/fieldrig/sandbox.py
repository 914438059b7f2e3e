"""Check and load generated Python, so that it can't reach anything but what it is given.

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
from collections.abc import Collection, Mapping, Set
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
    known = names if isinstance(names, Set) and own <= names else {*names, *own}
    for statement in tree.body:
        if not isinstance(statement, ast.FunctionDef):
            raise ForbiddenPythonError(f"line {statement.lineno}: not a function")
        _check_function(statement, known, rules)
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


def _check_function(function: ast.FunctionDef, names: Collection[str], rules: Rules | None) -> None:
    parts = function.args
    notes = (function.returns, *(argument.annotation for argument in parts.args))
    if function.decorator_list or parts.defaults or parts.kwonlyargs or parts.vararg or parts.kwarg or any(notes):
        raise ForbiddenPythonError(f"line {function.lineno}: a function has parameters and a body, nothing else")
    allowed, constants = _allowed(rules)
    harmless = allowed - _EXAMINED
    examined, own, called = list[ast.AST](), {argument.arg for argument in parts.args}, set[ast.AST]()
    for node in _parts(function):
        kind = type(node)
        if kind in harmless:
            continue
        if kind not in allowed:
            line = getattr(node, "lineno", function.lineno)
            raise ForbiddenPythonError(f"line {line}: {kind.__name__} is not allowed")
        if isinstance(node, ast.Call):
            called.add(node.func)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            own.add(node.id)
        elif isinstance(node, ast.Constant):
            if type(node.value) not in constants:
                raise ForbiddenPythonError(f"line {node.lineno}: the constant {node.value!r} is not allowed")
        else:
            examined.append(node)
    if clash := {name for name in own if name in names}:
        raise ForbiddenPythonError(f"line {function.lineno}: {', '.join(sorted(clash))} must not be assigned")
    for node in examined:
        if isinstance(rules, Values) and isinstance(node, ast.Name) and node not in called:
            reason = "" if node.id in own or node.id in rules.values else f"{node.id} is not a value"
        else:
            reason = _wrong(node, names, own, rules)
        if reason:
            raise ForbiddenPythonError(f"line {getattr(node, 'lineno', function.lineno)}: {reason}")


_CHILDREN: dict[type[ast.AST], tuple[str, ...]] = {}
"""The fields of a part that may hold parts, apart from the context of a name, which is allowed everywhere."""


def _parts(function: ast.FunctionDef) -> list[ast.AST]:
    """Return all parts of a function; `ast.walk` would take twice as long."""
    found: list[ast.AST] = []
    waiting: list[ast.AST] = [function]
    while waiting:
        part = waiting.pop()
        fields = _CHILDREN.get(type(part))
        if fields is None:
            fields = _CHILDREN[type(part)] = tuple(name for name in part._fields if name != "ctx")
        for name in fields:
            value = getattr(part, name)
            if isinstance(value, list):
                waiting += [one for one in value if isinstance(one, ast.AST)]
            elif isinstance(value, ast.AST):
                waiting.append(value)
        found.append(part)
    return found[1:]


_EXAMINED: Final = frozenset({ast.Constant, ast.Attribute, ast.Name, ast.Call, ast.Subscript})
"""Parts that are allowed under conditions."""


def _allowed(rules: Rules | None) -> tuple[frozenset[type], frozenset[type]]:
    """Return the parts and the types of constants that these rules allow."""
    if isinstance(rules, Values):
        return ALLOWED_WITH_VALUES, CONSTANTS_OF_VALUES
    return (ALLOWED, CONSTANTS) if rules is None else (ALLOWED_IN_FORMULAS, CONSTANTS_IN_FORMULAS)


def _wrong(node: ast.AST, names: Collection[str], own: Collection[str], rules: Rules | None) -> str:
    """Return why the node is forbidden, or an empty text."""
    if isinstance(node, ast.Attribute) and not (isinstance(rules, Arithmetic) and _is_granted(node, rules)):
        return f"the attribute {node.attr} is not allowed"
    if isinstance(node, ast.Name) and node.id not in names and node.id not in own:
        return f"{node.id} is not known here"
    if isinstance(node, ast.Call) and not _is_function(node.func, names, rules):
        return "only the given names may be called"
    if isinstance(node, ast.Call) and node.keywords:
        return "arguments have no names"
    if isinstance(node, ast.Subscript) and not _has_elements(node, names, own, rules):
        return "only the given tables have elements"
    return ""


def _is_function(called: ast.expr, names: Collection[str], rules: Rules | None) -> bool:
    if not isinstance(called, ast.Name) or called.id not in names:
        return False
    return not isinstance(rules, Values) or called.id not in rules.values


def _has_elements(node: ast.Subscript, names: Collection[str], own: Collection[str], rules: Rules | None) -> bool:
    """True for elements of given tables; under `Values` for parts of a computed string as well."""
    if not isinstance(node.value, ast.Name):
        return False
    if isinstance(rules, Values) and isinstance(node.slice, ast.Slice):
        return node.value.id in own or node.value.id in rules.values
    return node.value.id in names


def _is_granted(node: ast.Attribute, rules: Arithmetic) -> bool:
    return isinstance(node.value, ast.Name) and node.attr in rules.attributes.get(node.value.id, ())
