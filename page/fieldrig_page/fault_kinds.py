"""The faults that the parts of a rig can suffer, as JSON schemas, from which the page makes its forms."""

from functools import cache
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.faults.faults import keys_of
from fieldrig.faults.power import models_of_device


def kinds_of(config: RigConfig) -> dict[str, Any]:
    """Return what each part of a rig can suffer.

    `parts` has for each bus and device its kind, its members if it is a bus, and why it takes no faults if it takes
    none; `kinds` has a JSON schema for each fault of each kind, because a machine has many parts of one kind.
    """
    parts: dict[str, Any] = {}
    kinds: dict[str, Any] = {}
    for name, bus in config.buses.items():
        parts[name] = {"sort": "bus", "kind": bus.kind, "members": list(bus.members), "none": bus.bus.no_faults}
        kinds.setdefault(bus.kind, bus.bus.fault_models)
    for name, device in config.devices.items():
        parts[name] = {"sort": "device", "kind": device.kind, "members": [], "none": device.cls.no_faults}
        kinds.setdefault(device.kind, models_of_device(device.cls))
    schemas = {kind: {what: _schema(model) for what, model in models.items()} for kind, models in kinds.items()}
    return {"parts": parts, "kinds": schemas}


@cache
def _schema(model: type[Any]) -> dict[str, Any]:
    """Return the schema of a fault without `what`, its keys in the order of the docs."""
    schema: dict[str, Any] = model.model_json_schema()
    known = schema["properties"]
    properties = {key: known[key] for key in keys_of(model) if key != "what"}
    required = [key for key in schema.get("required", []) if key != "what"]
    about = (model.__doc__ or "").strip().partition("\n")[0]
    return {"about": about, "properties": properties, "required": required, "$defs": schema.get("$defs", {})}
