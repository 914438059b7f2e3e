"""A fault as it is given to a running bus: by a test as plain values, by `fieldrig fault` as texts."""

from collections.abc import Mapping
from typing import Any, Final, get_args

from pydantic import ValidationError

from fieldrig.wording import closest, explain
from fieldrig.yaml_source import key_text, read
from fieldrig_bus.can.faults import CanFault

MODELS: Final = {get_args(model.model_fields["what"].annotation)[0]: model for model in get_args(get_args(CanFault)[0])}
TEXTS: Final = frozenset({"what", "node", "data", "xor", "level"})
"""Keys whose values are texts, even where YAML would see a number: data 0102, or a node named 5."""


def fault_of(given: Mapping[str, Any]) -> CanFault:
    """ValueError if that is no fault: what is wrong, and on further lines what would be right."""
    what = given.get("what")
    model = MODELS.get(what) if isinstance(what, str) else None
    if model is None:
        wrong = f"there is no fault {what!r}" if "what" in given else "what: this key is missing"
        raise ValueError(f"{wrong}\n{closest(what, list(MODELS))}")
    values = {key: _value(key, value) for key, value in given.items()}
    try:
        fault: CanFault = model.model_validate(values)
    except ValidationError as cause:
        found = explain(cause, values, model)
        lines = [(f"{key_text(one.path)}: {one.what}".removeprefix(": "), one.remedy) for one in found]
        raise ValueError("\n".join(line for both in lines for line in both if line)) from cause
    return fault


def _value(key: str, value: Any) -> Any:
    if key in TEXTS or not isinstance(value, str):
        return value
    source = read(value, "")
    if source.mistakes:
        raise ValueError(f"{key}: {value!r} is not a value as in a rig file\n{source.mistakes[0].what}")
    return source.data
