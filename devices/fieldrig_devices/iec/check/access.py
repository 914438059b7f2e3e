"""Access specifiers: which code may use a variable, a method or a property of a class or function block.

Source: IEC 61131-3:2013, 6.6.5.5 to 6.6.5.9 and table 48.  PRIVATE is for the code of the class that declares it,
PROTECTED also for classes that extend it, PUBLIC for everything.  INTERNAL is for the name space, and a project is one
name space here.  A class has PROTECTED where nothing is written; what today's tools call a method of a function block
without a word is PUBLIC.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import methods
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import Guard, Project
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.program import Place, Pou, Variable
from fieldrig_devices.iec.tree import PouKind

_OPEN: Final = frozenset({"PUBLIC", "INTERNAL"})


def guard(project: Project, what: Variable | Pou, words: Sequence[str], home: tree.Pou, level: int) -> None:
    """Note the access to a variable or method that `home` declares, which is `level` steps above its function block."""
    default = "PROTECTED" if home.kind is PouKind.CLASS else ""
    word = next((word for word in words if word in tree.ACCESS), default)
    if word:
        project.guards[what] = Guard(word, level, home.name)


def is_open(project: Project, what: Variable | Pou) -> bool:
    """True if something is declared for all code of the project."""
    guard = project.guards.get(what)
    return guard is not None and guard.word in _OPEN


def is_hidden(project: Project, what: Variable | Pou) -> bool:
    """True if something is declared for a part of the code only."""
    guard = project.guards.get(what)
    return guard is not None and guard.word not in _OPEN


def allows_variable(context: Context, variable: Variable, node: tree.Node) -> bool:
    """True if the code may use a variable of its own instance; a message otherwise."""
    guarded = context.project.guards.get(variable)
    if guarded is None or guarded.word != "PRIVATE" or guarded.level == context.level:
        return True
    hint = "declare it in VAR PROTECTED"
    context.say(node, f"{variable.name} is PRIVATE in {guarded.home}", f"a variable of {_here(context)}", hint)
    return False


def allows_call(checker: Checker, node: tree.Call, instance: Place | None, method: Pou) -> bool:
    """True if the code may call a method; a message otherwise."""
    context = checker.context
    called = node.called
    if isinstance(called, tree.Member) and methods.is_super(context, called.of) and _is_abstract(context, method):
        context.say(called, f"{called.name} is ABSTRACT above {_here(context)} and has no code", "a method with code")
        return False
    guarded = context.project.guards.get(method)
    if guarded is None or guarded.word in _OPEN or context.extension is not None:
        return True  # a test sees all of a block
    is_inside = instance is None or (method.owner is not None and method.owner is context.block)
    if is_inside and (guarded.word == "PROTECTED" or guarded.level == context.level):
        return True
    what, word = ("property", "PROPERTY") if method.is_accessor else ("method", "METHOD")
    name = method.name.rpartition(".")[2].partition("@")[0]
    context.say(
        node,
        f"the {what} {name} of {guarded.home} is {guarded.word}",
        f"{a(what)} that may be used here",
        f"write {word} PUBLIC {name} in {guarded.home}",
    )
    return False


def _is_abstract(context: Context, method: Pou) -> bool:
    return "ABSTRACT" in context.project.sources[method].tree.modifiers


def _here(context: Context) -> str:
    return context.block.name if context.block is not None else ""
