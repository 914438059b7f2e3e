"""EN and ENO: a call that runs only while its EN is TRUE, and the ENO that a body may set.

Source: IEC 61131-3:2013, 6.6.1.5 and table 18.  Every function, method, function block and program has both without
declaring them; a declared `VAR_INPUT EN : BOOL` or `VAR_OUTPUT ENO : BOOL` means the same, except in libraries.

- Without EN nothing of the call happens, and ENO is FALSE: the arguments are not evaluated, the outputs of an instance
  keep their values, and the variables behind => keep theirs.
- An assignment of the result does not happen either.  Within a larger expression the result is the start value of its
  type, which the standard leaves open.
- ENO is TRUE when a body begins.  What the body assigns to it is the ENO of the call.  The ENO of an instance that has
  never been called is FALSE, like other outputs.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import PouSource, Project
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    Cell,
    Constant,
    Convert,
    Enable,
    Enabled,
    Expression,
    If,
    Load,
    Operator,
    Place,
    Pou,
    Return,
    Space,
    Unary,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import Type

BOOL: Final = Elementary.BOOL
NAMES: Final = frozenset({"EN", "ENO"})
ALWAYS: Final = Enable()
"""The EN and ENO of a call that has neither."""

Split = tuple[tree.Call, Enable]
"""A call without its EN and ENO, and these."""


def hint(context: Context, word: str) -> str:
    """Return the hint about EN or ENO in a dialect without them; empty for other words."""
    is_missing = word.upper() in NAMES and not context.project.dialect.has_enable
    return "EN and ENO of every call are known in the dialect edition-3" if is_missing else ""


# ---- calls


def split(checker: Checker, node: tree.Call, pou: Pou | None) -> Split | None:
    """Take EN and ENO out of a call; None after a message.  `pou` is None for a standard function."""
    if not checker.context.project.dialect.has_enable:
        return node, ALWAYS
    given = [argument for argument in node.arguments if argument.name.upper() in NAMES]
    given = [argument for argument in given if not _is_ordinary(argument.name, pou)]
    if not given:
        return node, ALWAYS
    rest = tuple(argument for argument in node.arguments if all(argument is not one for one in given))
    call = tree.Call(node.called, rest, position=node.position)
    pins: dict[str, tree.Argument] = {}
    for argument in given:
        name = argument.name.upper()
        wanted = "ENO => target" if name == "ENO" else "EN := condition"
        if name in pins:
            checker.context.say(argument, f"{name} is given twice", wanted)
            return None
        if argument.is_output is (name == "EN"):
            checker.context.say(argument, f"{name} is an {'input' if name == 'EN' else 'output'} of every call", wanted)
            return None
        pins[name] = argument
    return _checked(checker, call, pins.get("EN"), pins.get("ENO"))


def _is_ordinary(name: str, pou: Pou | None) -> bool:
    """True if the POU declares this variable, and it is an argument like others."""
    declared = pou.variables.get(name.casefold()) if pou is not None else None
    return declared is not None and (pou is None or declared is not pou.eno)


def _checked(checker: Checker, call: tree.Call, en: tree.Argument | None, eno: tree.Argument | None) -> Split | None:
    condition: Expression | None = None
    if en is not None and en.value is not None:
        condition = checker.expression_as(en.value, BOOL)
        if condition is None:
            return None
        if isinstance(condition, Constant) and condition.value:
            condition = None
    ok: Place | None = None
    if eno is not None and eno.value is not None:
        ok = checker.target(eno.value)
        if ok is None:
            return None
        if ok.type is not BOOL:
            checker.context.say(eno.value, f"{text(eno.value)} is {a(ok.type)}", "a BOOL for ENO")
            return None
    return call, Enable(condition, ok, eno is not None and eno.is_negated)


def result(
    checker: Checker, value: Expression, enable: Enable, wanted: Type | None, at: tree.Node
) -> Expression | None:
    """Return the result of a standard function with its EN and ENO; None after a message."""
    if enable is ALWAYS:
        return value
    converted: Expression | None = value
    if type(value) is Untyped:  # ADD(1, 2) is a constant, whose type the surroundings give
        converted = checker.convert(value, wanted if _holds(wanted, value) and wanted is not None else value.type, at)
    return Enabled(converted, enable) if converted is not None else None


def _holds(kind: Type | None, value: Untyped) -> bool:
    if not isinstance(kind, Elementary) or not kind.is_integer or isinstance(value.value, float):
        return isinstance(kind, Elementary) and kind.is_real
    return kind.low <= int(value.value) <= kind.high


def statements(value: Expression, run: Callable[[Expression], AnyStatement], line: int) -> list[AnyStatement]:
    """Return the statements that `run` makes of a value, which is perhaps that of a call with EN."""
    inner = value
    while isinstance(inner, Convert):
        inner = inner.operand
    if not isinstance(inner, Enabled) or inner.enable.condition is None:
        return [run(value)]
    condition, ok, is_negated = inner.enable.condition, inner.enable.ok, inner.enable.is_negated
    inner.enable = Enable(None, ok, is_negated)
    otherwise: list[AnyStatement] = [Assign(ok, Constant(is_negated, BOOL), line=line)] if ok is not None else []
    return [If(condition, [run(value)], otherwise, line=line)]


# ---- bodies


def meaning(context: Context, word: str) -> Place | Constant | None:
    """Return what EN or ENO means in a body that does not declare it; None for other words."""
    if word.upper() not in NAMES or not context.project.dialect.has_enable or context.owner is None:
        return None
    if word.upper() == "EN":
        return Constant(True, BOOL)  # the body would not run otherwise
    return Cell(eno_of(context.owner), BOOL)


def of_instance(context: Context, pou: Pou, word: str) -> Variable | None:
    """Return the ENO of an instance of a function block whose body does not mention it; None for other words."""
    is_callable = pou.kind is not PouKind.CLASS and not pou.is_native
    if word.upper() != "ENO" or not context.project.dialect.has_enable or not is_callable:
        return None
    return eno_of(pou)


def is_implicit(context: Context, pou: Pou, variable: Variable) -> bool:
    """True for an ENO that is not declared."""
    return variable is pou.eno and "eno" not in context.project.sources[pou].names


def eno_of(pou: Pou) -> Variable:
    """Return the ENO that the body of a POU sets; make it at its first use."""
    if pou.eno is None:
        space = Space.FRAME if pou.kind is PouKind.FUNCTION else Space.INSTANCE
        pou.eno = pou.variables["eno"] = Variable("ENO", BOOL, space, Section.OUTPUT, file=pou.file)
    return pou.eno


def note_declared(project: Project, source: PouSource) -> None:
    """Note a declared ENO."""
    eno = source.pou.variables.get("eno")
    is_own = project.dialect.has_enable and not source.is_library
    if is_own and eno is not None and eno.section is Section.OUTPUT and eno.type is BOOL:
        source.pou.eno = eno


def begin_bodies(project: Project) -> None:
    """Let each body begin with ENO as TRUE, and not at all while a declared EN is FALSE."""
    if not project.dialect.has_enable:
        return
    for source in project.sources.values():
        pou = source.pou
        if pou.is_native:
            continue
        line = pou.body[0].line if pou.body else source.tree.position.line
        front: list[AnyStatement] = []
        en = None if source.is_library else pou.variables.get("en")
        if en is not None and en.section is Section.INPUT and en.type is BOOL:
            front = _unless(Load(Cell(en, BOOL)), pou.eno, line)
        if pou.eno is not None:
            front.append(Assign(Cell(pou.eno, BOOL), Constant(True, BOOL), line=line))
        pou.body[:0] = front


def _unless(en: Expression, eno: Variable | None, line: int) -> list[AnyStatement]:
    back: list[AnyStatement] = [Return(line=line)]
    if eno is not None:
        back.insert(0, Assign(Cell(eno, BOOL), Constant(False, BOOL), line=line))
    return [If(Unary(Operator.NOT, en, BOOL), back, line=line)]
