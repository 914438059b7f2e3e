"""Check and load generated Python, so that it can't reach anything but what it is given.

Programs of users and folded matrices become Python text that runs in this process, so every text is checked before it
runs, whatever generated it.  The basic rules allow integers, the names that are given, and plain control flow:
no attribute, import, text, builtin, comprehension or exception handling.  From integers and lists of integers nothing
of the host can be reached.  `Arithmetic` adds what formulas need: floats, and named attributes of named objects.
Text that breaks a rule is a fault of its generator, hence the loud `ForbiddenPythonError`.

Left out on purpose: limits of time and memory.  `fieldrig_devices.languages.resumable` generates code that yields by
itself, and no text can make an object that lasts.
"""

import ast
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final

ALLOWED: Final = frozenset(
    {
        ast.arguments, ast.arg, ast.Return, ast.Pass,
        ast.If, ast.While, ast.Break, ast.Continue,
        ast.Expr, ast.Assign, ast.AugAssign, ast.Call, ast.Name, ast.Load, ast.Store, ast.Subscript, ast.Tuple,
        ast.Constant, ast.IfExp, ast.Compare, ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.USub, ast.Invert,
        ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.FloorDiv, ast.Mod, ast.BitAnd, ast.BitOr, ast.BitXor,
        ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn,
    }
)  # fmt: skip
CONSTANTS: Final = frozenset({int})
ALLOWED_IN_FORMULAS: Final = ALLOWED | {ast.Attribute, ast.Div, ast.NamedExpr}
CONSTANTS_IN_FORMULAS: Final = CONSTANTS | {float, bool, type(None)}


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Rules for formulas: floats, true division, truth values, None, `:=`, and the attributes that are named here."""

    attributes: Mapping[str, Collection[str]]
    """Attributes that may be read and set, by the name of their object: `{"axis": {"e", "v"}}`."""


class ForbiddenPythonError(Exception):
    """Generated code that must not run."""


def check(source: str, names: Collection[str], rules: Arithmetic | None = None) -> ast.Module:
    """Return the tree of the text if it holds nothing but functions that use `names` and each other.

    ForbiddenPythonError, with the line, for anything else.
    """
    tree = ast.parse(source)
    names = {*names, *(statement.name for statement in tree.body if isinstance(statement, ast.FunctionDef))}
    for statement in tree.body:
        if not isinstance(statement, ast.FunctionDef):
            raise ForbiddenPythonError(f"line {statement.lineno}: not a function")
        _check_function(statement, names, rules)
    return tree


def load(source: str, names: Mapping[str, object], rules: Arithmetic | None = None) -> dict[str, FunctionType]:
    """Return the functions of the text by name.  They see `names` and nothing else, not even the builtins."""
    tree = check(source, names, rules)
    scope: dict[str, Any] = {**names, "__builtins__": {}}
    exec(compile(tree, "<generated>", "exec"), scope)
    return {statement.name: scope[statement.name] for statement in tree.body if isinstance(statement, ast.FunctionDef)}


def _check_function(function: ast.FunctionDef, names: Collection[str], rules: Arithmetic | None) -> None:
    parts = function.args
    notes = (function.returns, *(argument.annotation for argument in parts.args))
    if function.decorator_list or parts.defaults or parts.kwonlyargs or parts.vararg or parts.kwarg or any(notes):
        raise ForbiddenPythonError(f"line {function.lineno}: a function has parameters and a body, nothing else")
    nodes = list(ast.walk(function))[1:]  # without the function itself
    own = {argument.arg for argument in parts.args}
    own |= {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    if clash := own & set(names):
        raise ForbiddenPythonError(f"line {function.lineno}: {', '.join(sorted(clash))} must not be assigned")
    for node in nodes:
        if reason := _wrong(node, names, own, rules):
            raise ForbiddenPythonError(f"line {getattr(node, 'lineno', function.lineno)}: {reason}")


def _wrong(node: ast.AST, names: Collection[str], own: Collection[str], rules: Arithmetic | None) -> str:
    """Return why the node is forbidden, or an empty text."""
    if type(node) not in (ALLOWED if rules is None else ALLOWED_IN_FORMULAS):
        return f"{type(node).__name__} is not allowed"
    constants = CONSTANTS if rules is None else CONSTANTS_IN_FORMULAS
    if isinstance(node, ast.Constant) and type(node.value) not in constants:
        return f"the constant {node.value!r} is not allowed"
    if isinstance(node, ast.Attribute) and (rules is None or not _is_granted(node, rules)):
        return f"the attribute {node.attr} is not allowed"
    if isinstance(node, ast.Name) and node.id not in names and node.id not in own:
        return f"{node.id} is not known here"
    if isinstance(node, ast.Call) and (not isinstance(node.func, ast.Name) or node.func.id not in names):
        return "only the given names may be called"
    if isinstance(node, ast.Call) and node.keywords:
        return "arguments have no names"
    if isinstance(node, ast.Subscript) and (not isinstance(node.value, ast.Name) or node.value.id not in names):
        return "only the given tables have elements"
    return ""


def _is_granted(node: ast.Attribute, rules: Arithmetic) -> bool:
    return isinstance(node.value, ast.Name) and node.attr in rules.attributes.get(node.value.id, ())
