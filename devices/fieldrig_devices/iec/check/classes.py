"""Rules of classes, and of function blocks that are used like them: ABSTRACT, FINAL, OVERRIDE, and what a class lacks.

Source: IEC 61131-3:2013, 6.6.5 and table 48.  A class is a function block without a body, parameters and actions, so
the rest of the compiler treats it as one.
"""

from itertools import pairwise

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import interfaces
from fieldrig_devices.iec.check.project import PouSource, Project
from fieldrig_devices.iec.program import Pou
from fieldrig_devices.iec.tree import PouKind

_LIFE_CYCLE = ("fb_init", "fb_reinit", "fb_exit")
"""Methods of CODESYS whose arguments are those of their own block."""


def check(project: Project, source: PouSource) -> None:
    """Check a class or function block; its methods and those of its ancestors are declared."""
    if source.line is None or not source.tree.kind.has_instances:
        return
    if source.tree.kind is PouKind.CLASS:
        _check_content(project, source)
    is_abstract = "ABSTRACT" in source.tree.modifiers
    missing: list[str] = []
    for versions in source.line.versions.values():
        if not versions:
            continue  # an action has the name
        level, method = versions[0]
        modifiers = _modifiers(project, method)
        if level == 0:
            _check_own(project, source, method, is_further=len(versions) > 1)
        elif "ABSTRACT" in modifiers and not is_abstract:
            missing.append(shown(project.sources[method].tree.name))
        for (lower, below), (_, above) in pairwise(versions):
            if lower == 0:
                _check_override(project, source, below, above)
    for name in dict.fromkeys(missing):
        what = f"{source.pou.name} has no code for {name}, which is ABSTRACT above it"
        hint = f"write METHOD OVERRIDE {name}, or {source.tree.kind.value} ABSTRACT {source.pou.name}"
        project.reports.say(source.pou.file, source.tree.position, what, "all ABSTRACT methods and properties", hint)


def shown(name: str) -> str:
    """Return the name of a method as it was written, also of one that writes a property."""
    return name.partition("@")[0]


def _modifiers(project: Project, method: Pou) -> tuple[str, ...]:
    return project.sources[method].tree.modifiers


def _check_content(project: Project, source: PouSource) -> None:
    node, name, file = source.tree, source.pou.name, source.pou.file
    first = _first_of(node.body)
    if first is not None:
        hint = "Put the statements into a METHOD. A FUNCTION_BLOCK has a body as well."
        project.reports.say(file, first, f"the class {name} has a body", "only methods", hint)
    for action in node.actions:
        what = f"the class {name} has an action"
        project.reports.say(file, action.position, what, f"METHOD {action.name} ... END_METHOD")


def _first_of(body: tree.Body) -> tree.Position | None:
    """Return the position of the first statement; None for an empty body."""
    match body:
        case tree.StBody(statements):
            positions = [node.position for node in statements if not isinstance(node, tree.Empty)]
            return positions[0] if positions else None
        case tree.IlBody(instructions):
            return instructions[0].position if instructions else None
        case tree.SfcBody(steps):
            return steps[0].position if steps else None
    return None


def _check_own(project: Project, source: PouSource, method: Pou, *, is_further: bool) -> None:
    node, pou = project.sources[method].tree, source.pou
    name, is_accessor = shown(node.name), method.is_accessor
    what = f"the {'property' if is_accessor else 'method'} {name}"
    if "OVERRIDE" in node.modifiers and not is_further:
        hint = "remove OVERRIDE" if not source.tree.extends else ""
        expected = f"{a_method(is_accessor)} of this name in what {pou.name} extends"
        project.reports.say(pou.file, node.position, f"{what} of {pou.name} overrides nothing", expected, hint)
    if "ABSTRACT" not in node.modifiers:
        return
    if "ABSTRACT" not in source.tree.modifiers:
        kind = source.tree.kind.value
        project.reports.say(
            pou.file, node.position, f"{what} is ABSTRACT, and {pou.name} is not", f"{kind} ABSTRACT {pou.name}"
        )
    first = _first_of(node.body)
    if first is not None:
        hint = f"the code belongs to what extends {pou.name}"
        project.reports.say(pou.file, first, f"{what} is ABSTRACT and has a body", "no statements", hint)


def a_method(is_accessor: bool) -> str:
    return "a property" if is_accessor else "a method"


def _check_override(project: Project, source: PouSource, method: Pou, above: Pou) -> None:
    node, pou = project.sources[method].tree, source.pou
    name, modifiers = shown(node.name), _modifiers(project, above)
    what = f"the {'property' if method.is_accessor else 'method'} {name}"
    guard = project.guards.get(above)
    home = guard.home if guard is not None else "what it extends"
    if guard is not None and guard.word == "PRIVATE":
        project.reports.say(pou.file, node.position, f"{what} is PRIVATE in {home}", "another name, or PROTECTED there")
    elif "FINAL" in modifiers:
        project.reports.say(pou.file, node.position, f"{what} is FINAL above {pou.name}", "another name")
    elif source.tree.kind is PouKind.CLASS and "OVERRIDE" not in node.modifiers:
        hint = "the standard asks for OVERRIDE, so that no method is overridden by mistake"
        word = "PROPERTY" if method.is_accessor else "METHOD"
        words = " ".join([word, *node.modifiers, "OVERRIDE", name])
        project.reports.say(pou.file, node.position, f"{what} overrides that of {home}", words, hint)
    elif project.key(name) not in _LIFE_CYCLE and interfaces.form(project, method) != interfaces.form(project, above):
        expected = "the same result and the same arguments"
        project.reports.say(
            pou.file, node.position, f"{what} of {pou.name} differs from the one that it overrides", expected
        )
