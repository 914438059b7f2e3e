"""JSON Schema (draft 2020-12) of a rig file over all installed kinds, so that an editor completes and explains keys.

What a schema cannot say (links that fit, names that exist, classes of one's own) is left to `fieldrig check`.

Files that a rig file names have schemas of their own: an entry point of the group "fieldrig.schemas" names the
`Settings` model of such a file.
"""

from collections.abc import Callable, Iterable
from typing import Any, Final

from fieldrig.config import kinds
from fieldrig.config.keys import NAME, BusKeys, DeviceKeys, RigKeys
from fieldrig.config.kinds import Kind, LinkParameter
from fieldrig.device import FAULTS_KEY, POWER_OFF, Device
from fieldrig.errors import RigError
from fieldrig.settings import Settings
from fieldrig.text.nearest import closest

Schema = dict[str, Any]
DRAFT: Final = "https://json-schema.org/draft/2020-12/schema"
RIG: Final = "rig"
SCHEMAS: Final = "fieldrig.schemas"


def names() -> list[str]:
    """Return the names of all schemas."""
    return [RIG, *kinds.installed(SCHEMAS)]


def schema_of(name: str) -> Schema:
    """Return a schema.  RigError, with the known names, for an unknown one."""
    if name == RIG:
        return json_schema()
    point = kinds.installed(SCHEMAS).get(name)
    if point is None:
        raise RigError(f'there is no schema of "{name}"', closest(name, names()))
    model: type[Settings] = point.load()
    return {"$schema": DRAFT, **model.model_json_schema(), "title": f"fieldrig {name}"}


def json_schema() -> Schema:
    definitions: Schema = {}
    rig = _of_model(RigKeys, "rig", definitions)
    buses = _of_model(BusKeys, "bus", definitions)["properties"]
    devices = _of_model(DeviceKeys, "device", definitions)["properties"]
    installed_buses, installed_devices = kinds.list_buses(), kinds.list_devices()
    _add_kinds(installed_buses, kinds.find_bus, buses, definitions)
    _add_kinds(installed_devices, kinds.find_device, devices, definitions)
    with_kind = {"additionalProperties": {"required": ["kind"]}}
    return {
        "$schema": DRAFT,
        "title": "fieldrig rig file",
        "type": "object",
        "properties": {
            "extends": {
                "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}],
                "description": "the rig file, or the rig files, that this one is laid over, relative to this one",
            },
            **rig["properties"],
            "buses": _section(installed_buses, buses, definitions, "the buses, by name"),
            "devices": _section(installed_devices, devices, definitions, "the devices, by name"),
        },
        "additionalProperties": False,
        # What a file leaves out, the one that it extends may have.
        "if": {"required": ["extends"]},
        "else": {"required": rig["required"], "properties": {"buses": with_kind, "devices": with_kind}},
        "$defs": definitions,
    }


def _of_model(model: type[Settings], prefix: str, definitions: Schema) -> Schema:
    """Return the schema of a model; the models it refers to go into `definitions`, under names of their own."""
    schema = model.model_json_schema(ref_template=f"#/$defs/{prefix}.{{model}}")
    definitions |= {f"{prefix}.{name}": part for name, part in schema.pop("$defs", {}).items()}
    return schema


def _add_kinds(listed: Iterable[Kind], find: Callable[[str], type[Any]], common: Schema, definitions: Schema) -> None:
    for kind in listed:
        try:
            cls = find(kind.name)
        except RigError:
            continue  # a library that it needs is not installed: nothing is known of its keys
        settings = _of_model(kinds.settings_model(cls), kind.name, definitions)
        definitions[kind.name] = {
            "properties": {
                **common,
                **_links_of(cls, common),
                **_faults_of(cls),
                **settings.get("properties", {}),
            },
            "required": ["kind", *settings.get("required", [])],
            "additionalProperties": False,
        }


def _section(listed: list[Kind], common: Schema, definitions: Schema, about: str) -> Schema:
    """Return the schema of entries by name, each with the keys of its kind, or with any keys for a class of the user's
    own.
    """
    known = [{"const": kind.name, "description": kind.about} for kind in listed]
    own = {"type": "string", "pattern": ":", "description": '"module:Class", a class of your own'}
    by_kind = [
        {
            "if": {"properties": {"kind": {"const": kind.name}}, "required": ["kind"]},
            "then": {"$ref": f"#/$defs/{kind.name}"},
        }
        for kind in listed
        if kind.name in definitions
    ]
    return {
        "type": ["object", "null"],
        "description": about,
        "propertyNames": {"pattern": NAME},
        "additionalProperties": {
            "type": ["object", "null"],
            "properties": {**common, "kind": {**common["kind"], "anyOf": [*known, own]}},
            "allOf": by_kind,
        },
    }


def _links_of(cls: type[Any], common: Schema) -> Schema:
    if "links" not in common:
        return {}
    parameters = kinds.link_parameters(cls)
    return {
        "links": {
            **common["links"],
            "properties": {name: _link(parameter) for name, parameter in parameters.items()},
            "required": [name for name, parameter in parameters.items() if parameter.required],
            "additionalProperties": False,
        }
    }


def _faults_of(cls: type[Any]) -> Schema:
    """Return the key that every device has for its faults, with their names."""
    if not issubclass(cls, Device):
        return {}
    what = {"type": "string", "enum": list(dict.fromkeys((POWER_OFF, *cls.fault_models)))}
    fault = {"type": "object", "required": ["what"], "properties": {"what": what}}
    return {FAULTS_KEY: {"type": "array", "items": fault, "description": "faults that it has from the start"}}


def _link(parameter: LinkParameter) -> Schema:
    about = f"a bus of kind {kinds.bus_kinds_of(parameter)}"
    if not parameter.many:
        return {"type": "string", "description": about}
    either = [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": int(parameter.required)}]
    return {"anyOf": either, "description": f"{about}, or a list of them"}
