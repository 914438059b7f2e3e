"""Additions of tools to PLCopen TC6 in `addData`, beside those in `tc6_objects.py`: none that matters is lost.

Source: exports of CODESYS V3.5 by their public form.  `inputassignments` has the arguments of FB_init, with names or
by position, and `buildproperties` may exclude an object.  Data that is not read here is named in a note.
"""

from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, line_of, name_of, text_of

_READ: Final = frozenset((
    "application", "resource", "configuration", "pou", "globalvars", "datatype", "union", "method", "property",
    "interface", "inheritance", "pouinheritance", "datatypeinheritance",
    "accessmodifiers", "interfaceasplaintext", "mixedattrsvarlist",
    "attributes", "buildproperties", "inputassignments", "tasksettings", "stcode", "sfc", "fbdcalltype", "cfccalltype",
    "ldcalltype", "calltype", "fbdelementtype",
))  # fmt: skip
"""The names of data that is read, in this package, behind `plcopenxml/`."""
_WITHOUT_MEANING: Final = frozenset((
    "objectid", "projectstructure", "projectinformation", "folder", "enumvaluedocumentation", "inputparamtypes",
    "outputparamtypes", "ldparallelbranch", "textlist", "globaltextlist", "imagepool", "visualization", "libraries",
    "libraryset", "device", "devices", "position", "sfcelementguid",
))  # fmt: skip
"""Data that a controller does not need: identifiers, folders, pictures, and the types of pins that are known."""
_LEFT_OUT: Final = frozenset((
    "call_after_init", "call_after_online_change_slot", "global_init_slot", "no_init", "noinit", "no-init",
    "init_on_onlchange", "pack_mode", "enable_dynamic_creation",
))  # fmt: skip
"""Attributes of declarations that change what a variable or block does, and that fieldrig does not have."""


def note_what_is_left_out(root: Element, fragments: Fragments) -> None:
    """Name each kind of added data that is not read, and each attribute that would change what a program does, once."""
    seen: set[str] = set()
    for data in root.iter("{*}data"):
        name = attribute(data, "name").strip()
        key = name.casefold().rpartition("plcopenxml/")[2].partition("/")[0]
        if key not in _READ and key not in _WITHOUT_MEANING and key not in seen:
            seen.add(key)
            fragments.report.note(line_of(data), f"The added data {name[:80] or 'without a name'} is left out")
    for added in root.iter("{*}Attribute"):
        name = attribute(added, "Name").strip()
        if name.casefold() in _LEFT_OUT and name.casefold() not in seen:
            seen.add(name.casefold())
            fragments.report.note(line_of(added), f"The attribute {name} is left out")


def is_excluded(node: Element, fragments: Fragments) -> bool:
    """True for an object that the tool does not build; a note names it."""
    own = (data for added in elements(node, "addData") for data in elements(added, "data"))
    flags = (flag for data in own for build in elements(data, "BuildProperties") for flag in elements(build))
    is_out = any(name_of(flag) == "ExcludeFromBuild" and text_of(flag).strip().casefold() == "true" for flag in flags)
    if is_out:
        fragments.report.note(
            line_of(node), f"{attribute(node, 'name')[:60]} is left out: it is excluded from the build"
        )
    return is_out


def with_arguments(node: Element, spec: tree.TypeSpec, fragments: Fragments) -> tree.TypeSpec:
    """Return the type of a variable with the arguments of FB_init, `m : Meter(address := 7);`."""
    added = (data for part in elements(node, "addData") for data in elements(part, "data"))
    lists = [list_ for data in added for list_ in elements(data, "InputAssignments")]
    rows = tuple(row for list_ in lists if (row := _arguments(list_, fragments)))
    base = spec.element if isinstance(spec, tree.ArraySpec) else spec
    if not rows:
        return spec
    if not fragments.dialect.has_constructors:
        what = "The variable has arguments for FB_init"
        fragments.report.mistake(line_of(node), what, "a declaration without arguments", "Choose the dialect codesys.")
        return spec
    if not isinstance(base, tree.NamedType):
        fragments.report.mistake(
            line_of(node), "The variable has arguments for FB_init", "a function block as its type"
        )
        return spec
    made = tree.NamedType(base.name, *((rows[0], ()) if len(rows) == 1 else ((), rows)), position=base.position)
    if isinstance(spec, tree.ArraySpec):
        return tree.ArraySpec(spec.dimensions, made, position=spec.position)
    return made


def _arguments(node: Element, fragments: Fragments) -> tuple[tree.Argument, ...]:
    arguments: list[tree.Argument] = []
    for part in elements(node, "InputAssignment"):
        line, value = line_of(part), text_of(element(part, "Value"))
        given = fragments.expression(value, line)
        if given is not None:
            name = text_of(element(part, "Name")).strip()
            arguments.append(tree.Argument(given, name, position=tree.Position(line, 1)))
    return tuple(arguments)
