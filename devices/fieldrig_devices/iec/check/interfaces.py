"""Interfaces: a function block that implements one must have its methods and properties, with the same variables.

Calls by a variable of an interface are in `dispatch.py`.
"""

from collections.abc import Iterator

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import access, inheritance, open_arrays
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import PouSource, Project
from fieldrig_devices.iec.check.properties import name_to_write
from fieldrig_devices.iec.check.type_specs import TypeSpecs
from fieldrig_devices.iec.program import Pou
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.iec.types import EnumType, Type

_ARGUMENTS = (Section.INPUT, Section.OUTPUT, Section.IN_OUT)
Form = tuple[Type | None, tuple[tuple[str, Section, Type | str | None], ...]]
"""The type of the result, and the arguments with their names and kinds."""


def check(project: Project, specs: TypeSpecs, source: PouSource) -> None:
    """Report what a function block lacks of the interfaces that it implements."""
    if source.line is None:
        return
    pou, position = source.pou, source.tree.position
    is_abstract = "ABSTRACT" in source.tree.modifiers
    for interface, file in _all(project, source):
        context = Context(project, source, file)
        for method in interface.methods:
            what = "property" if method.accessor else "method"
            is_writer = method.accessor == "SET"
            name = name_to_write(method.name) if is_writer else method.name
            own = pou.methods.get(project.key(name))
            if own is None and is_abstract:
                continue  # what extends it has the code
            if own is None:
                missing = (
                    f"{pou.name} has no {what} {method.name}{f' with {method.accessor}' if method.accessor else ''}"
                )
                project.reports.say(pou.file, position, missing, f"all of {interface.name}")
            elif access.is_hidden(project, own):
                hidden = f"the {what} {method.name} of {pou.name} is {project.guards[own].word}"
                project.reports.say(pou.file, position, hidden, f"PUBLIC for the interface {interface.name}")
            elif not is_writer and form(project, own) != _wanted(project, specs, method, context):
                differs = f"the {what} {method.name} of {pou.name} differs from that of {interface.name}"
                project.reports.say(pou.file, position, differs, "the same result and the same arguments")


def _all(project: Project, source: PouSource) -> Iterator[tuple[tree.Interface, str]]:
    """Yield the interfaces of a function block and of those that it extends, with the interfaces that these extend.

    An interface that is not declared gets a message.
    """

    def say(name: str) -> None:
        hint = project.reports.closest(name, project.interfaces)
        project.reports.say(source.pou.file, source.tree.position, f"the interface {name} is not declared", hint=hint)

    yield from inheritance.closure(project, inheritance.implemented(source), say)


def form(project: Project, method: Pou) -> Form:
    """Return what a call of a method needs to know of it."""
    arguments = [
        variable
        for variable in method.variables.values()
        if variable.section in _ARGUMENTS and not variable.name.startswith("$")
    ]
    result = method.result.type if method.result is not None else None
    return result, tuple((project.key(one.name), one.section, _declared(one.type)) for one in arguments)


def _declared(kind: Type | None) -> Type | str | None:
    """Return what tells a type: the name of an enumeration, which is another type as an input of a library's block."""
    return kind.name.casefold() if isinstance(kind, EnumType) else kind


def _wanted(project: Project, specs: TypeSpecs, method: tree.Method, context: Context) -> Form:
    result = specs.resolve(method.result, context) if method.result is not None else None
    arguments = [
        (project.key(variable.name), block.section, _declared(open_arrays.argument(specs, variable, None, context)[0]))
        for block in method.blocks
        if block.section in _ARGUMENTS
        for variable in block.variables
    ]
    return result, tuple(arguments)
