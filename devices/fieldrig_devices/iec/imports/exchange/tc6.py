"""A project of PLCopen TC6, versions 1.0 to 2.01: types, POUs, global variables and tasks.

Source: schema TC6 2.01 (2009) by its public facts.  The tools of the CODESYS family put POUs, types, lists of global
variables and applications also into `addData`; they are found wherever they are.
"""

import re
from dataclasses import replace
from typing import Final

from lxml import etree

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.assembly import Part, Raw, assemble
from fieldrig_devices.iec.imports.exchange import tc6_added, tc6_objects
from fieldrig_devices.iec.imports.exchange.declared import Element, initial, plain_text, section
from fieldrig_devices.iec.imports.exchange.tasks import duration, program_without_task, resource_of
from fieldrig_devices.iec.imports.exchange.tc6_bodies import read_body
from fieldrig_devices.iec.imports.exchange.tc6_types import read_declaration, read_type
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import (
    attribute,
    comment_of,
    element,
    elements,
    line_of,
    name_of,
    text_of,
)  # fmt: skip

_MIXED: Final = "MixedAttrsVarList"
_POUS: Final = {
    "program": tree.PouKind.PROGRAM,
    "function": tree.PouKind.FUNCTION,
    "functionblock": tree.PouKind.FUNCTION_BLOCK,
}


def read_project(root: Element, fragments: Fragments) -> tuple[tree.Declaration, ...]:
    """Everything that a `project` declares, or a single `pou` as a document of its own."""
    tc6_added.note_what_is_left_out(root, fragments)
    declared = [e for name in ("dataType", "union") for e in _built(root, name, fragments)]
    types = [d for e in declared if (d := read_declaration(e, fragments)) is not None]
    globals_ = [
        block for e in _built(root, "globalVars", fragments) if not _is_of_pou(e) for block in _globals(e, fragments)
    ]
    for left_out in _all(root, "accessVars"):
        section(left_out, read_type, fragments)
    config = [block for e in _all(root, "configVars") if (block := _config(e, fragments)) is not None]
    named = tc6_objects.interfaces(root)
    known = frozenset(attribute(e, "name").strip().casefold() for e in named)
    prototypes = [i for e in named if (i := tc6_objects.interface(e, fragments, known)) is not None]
    pous = [e for e in _built(root, "pou", fragments) if not _is_of_pou(e)]
    raws = [raw for e in pous if (raw := _pou(e, fragments, known)) is not None]
    configurations = [
        configuration for e in _all(root, "resource") if (configuration := _resource(e, fragments)) is not None
    ]
    others: list[tree.Declaration] = [*types, *globals_, *config, *prototypes]
    return (*others, *assemble(raws, others, fragments), *configurations)


def _all(root: Element, name: str) -> list[Element]:
    return [child for child in root.iter() if name_of(child) == name]


def _built(root: Element, name: str, fragments: Fragments) -> list[Element]:
    """Return the elements of this name that are not excluded from the build."""
    return [child for child in _all(root, name) if not tc6_added.is_excluded(child, fragments)]


def _is_of_pou(node: Element) -> bool:
    """True for global variables that a POU declares, for POUs inside of a POU, and for parts of a list."""
    return any(name_of(parent) in ("pou", _MIXED) for parent in node.iterancestors())


def _globals(node: Element, fragments: Fragments) -> list[tree.Variables]:
    with fragments.report.inside(f"global variables {attribute(node, 'name')}".strip()):
        list_ = section(node, read_type, fragments)
        if list_ is None or list_.variables:
            return [] if list_ is None else _mixed(node, list_, fragments)
        blocks = list(plain_text(node, fragments))
        for block in blocks:
            block.name = attribute(node, "name")
        return blocks


def _mixed(node: Element, whole: tree.Variables, fragments: Fragments) -> list[tree.Variables]:
    """The parts of a list of which only some variables are CONSTANT or RETAIN, as the CODESYS family writes it."""
    inner = (e for added in node.iter(f"{{*}}{_MIXED}") for e in elements(added, "globalVars"))
    parts = [part for e in inner if (part := section(e, read_type, fragments)) is not None and part.variables]
    if not parts:
        return [whole]
    known = {variable.name.casefold() for part in parts for variable in part.variables}
    for part in parts:
        part.name = whole.name
    rest = tuple(variable for variable in whole.variables if variable.name.casefold() not in known)
    parts[0].comments = whole.comments
    return [replace(whole, variables=rest, comments=()), *parts] if rest else parts


def _config(node: Element, fragments: Fragments) -> tree.Variables | None:
    """VAR_CONFIG: addresses and start values of variables inside of instances."""
    variables: list[tree.Variable] = []
    for item in elements(node, "configVariable"):
        line = line_of(item)
        spec = read_type(element(item, "type"), fragments)
        address = attribute(item, "address")
        variables.append(
            tree.Variable(
                attribute(item, "instancePathAndName").strip(),
                spec,
                initial(element(item, "initialValue"), spec, fragments),
                fragments.address(address, line) if address.strip() else None,
                position=tree.Position(line, 1),
            )
        )
    return (
        tree.Variables(tree.Section.CONFIG, tuple(variables), position=tree.Position(line_of(node), 1))
        if variables
        else None
    )


def _pou(node: Element, fragments: Fragments, interfaces: frozenset[str]) -> Raw | None:
    name, line, report = attribute(node, "name").strip(), line_of(node), fragments.report
    kind = _POUS.get(attribute(node, "pouType").casefold())
    if kind is None:
        report.mistake(line, f"The POU {name[:60]} has the type {attribute(node, 'pouType')[:40]}", ", ".join(_POUS))
        return None
    if not fragments.is_name(name, line, "a POU"):
        return None
    with report.inside(f"{kind.value} {name[:60]}"):
        interface = element(node, "interface")
        result = element(interface, "returnType")
        raw = Raw(kind, name, line, comments=comment_of(element(node, "documentation")))
        raw.blocks = tc6_objects.blocks(node, interface, fragments)
        if kind is tree.PouKind.FUNCTION:
            raw.result = read_type(result, fragments) if result is not None else None
            if result is None and not fragments.dialect.has_void_functions:
                raw.result = tree.NamedType("BOOL")
                report.note(line, "The function declares no result; BOOL is assumed")
        raw.bodies = [drawn for body in elements(node, "body") if (drawn := read_body(body, report)) is not None]
        raw.actions = _parts(element(node, "actions"), "action", fragments)
        raw.transitions = _parts(element(node, "transitions"), "transition", fragments)
        raw.methods = tc6_objects.methods(node, fragments)
        raw.modifiers = tc6_objects.modifiers(node, fragments)
        tc6_objects.inherit(raw, interface, fragments, interfaces)
        return raw


def _parts(node: Element | None, name: str, fragments: Fragments) -> list[Part]:
    parts: list[Part] = []
    for part in elements(node, name):
        body = element(part, "body")
        with fragments.report.inside(f"{name} {attribute(part, 'name')[:60]}"):
            drawn = None if body is None else read_body(body, fragments.report)
        if drawn is not None:
            comments = comment_of(element(part, "documentation"))
            parts.append(Part(attribute(part, "name").strip(), line_of(part), drawn, comments))
    return parts


# ---- tasks


def _resource(node: Element, fragments: Fragments) -> tree.Configuration | None:
    tasks: list[tree.TaskDeclaration] = []
    programs: list[tree.ProgramInstance] = []
    for task in elements(node, "task"):
        with fragments.report.inside(f"task {attribute(task, 'name')[:60]}"):
            tasks.append(_task(task, fragments))
            programs += [_instance(e, tasks[-1].name) for e in elements(task, "pouInstance")]
    free = [_instance(e, "") for e in elements(node, "pouInstance")]
    if free:
        program_without_task(tasks, programs, free)
    return resource_of(node, tasks, programs) if tasks else None


def _instance(node: Element, task: str) -> tree.ProgramInstance:
    """An instance, whose type has the name `type` in version 1.01.

    The CODESYS family leaves the type empty, because it is the name.
    """
    name = attribute(node, "name").strip()
    kind = (attribute(node, "typeName") or attribute(node, "type")).strip()
    return tree.ProgramInstance(name, task, kind or name, position=tree.Position(line_of(node), 1))


def _task(node: Element, fragments: Fragments) -> tree.TaskDeclaration:
    line, name = line_of(node), attribute(node, "name").strip()
    fragments.is_name(name, line, "a task")
    interval, single = attribute(node, "interval").strip(), attribute(node, "single").strip()
    settings = next((e for e in node.iter() if name_of(e) == "TaskSettings"), None)
    kind = attribute(settings, "KindOfTask").casefold()
    if kind == "freewheeling":
        interval = ""
    elif kind in ("event", "status") and not single:
        single = attribute(settings, "Event").strip()
        interval = ""
    priority = re.sub(r"\s", "", attribute(node, "priority"))
    return tree.TaskDeclaration(
        name,
        fragments.expression(priority, line) if priority else None,
        duration(interval, line, fragments) if interval else None,
        fragments.expression(single, line) if single else None,
        comments=comment_of(element(node, "documentation")),
        position=tree.Position(line, 1),
    )


def is_project(root: Element) -> bool:
    """True for a document of TC6, whatever its version; some tools leave the name space out."""
    space = etree.QName(root).namespace or ""
    if space.startswith("http://www.plcopen.org/xml/"):
        return True
    return name_of(root) == "project" and not space and bool(text_of(root).strip() or elements(root, "types"))
