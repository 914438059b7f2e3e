"""EXTENDS: what a function block has from those that it extends.

The code that is inherited is checked and compiled again for the function block that inherits it, so that a call in it
reaches the methods that override others.  A body is not inherited; `SUPER^()` runs that of the function block above.
Interfaces are inherited as well, by function blocks and by other interfaces.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import Lineage, PouSource, Project
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.program import Pou
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.languages.mistakes import Code

MOST_INHERITED: Final = 20_000
"""Variables and methods of all function blocks that they inherit: a short text may extend a large one many times."""
DEEPEST: Final = 40
"""Levels of function blocks or interfaces that extend one another; each has its own copy of what it inherits."""


def lineage(project: Project, node: tree.Pou, file: str, known: Mapping[str, tuple[tree.Pou, str]]) -> Lineage:
    """Return a POU with the function blocks that it extends, the next one first; a message for one that is not."""
    line = [(node, file)]
    is_broken = False
    while node.extends:
        above = known.get(project.key(node.extends)) or known.get(project.key(unqualified(node.extends)))
        if above is None or not _may_extend(node, above[0]):
            what = f"{node.extends} is {a(above[0].kind.value)}" if above else f"{node.extends} is not declared"
            hint = "" if above else project.reports.closest(node.extends, known)
            expected = "class" if node.kind is PouKind.CLASS else "function block"
            code = Code.OTHER if above else Code.NO_TYPE
            expected, name = f"a {expected} that {node.name} extends", unqualified(node.extends)
            project.reports.say(file, node.position, what, expected, hint, code, name)
            is_broken = True
            break
        if "FINAL" in above[0].modifiers:
            project.reports.say(
                file, node.position, f"{node.extends} is FINAL and cannot be extended", "an instance of it in VAR"
            )
        if isinstance(above[0].body, tree.NativeBody):
            what = f"{node.extends} is built into the controller and cannot be extended"
            project.reports.say(file, node.position, what, "an instance of it in VAR")
            is_broken = True
            break
        if any(above[0] is other for other, _ in line):
            project.reports.say(file, node.position, f"{node.name} extends itself", "another function block")
            break
        if len(line) > DEEPEST:
            what = f"{line[0][0].name} extends more than {DEEPEST} others"
            project.reports.say(line[0][1], line[0][0].position, what, f"at most {DEEPEST} levels")
            return Lineage(line[:1], is_broken=True)
        line.append(above)
        node, file = above
    project.inherited += sum(_parts(above) for above, _ in line[1:])
    if project.inherited > MOST_INHERITED:
        what = f"the function blocks up to {line[0][0].name} inherit too much"
        expected = f"at most {MOST_INHERITED} variables and methods, counted for each block that inherits them"
        if not project.inherits_too_much:
            project.reports.say(line[0][1], line[0][0].position, what, expected)
        project.inherits_too_much = True
        return Lineage(line[:1], is_broken=True)
    return Lineage(line, is_broken=is_broken)


def _parts(above: tree.Pou) -> int:
    """Return how many copies a function block makes of what it inherits from another one."""
    return 1 + len(above.methods) + len(above.actions) + sum(len(block.variables) for block in above.blocks)


def check_interfaces(project: Project) -> None:
    """Report interfaces that extend themselves, or too many levels of others; they extend nothing then."""
    levels: dict[str, int] = {}

    def above(key: str) -> list[str]:
        names = (project.key(unqualified(name)) for name in project.interfaces[key][0].extends)
        return [name for name in names if name in project.interfaces]

    def refuse(key: str, what: str, expected: str) -> None:
        interface, file = project.interfaces[key]
        project.reports.say(file, interface.position, f"{interface.name} {what}", expected)
        project.interfaces[key] = replace(interface, extends=()), file

    for root in list(project.interfaces):
        path = {root: iter(above(root))} if root not in levels else {}
        while path:
            key = next(reversed(path))
            name = next(path[key], None)
            if name is None:
                levels[key] = 1 + max((levels[one] for one in above(key)), default=0)
                if levels[key] > DEEPEST:
                    refuse(key, f"extends more than {DEEPEST} others", f"at most {DEEPEST} levels")
                    levels[key] = 1
                del path[key]
            elif name in path:
                refuse(key, "extends itself", "another interface")
                path[key] = iter(())
            elif name not in levels:
                path[name] = iter(above(name))


def unqualified(name: str) -> str:
    """Return a name without the library in front of it."""
    return name.rpartition(".")[2]


def _may_extend(node: tree.Pou, above: tree.Pou) -> bool:
    """A class extends a class; a function block extends a function block or a class."""
    return above.kind is PouKind.CLASS or (above.kind is PouKind.FUNCTION_BLOCK and node.kind is above.kind)


def add_body(source: PouSource, above: tree.Pou, level: int, file: str) -> None:
    """Make the body of a function block that is extended an action, for SUPER^()."""
    if above.kind is PouKind.CLASS:
        return
    pou, name = source.pou, body_name(level)
    title = f"{pou.name}.{above.name}@{level}"
    pou.actions[name] = Pou(pou.kind, title, file, pou.variables, type=pou.type, owner=pou)
    source.actions[name] = tree.Action(name, above.body, position=above.position), level


def body_name(level: int) -> str:
    """Return the name of the action with the body of this level, which no action of a source text can have."""
    return f"body@{level}"


def body_above(context: Context) -> Pou | None:
    """Return the action with the body that SUPER^() runs; None if the function block extends none."""
    return context.block.actions.get(body_name(context.level + 1)) if context.block is not None else None


def method_above(context: Context, name: str) -> Pou | None:
    """Return the method that `SUPER^.name()` calls."""
    source = context.source
    line = (source.outer or source).line if source is not None else None
    versions = line.versions.get(context.key(name), []) if line is not None else []
    return next((method for level, method in versions if level > context.level), None)


def implemented(source: PouSource) -> list[str]:
    """Return the interfaces that a function block and those that it extends name."""
    line = source.line.trees if source.line is not None else []
    return [name for above, _ in line for name in above.implements]


def closure(
    project: Project, names: Iterable[str], say: Callable[[str], None] = lambda name: None
) -> Iterator[tuple[tree.Interface, str]]:
    """Yield these interfaces and those that they extend, each once; `say` is called for one that is not declared."""
    open_names = list(names)
    known: set[str] = set()
    while open_names:
        name = open_names.pop(0)
        if (key := project.key(unqualified(name))) in known:
            continue
        known.add(key)
        declared = project.interfaces.get(key)
        if declared is None:
            say(name)
            continue
        yield declared
        open_names += declared[0].extends
