"""Generated Python under lock: what it may contain, and what it may see.

A user's program becomes Python that runs in this process, so it is looked at before it runs, whoever generated it:
integers, the names it was given, and plain control flow.  No attribute, no import, no text but what the generator
put into a table, no builtin, no comprehension, no exception handling: from integers and lists of integers alone
nothing of the host can be reached.  A violation is a fault of the generator, hence the loud `ForbiddenPythonError`.

Left out on purpose: limits of time and memory.  Time is the business of `resumable`, whose code gives way by itself;
memory can't grow, because nothing here makes an object that lasts.
"""

import ast
from collections.abc import Collection, Mapping
from types import FunctionType
from typing import Any

ALLOWED = frozenset(
    {
        ast.arguments, ast.arg, ast.Return, ast.Pass,
        ast.If, ast.While, ast.Break, ast.Continue,
        ast.Expr, ast.Assign, ast.AugAssign, ast.Call, ast.Name, ast.Load, ast.Store, ast.Subscript, ast.Tuple,
        ast.Constant, ast.IfExp, ast.Compare, ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.USub, ast.Invert,
        ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.FloorDiv, ast.Mod, ast.BitAnd, ast.BitOr, ast.BitXor,
        ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.In, ast.NotIn,
    }
)  # fmt: skip


class ForbiddenPythonError(Exception):
    """Generated code that must not run."""


def check(source: str, names: Collection[str]) -> ast.Module:
    """The tree of generated code that may run: functions that call and read nothing but `names` and each other."""
    tree = ast.parse(source)
    names = {*names, *(one.name for one in tree.body if isinstance(one, ast.FunctionDef))}
    for statement in tree.body:
        if not isinstance(statement, ast.FunctionDef):
            raise ForbiddenPythonError(f"line {statement.lineno}: not a function")
        _check_function(statement, names)
    return tree


def load(source: str, names: Mapping[str, object]) -> dict[str, FunctionType]:
    """The functions of generated code by name; they see `names` and nothing else, not even the builtins."""
    tree = check(source, names)
    scope: dict[str, Any] = {**names, "__builtins__": {}}
    exec(compile(tree, "<generated>", "exec"), scope)
    return {statement.name: scope[statement.name] for statement in tree.body if isinstance(statement, ast.FunctionDef)}


def _check_function(function: ast.FunctionDef, names: Collection[str]) -> None:
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
        if reason := _wrong(node, names, own):
            raise ForbiddenPythonError(f"line {getattr(node, 'lineno', function.lineno)}: {reason}")


def _wrong(node: ast.AST, names: Collection[str], own: Collection[str]) -> str:
    if type(node) not in ALLOWED:
        return f"{type(node).__name__} is not allowed"
    if isinstance(node, ast.Constant) and type(node.value) is not int:
        return f"only integers may stand there, not {node.value!r}"
    if isinstance(node, ast.Name) and node.id not in names and node.id not in own:
        return f"{node.id} is not known here"
    if isinstance(node, ast.Call) and (not isinstance(node.func, ast.Name) or node.func.id not in names):
        return "only what was given may be called"
    if isinstance(node, ast.Call) and node.keywords:
        return "arguments have no names"
    if isinstance(node, ast.Subscript) and (not isinstance(node.value, ast.Name) or node.value.id not in names):
        return "only a table that was given has elements"
    return ""
