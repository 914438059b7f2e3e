"""The links, settings and faults of a kind of bus or device, as its class has them, for people and for JSON."""

from collections.abc import Iterator, Mapping
from typing import Any

import typer

from fieldrig.config import kinds
from fieldrig.errors import RigError
from fieldrig.faults.faults import keys_of
from fieldrig.faults.power import models_of_device
from fieldrig.text.nearest import closest

COMMON_FAULT_KEYS = ("what", "start_ms", "duration_ms")


def facts_of(kind: str) -> dict[str, Any]:
    """Return the facts of a kind.  BadParameter, with the nearest kind, for an unknown one."""
    links: dict[str, tuple[str, str]] = {}
    try:
        device = kinds.find_device(kind)
    except RigError as no_device:
        try:
            sort, cls = "bus", kinds.find_bus(kind)
        except RigError:
            every = [*kinds.installed(kinds.BUSES), *kinds.installed(kinds.DEVICES)]
            remedy = no_device.remedy if ":" in kind else closest(kind, every)
            raise typer.BadParameter(f"{no_device.what}; {remedy}") from no_device
        about, model, models = cls.about, kinds.settings_model(cls), cls.fault_models
    else:
        sort, about, model, models = "device", device.about, kinds.settings_model(device), models_of_device(device)
        for name, link in kinds.link_parameters(device).items():
            links[name] = (
                kinds.bus_kinds_of(link),
                f"{'one bus or several' if link.many else ''}{'' if link.required else ' (may be left out)'}",
            )
    faults = {what: _fault_keys(of) for what, of in models.items()}
    settings = settings_of(model)
    return {"sort": sort, "kind": kind, "about": about, "links": links, "settings": settings, "faults": faults}


def settings_of(model: Any) -> dict[str, dict[str, Any]]:
    """Return the keys of a model of settings: type, limits, default, whether it is required, and what it is."""
    schema = model.model_json_schema()
    return dict(_keys(schema, schema.get("$defs", {}), ""))


def without(setting: Mapping[str, Any]) -> str:
    """Return the value that holds without the key, as a rig file would have it."""
    default = setting["default"]
    if setting["required"]:
        return "needed"
    return "" if default is None else str(default).lower() if isinstance(default, bool) else str(default)


def _fault_keys(model: Any) -> str:
    """Return the keys of a fault beside its `what` and its times, in a line."""
    return " ".join(f"{key}=" for key in keys_of(model) if key not in COMMON_FAULT_KEYS)


def _keys(schema: dict[str, Any], models: dict[str, Any], above: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each key, and for a mapping with keys of its own those too: `slcan`, `slcan.path`."""
    required = schema.get("required", ())
    for key, part in schema.get("properties", {}).items():
        yield (
            f"{above}{key}",
            {
                "type": _type_of(part, models),
                "limits": _limits_of(part),
                "default": None if key in required else part.get("default"),
                "required": key in required,
                "about": part.get("description", "").partition("\n")[0],
            },
        )
        names = [choice["$ref"].rsplit("/", 1)[-1] for choice in (part, *part.get("anyOf", ())) if "$ref" in choice]
        if len(names) == 1:
            yield from _keys(models[names[0]], models, f"{above}{key}.")


def _limits_of(part: Mapping[str, Any]) -> str:
    """Return the range of a number, such as `1 to 127` or `above 0`; empty without one, and for several types."""
    numbers = [choice for choice in part.get("anyOf", (part,)) if choice.get("type") != "null"]
    if len(numbers) != 1:
        return ""
    match numbers[0]:
        case {"minimum": low, "maximum": high}:
            return f"{low} to {high}"
        case {"exclusiveMinimum": low, "maximum": high}:
            return f"above {low}, to {high}"
        case {"minimum": low, "exclusiveMaximum": high}:
            return f"from {low}, below {high}"
        case {"exclusiveMinimum": low, "exclusiveMaximum": high}:
            return f"between {low} and {high}"
        case {"minimum": low}:
            return f"{low} or more"
        case {"exclusiveMinimum": low}:
            return f"above {low}"
        case {"maximum": high}:
            return f"{high} or less"
        case {"exclusiveMaximum": high}:
            return f"below {high}"
    return ""


def _type_of(part: dict[str, Any], models: dict[str, Any]) -> str:
    """Return the type in a word or two, in those of JSON; a mapping with keys of its own is an object."""
    choices = part.get("anyOf") or part.get("oneOf")
    if choices:
        return " or ".join(
            dict.fromkeys(_type_of(choice, models) for choice in choices if choice.get("type") != "null")
        )
    if "enum" in part:
        return " or ".join(str(value) for value in part["enum"])
    if "const" in part:
        return str(part["const"])
    if "$ref" in part:
        return _type_of(models[part["$ref"].rpartition("/")[2]], models)
    return str(part.get("type", ""))
