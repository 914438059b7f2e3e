"""A project of IEC 61131-10 (2019), the exchange format of the standard itself: PLCopen's TC6 with other names.

The name space is `www.iec.ch/public/TC65SC65BWG7TF10`.  POUs and types are in name spaces under `Types`, tasks under
`Instances`.  Some tools export single POUs, with the POU as the root and its declarations as text.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.assembly import Part, Raw, assemble
from fieldrig_devices.iec.imports.exchange.declared import DEPTH, enumeration, initial, plain_text, section, variable
from fieldrig_devices.iec.imports.exchange.part10_bodies import read_bodies, type_of
from fieldrig_devices.iec.imports.exchange.tasks import duration, program_without_task, resource_of
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import (
    Element,
    attribute,
    comment_of,
    element,
    elements,
    line_of,
    name_of,
    namespace_of,
    text_of,
)  # fmt: skip

NAMESPACE: Final = "www.iec.ch/public/TC65SC65BWG7TF10"
_POUS: Final = {
    "Program": tree.PouKind.PROGRAM,
    "Function": tree.PouKind.FUNCTION,
    "FunctionBlock": tree.PouKind.FUNCTION_BLOCK,
}
_LISTS: Final = ("Vars", "TempVars", "ExternalVars", "GlobalVars", "AccessVars")
_PARAMETERS: Final = ("InputVars", "OutputVars", "InoutVars")
_OBJECTS: Final = ("Class", "Interface")
_NOTHING: Final = tree.NamedType("INT")


def is_project(root: Element) -> bool:
    return namespace_of(root).removeprefix("http://") == NAMESPACE


def read_project(root: Element, fragments: Fragments) -> tuple[tree.Declaration, ...]:
    """Everything that a `Project` declares, or a single POU."""
    types = [d for e in root.iter("{*}DataTypeDecl") if (d := _type_declaration(e, fragments)) is not None]
    globals_: list[tree.Variables] = []
    for found in root.iter("{*}GlobalVars"):
        if not any(name_of(parent) in _POUS for parent in found.iterancestors()):
            block = section(found, read_type, fragments)
            globals_ += [block] if block is not None else []
    raws = [raw for e in root.iter() if name_of(e) in _POUS and (raw := _pou(e, fragments)) is not None]
    for left_out in root.iter():
        if name_of(left_out) in _OBJECTS:
            _object(left_out, fragments)
    others: list[tree.Declaration] = [*types, *globals_]
    configurations = [c for e in root.iter("{*}Resource") if (c := _resource(e, fragments)) is not None]
    return (*others, *assemble(raws, others, fragments), *configurations)


def _object(of: Element, fragments: Fragments) -> None:
    fragments.report.mistake(
        line_of(of),
        f"The {name_of(of).lower()} {attribute(of, 'name')[:60]} is not supported",
        "functions, function blocks and actions",
        "Turn it into an action or into a function block of its own.",
    )


# ---- types


def read_type(of: Element | None, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    """A reference to a type: its name, or a type that is defined in place."""
    line = 1 if of is None else line_of(of)
    name = element(of, "TypeName")
    if name is not None:
        return _named(text_of(name).strip(), line_of(name), fragments)
    inner = element(of, "InstantlyDefinedType")
    if inner is not None:
        return _specified(inner, fragments, depth + 1)
    if of is not None and text_of(of).strip() and not elements(of):
        return _named(text_of(of).strip(), line, fragments)
    fragments.report.mistake(line, "The type is missing", "a TypeName or an InstantlyDefinedType")
    return _NOTHING


def _named(name: str, line: int, fragments: Fragments) -> tree.TypeSpec:
    """A type by its name, whose name space does not count."""
    if "[" not in name and "(" not in name:
        name = name.replace("\\", ".").rpartition(".")[2]
    return fragments.type(name, line)


def _specified(of: Element, fragments: Fragments, depth: int = 0) -> tree.TypeSpec:
    place, kind = tree.Place(line_of(of), 1), type_of(of)
    if depth > DEPTH:
        fragments.report.mistake(place.line, f"Types are nested more than {DEPTH} deep")
        return _NOTHING
    match kind:
        case "arraytypespec":
            base = read_type(element(of, "BaseType"), fragments, depth)
            ranges = (_range(element(d, "IndexRange"), fragments) for d in elements(of, "DimensionSpec"))
            return tree.ArraySpec(tuple(found for found in ranges if found is not None), base, place=place)
        case "structtypespec":
            fields = (variable(member, read_type, fragments) for member in elements(of, "Member"))
            return tree.StructSpec(tuple(found for found in fields if found is not None), place=place)
        case "enumtypespec" | "enumtypewithnamedvaluespec":
            return enumeration(of, elements(of, "Enumerator"), fragments)
        case "subrangetypespec":
            return _subrange(of, fragments, depth)
        case "directlyderivedtypespec" | "derivedtypespec":
            return read_type(element(of, "BaseType"), fragments, depth)
    fragments.report.mistake(
        place.line, f"The type specification {kind[:40] or 'without xsi:type'} is not known", "an array, structure, "
        "enumeration, subrange or derived type"
    )  # fmt: skip
    return _NOTHING


def _range(of: Element | None, fragments: Fragments) -> tree.Range | None:
    if of is None:
        return None
    low = fragments.expression(attribute(of, "lower"), line_of(of))
    high = fragments.expression(attribute(of, "upper"), line_of(of))
    return None if low is None or high is None else tree.Range(low, high, place=tree.Place(line_of(of), 1))


def _subrange(of: Element, fragments: Fragments, depth: int) -> tree.TypeSpec:
    base = read_type(element(of, "BaseType"), fragments, depth)
    limits = next((_range(e, fragments) for e in (*elements(of), of) if attribute(e, "lower")), None)
    if limits is None or not isinstance(base, tree.NamedType):
        fragments.report.mistake(line_of(of), "The subrange is incomplete", "a range and an integer type")
        return base
    return tree.SubrangeSpec(base, limits.low, limits.high, place=tree.Place(line_of(of), 1))


def _type_declaration(of: Element, fragments: Fragments) -> tree.TypeDeclaration | None:
    name, line = attribute(of, "name").strip(), line_of(of)
    if not fragments.is_name(name, line, "a type"):
        return None
    with fragments.report.inside(f"type {name[:60]}"):
        specification = element(of, "UserDefinedTypeSpec")
        if specification is None:
            fragments.report.mistake(line, "The type has no specification", "a UserDefinedTypeSpec")
            return None
        spec = _specified(specification, fragments)
        start = initial(element(specification, "InitialValue"), spec, fragments)
        comments = comment_of(element(of, "Documentation"))
        return tree.TypeDeclaration(name, spec, start, comments=comments, place=tree.Place(line, 1))


# ---- POUs


def _pou(of: Element, fragments: Fragments) -> Raw | None:
    name, line, kind, report = attribute(of, "name").strip(), line_of(of), _POUS[name_of(of)], fragments.report
    if not fragments.is_name(name, line, "a POU"):
        return None
    with report.inside(f"{kind.value} {name[:60]}"):
        lists = [*elements(element(of, "Parameters"), *_PARAMETERS), *elements(of, *_LISTS)]
        blocks = [b for found in lists if (b := section(found, read_type, fragments)) is not None and b.variables]
        raw = Raw(kind, name, line, comments=comment_of(element(of, "Documentation")))
        raw.blocks = tuple(blocks) or plain_text(element(of, "AddData"), fragments)
        if kind is tree.PouKind.FUNCTION:
            result = element(of, "ResultType")
            raw.result = read_type(result, fragments) if result is not None else tree.NamedType("BOOL")
            if result is None:
                report.note(line, "The function declares no result; BOOL is assumed")
        body = element(of, "MainBody")
        raw.bodies = [] if body is None else read_bodies(body, report)
        raw.actions = [part for e in elements(of, "Action") for part in _part(e, fragments)]
        raw.transitions = [part for e in elements(of, "Transition") for part in _part(e, fragments)]
        for method in elements(of, "Method"):
            _object(method, fragments)
        return raw


def _part(of: Element, fragments: Fragments) -> list[Part]:
    with fragments.report.inside(f"{name_of(of).lower()} {attribute(of, 'name')[:60]}"):
        comments = comment_of(element(of, "Documentation"))
        bodies = read_bodies(of, fragments.report)[:1]
        return [Part(attribute(of, "name").strip(), line_of(of), drawn, comments) for drawn in bodies]


# ---- tasks


def _resource(of: Element, fragments: Fragments) -> tree.Configuration | None:
    tasks = [_task(e, fragments) for e in elements(of, "Task")]
    programs = [_instance(e) for e in elements(of, "ProgramInstance")]
    free = [program for program in programs if not program.task]
    programs = [program for program in programs if program.task]
    if free:
        program_without_task(tasks, programs, free)
    return resource_of(of, tasks, programs) if tasks else None


def _instance(of: Element) -> tree.ProgramInstance:
    name = attribute(of, "name").strip()
    kind = attribute(of, "typeName").strip() or name
    return tree.ProgramInstance(
        name, attribute(of, "associatedTaskName").strip(), kind, place=tree.Place(line_of(of), 1)
    )


def _task(of: Element, fragments: Fragments) -> tree.TaskDeclaration:
    line, name = line_of(of), attribute(of, "name").strip()
    fragments.is_name(name, line, "a task")
    priority, interval, single = (attribute(of, key).strip() for key in ("priority", "interval", "single"))
    with fragments.report.inside(f"task {name[:60]}"):
        return tree.TaskDeclaration(
            name,
            fragments.expression(priority, line) if priority else None,
            duration(interval, line, fragments) if interval else None,
            fragments.expression(single, line) if single else None,
            place=tree.Place(line, 1),
        )
