"""A project of IEC 61131-10 (2019), the exchange format of the standard itself: PLCopen's TC6 with other names.

The name space is `www.iec.ch/public/TC65SC65BWG7TF10`.  POUs and types are in name spaces under `Types`, tasks under
`Instances`.  Some tools export single POUs, with the POU as the root and its declarations as text.

No tool's document with a class, an interface or a method is public.  They are read as function blocks and functions are
written, with the attributes `abstract`, `final`, `override` and `accessSpecifier`; what is unknown in one is refused.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.assembly import Part, Raw, assemble, prototype
from fieldrig_devices.iec.imports.exchange.declared import known_interfaces, plain_text, section
from fieldrig_devices.iec.imports.exchange.part10_bodies import read_bodies
from fieldrig_devices.iec.imports.exchange.part10_types import NOTHING, read_declaration, read_type
from fieldrig_devices.iec.imports.exchange.tasks import duration, program_without_task, resource_of
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import (
    Element,
    attribute,
    comment_of,
    element,
    elements,
    is_set,
    line_of,
    name_of,
    namespace_of,
)  # fmt: skip

NAMESPACE: Final = "www.iec.ch/public/TC65SC65BWG7TF10"
_POUS: Final = {
    "Program": tree.PouKind.PROGRAM,
    "Function": tree.PouKind.FUNCTION,
    "FunctionBlock": tree.PouKind.FUNCTION_BLOCK,
    "Class": tree.PouKind.CLASS,
}
_LISTS: Final = ("Vars", "TempVars", "ExternalVars", "GlobalVars", "AccessVars")
_PARAMETERS: Final = ("InputVars", "OutputVars", "InoutVars")
_BODIES: Final = ("MainBody", "Body", "BodyContent")
_OF_METHODS: Final = (*_LISTS, *_BODIES, "Parameters", "ResultType", "Documentation", "AddData", "UsingDirective")
_FLAGS: Final = ("ABSTRACT", "FINAL", "OVERRIDE")


def is_project(root: Element) -> bool:
    return namespace_of(root).removeprefix("http://") == NAMESPACE


def read_project(root: Element, fragments: Fragments) -> tuple[tree.Declaration, ...]:
    """Everything that a `Project` declares, or a single POU."""
    types = [d for e in root.iter("{*}DataTypeDecl") if (d := read_declaration(e, fragments)) is not None]
    globals_: list[tree.Variables] = []
    for list_ in root.iter("{*}GlobalVars"):
        if not any(name_of(parent) in _POUS for parent in list_.iterancestors()):
            block = section(list_, read_type, fragments)
            globals_ += [block] if block is not None else []
    known = frozenset(attribute(e, "name").strip().casefold() for e in root.iter("{*}Interface"))
    interfaces = [i for e in root.iter("{*}Interface") if (i := _interface(e, fragments, known)) is not None]
    raws = [raw for e in root.iter() if name_of(e) in _POUS and (raw := _pou(e, fragments, known)) is not None]
    others: list[tree.Declaration] = [*types, *globals_, *interfaces]
    configurations = [c for e in root.iter("{*}Resource") if (c := _resource(e, fragments)) is not None]
    return (*others, *assemble(raws, others, fragments), *configurations)


def _refused(node: Element, fragments: Fragments, dialect: str) -> None:
    fragments.report.mistake(
        line_of(node),
        f"The {name_of(node).lower()} {attribute(node, 'name')[:60]} is not supported",
        "functions, function blocks and actions",
        f"Choose the dialect {dialect}.",
    )


# ---- POUs


def _pou(node: Element, fragments: Fragments, interfaces: frozenset[str]) -> Raw | None:
    """A POU; `interfaces` are those of the document in small letters."""
    name, line, kind, report = attribute(node, "name").strip(), line_of(node), _POUS[name_of(node)], fragments.report
    if kind is tree.PouKind.CLASS and not fragments.dialect.has_classes:
        _refused(node, fragments, "edition-3")
        return None
    if not fragments.is_name(name, line, "a POU"):
        return None
    with report.inside(f"{kind.value} {name[:60]}"):
        raw = Raw(kind, name, line, comments=comment_of(element(node, "Documentation")))
        raw.blocks = _blocks(node, kind, fragments) or plain_text(element(node, "AddData"), fragments)
        if kind is tree.PouKind.FUNCTION:
            result = element(node, "ResultType")
            raw.result = read_type(result, fragments) if result is not None else None
            if result is None and not fragments.dialect.has_void_functions:
                raw.result = tree.NamedType("BOOL")
                report.note(line, "The function declares no result; BOOL is assumed")
        body = element(node, "MainBody")
        raw.bodies = [] if body is None else read_bodies(body, report)
        raw.actions = [part for e in elements(node, "Action") for part in _part(e, fragments)]
        raw.transitions = [part for e in elements(node, "Transition") for part in _part(e, fragments)]
        raw.methods = _methods(node, fragments)
        if fragments.dialect.has_methods:
            raw.modifiers = tuple(word for word in _FLAGS if is_set(node, word.lower()))
        raw.extends = _above(node, fragments)
        names = _names(node, "Implements", fragments)
        raw.implements = known_interfaces("IMPLEMENTS", names, line, fragments, interfaces)
        return raw


def _blocks(node: Element, kind: tree.PouKind, fragments: Fragments) -> tuple[tree.Variables, ...]:
    blocks: list[tree.Variables] = []
    for list_ in (*elements(element(node, "Parameters"), *_PARAMETERS), *elements(node, *_LISTS)):
        block = section(list_, read_type, fragments)
        if block is None or not block.variables:
            continue
        word = attribute(list_, "accessSpecifier").strip().upper()
        is_open = kind is tree.PouKind.FUNCTION_BLOCK and word == "PUBLIC" and fragments.dialect.has_methods
        if word in tree.ACCESS and block.section is tree.Section.LOCAL and (kind is tree.PouKind.CLASS or is_open):
            block.access = word  # tools write "private" at every list of a function block or program
        blocks.append(block)
    return tuple(blocks)


# ---- methods and interfaces


def _methods(node: Element, fragments: Fragments) -> list[Raw]:
    methods: list[Raw] = []
    for added in elements(node, "Method"):
        name = attribute(added, "name").strip()
        if not fragments.dialect.has_methods:
            _refused(added, fragments, "edition-3")
        elif fragments.is_name(name, line_of(added), "a method"):
            with fragments.report.inside(f"method {name[:60]}"):
                methods.append(_method(added, fragments))
    return methods


def _method(node: Element, fragments: Fragments) -> Raw:
    for unknown in elements(node):
        if name_of(unknown) not in _OF_METHODS:
            what = f"A method has the element {name_of(unknown)[:40]}, which is not known"
            fragments.report.mistake(line_of(unknown), what, "ResultType, Parameters, Vars, TempVars and MainBody")
    result, body = element(node, "ResultType"), element(node, "MainBody")
    raw = Raw(tree.PouKind.FUNCTION, attribute(node, "name").strip(), line_of(node))
    raw.comments = comment_of(element(node, "Documentation"))
    raw.result = read_type(result, fragments) if result is not None else None
    raw.blocks = _blocks(node, raw.kind, fragments) or plain_text(element(node, "AddData"), fragments)
    raw.bodies = read_bodies(node if body is None else body, fragments.report)
    word = attribute(node, "accessSpecifier").strip().upper()
    flags = (flag for flag in _FLAGS if is_set(node, flag.lower()))
    raw.modifiers = (*((word,) if word in tree.ACCESS else ()), *flags)
    return raw


def _interface(node: Element, fragments: Fragments, known: frozenset[str]) -> tree.Interface | None:
    name, line = attribute(node, "name").strip(), line_of(node)
    if not fragments.dialect.has_methods:
        _refused(node, fragments, "edition-3")
        return None
    if not fragments.is_name(name, line, "an interface"):
        return None
    with fragments.report.inside(f"INTERFACE {name[:60]}"):
        methods = tuple(prototype(raw) for raw in _methods(node, fragments))
        above = known_interfaces("EXTENDS", _names(node, "Extends", fragments), line, fragments, known)
    comments = comment_of(element(node, "Documentation"))
    return tree.Interface(name, above, methods, comments=comments, position=tree.Position(line, 1))


def _above(node: Element, fragments: Fragments) -> str:
    """The function block or class that a POU extends; empty for none."""
    names = _names(node, "Extends", fragments)
    if names and not fragments.dialect.has_methods:
        fragments.report.mistake(line_of(node), "EXTENDS is not supported", hint="Choose the dialect edition-3.")
        return ""
    return names[0] if names else ""


def _names(node: Element, kind: str, fragments: Fragments) -> list[str]:
    """The names in the references `Extends` or `Implements`, without their name spaces."""
    specs = [read_type(e, fragments) for e in elements(node, kind)]
    return [spec.name for spec in specs if isinstance(spec, tree.NamedType) and spec is not NOTHING]


def _part(node: Element, fragments: Fragments) -> list[Part]:
    with fragments.report.inside(f"{name_of(node).lower()} {attribute(node, 'name')[:60]}"):
        comments = comment_of(element(node, "Documentation"))
        bodies = read_bodies(node, fragments.report)[:1]
        return [Part(attribute(node, "name").strip(), line_of(node), drawn, comments) for drawn in bodies]


# ---- tasks


def _resource(node: Element, fragments: Fragments) -> tree.Configuration | None:
    tasks = [_task(e, fragments) for e in elements(node, "Task")]
    programs = [_instance(e) for e in elements(node, "ProgramInstance")]
    free = [program for program in programs if not program.task]
    programs = [program for program in programs if program.task]
    if free:
        program_without_task(tasks, programs, free)
    return resource_of(node, tasks, programs) if tasks else None


def _instance(node: Element) -> tree.ProgramInstance:
    name = attribute(node, "name").strip()
    kind = attribute(node, "typeName").strip() or name
    return tree.ProgramInstance(
        name, attribute(node, "associatedTaskName").strip(), kind, position=tree.Position(line_of(node), 1)
    )


def _task(node: Element, fragments: Fragments) -> tree.TaskDeclaration:
    line, name = line_of(node), attribute(node, "name").strip()
    fragments.is_name(name, line, "a task")
    priority, interval, single = (attribute(node, key).strip() for key in ("priority", "interval", "single"))
    with fragments.report.inside(f"task {name[:60]}"):
        return tree.TaskDeclaration(
            name,
            fragments.expression(priority, line) if priority else None,
            duration(interval, line, fragments) if interval else None,
            fragments.expression(single, line) if single else None,
            position=tree.Position(line, 1),
        )
