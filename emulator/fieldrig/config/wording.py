"""Messages for the author of a rig file about settings that pydantic refuses.

A message says what was found and what was expected, the latter from the JSON Schema of the model, which is generated
only for a mistake.
"""

import re
from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core.core_schema import DictSchema

from fieldrig.config.yaml_source import KeyPath
from fieldrig.settings import Settings, WrongKey, WrongSettingsError
from fieldrig.text.nearest import closest
from fieldrig.text.yaml_value import show

_KEY = "[key]"
"""The mark, in the place of a mistake, of one that is in a key itself and not in its value (pydantic)."""
TYPES = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a mapping of keys to values",
    "null": "null",
}


class _WithForms(GenerateJsonSchema):
    """Keeps the forms of the keys of a mapping that may have several, which JSON Schema leaves out otherwise."""

    def dict_schema(self, schema: DictSchema) -> JsonSchemaValue:
        made = super().dict_schema(schema)
        if "keys_schema" in schema and (forms := self.generate_inner(schema["keys_schema"])).get("anyOf"):
            made.setdefault("propertyNames", forms)
        return made


def explain(
    error: ValidationError, data: Any, model: type[Settings], other_keys: tuple[str, ...] = ()
) -> list[WrongKey]:
    """Return one mistake for each place.  `other_keys` are allowed beside those of the model."""
    schema = model.model_json_schema(schema_generator=_WithForms)
    by_path: dict[KeyPath, WrongKey] = {}
    deeper: set[KeyPath] = set()
    for detail in error.errors(include_url=False):
        path = _path_in(data, detail["loc"], detail["type"])
        deeper.update(path[:length] for length in range(len(path)))
        several = detail.get("ctx", {}).get("error")
        if isinstance(several, WrongSettingsError):
            inner = [wrong._replace(path=(*path, *wrong.path)) for wrong in several.wrong]
            by_path |= {wrong.path: wrong for wrong in inner}
        elif path not in by_path:
            by_path[path] = _wrong_key(dict(detail), path, data, schema, other_keys)
    # A union reports each of its choices; the deepest mistake belongs to the intended one.
    return [finding for path, finding in by_path.items() if path not in deeper]


def _wrong_key(detail: dict[str, Any], path: KeyPath, data: Any, schema: Any, other_keys: tuple[str, ...]) -> WrongKey:
    if detail["type"] == "extra_forbidden":
        known = _keys_at(schema, path[:-1], data) + (list(other_keys) if len(path) == 1 else [])
        return WrongKey(path, "there is no such key", closest(path[-1], known))
    if _KEY in detail["loc"]:
        forms = [leaf["propertyNames"] for leaf in _leaves_at(schema, path[:-1], data) if "propertyNames" in leaf]
        wanted = " or ".join(dict.fromkeys(_words({"type": "string", **form}, schema) for form in forms))
        return WrongKey(path, f"the key {show(path[-1])} doesn't fit", f"expected {wanted}" if wanted else "")
    if detail["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return _wrong_tag(detail, path, data, schema)
    wanted = " or ".join(dict.fromkeys(_words(part, schema) for part in _schemas_at(schema, schema, path, data)))
    remedy = f"expected {wanted}" if wanted else ""
    if detail["type"] == "missing":
        return WrongKey(path, "this key is missing", remedy)
    if detail["type"] in ("value_error", "assertion_error"):
        # of a whole mapping or list, such as limits that are reversed, its type is not what is wrong
        is_vague = not path or isinstance(_value_at(data, path), dict | list)
        what, _, own = str(detail["ctx"]["error"]).partition("\n")
        return WrongKey(path, what, own or ("" if is_vague else remedy))
    there = _value_at(data, path)
    return WrongKey(path, f"{show(there)} doesn't fit", remedy or f"it says: {detail['msg']}")


def _wrong_tag(detail: dict[str, Any], path: KeyPath, data: Any, schema: Any) -> WrongKey:
    """Return the mistake of a key that selects one of several models, but is unknown or missing."""
    key = detail["ctx"]["discriminator"].strip("'")
    choices = _schemas_at(schema, schema, (*path, key))
    known = sorted({str(tag) for part in choices for tag in part.get("enum", [part.get("const")])})
    there = _value_at(data, path)
    if key not in there:
        return WrongKey((*path, key), "this key is missing", f"expected {' or '.join(known)}")
    return WrongKey((*path, key), f"{show(there[key])} doesn't fit", closest(there[key], known))


def _path_in(data: Any, location: tuple[int | str, ...], error_type: str) -> KeyPath:
    """Return the location without the names of union branches, which are not keys of the data."""
    path: list[Any] = []
    for position, part in enumerate(location):
        key = _key_in(data, part)
        if key is not None:
            path.append(key)
            data = data[key]
        elif error_type == "missing" and position == len(location) - 1:
            path.append(part)
    return tuple(path)


def _key_in(data: Any, part: int | str) -> Any:
    if isinstance(data, dict):
        if part in data:  # found at once, so that the time is linear however many keys are wrong
            return part
        return next((key for key in data if str(key) == part), None)
    if isinstance(data, list) and isinstance(part, int) and part < len(data):
        return part
    return None


def _value_at(data: Any, path: KeyPath) -> Any:
    for part in path:
        data = data[part]
    return data


def _keys_at(schema: Any, path: KeyPath, data: Any) -> list[str]:
    return [key for leaf in _leaves_at(schema, path, data) for key in leaf.get("properties", ())]


def _leaves_at(schema: Any, path: KeyPath, data: Any) -> Iterator[Any]:
    """Yield every schema that may apply at a path, each choice of those that have a description by itself."""
    value = _value_at(data, path)
    for part in _schemas_at(schema, schema, path, data):
        for choice in part.get("anyOf") or part.get("oneOf") or [part]:
            yield from _schemas_at(choice, schema, (), value)


def _schemas_at(part: Any, root: Any, path: KeyPath, data: Any = None) -> Iterator[Any]:
    """Yield every schema that may apply at a path, through references and choices.

    Where a key of `data` selects one of several models, only that one applies.
    """
    if not isinstance(part, dict):
        return
    if "$ref" in part:
        target = root["$defs"][part["$ref"].rsplit("/", 1)[-1]]
        yield from _schemas_at({**target, **{key: part[key] for key in part if key != "$ref"}}, root, path, data)
        return
    chosen = _chosen(part, data)
    if chosen is not None:
        yield from _schemas_at(chosen, root, path, data)
        return
    choices = part.get("anyOf") or part.get("oneOf") or part.get("allOf")
    if choices and (path or "description" not in part):
        for choice in choices:
            yield from _schemas_at(choice, root, path, data)
    elif not path:
        yield part
    else:
        yield from _schemas_at(_child(part, path[0]), root, path[1:], _child_of(data, path[0]))


def _chosen(part: dict[str, Any], data: Any) -> Any:
    """Return the model that a key of the data selects; None if the choice is made in another way."""
    rule = part.get("discriminator")
    if rule is None or not isinstance(data, dict):
        return None
    target = rule["mapping"].get(str(data.get(rule["propertyName"])))
    return None if target is None else {"$ref": target}


def _child_of(data: Any, key: Any) -> Any:
    if isinstance(data, dict):
        return data.get(key)
    return data[key] if isinstance(data, list) and isinstance(key, int) and 0 <= key < len(data) else None


def _child(part: dict[str, Any], key: Any) -> Any:
    if isinstance(key, int) and "items" in part:
        return part["items"]
    if isinstance(key, int) and 0 <= key < len(part.get("prefixItems", ())):  # of a mapping it may be -1
        return part["prefixItems"][key]
    of_this_form = (child for form, child in part.get("patternProperties", {}).items() if re.search(form, str(key)))
    return part.get("properties", {}).get(key, next(of_this_form, part.get("additionalProperties")))


def _words(part: dict[str, Any], root: Any) -> str:
    """Return a description such as `a whole number from 1 to 127 (the node id)`."""
    choices = part.get("anyOf") or part.get("oneOf")
    if choices:
        leaves = [leaf for choice in choices for leaf in _schemas_at(choice, root, ())]
        words = " or ".join(dict.fromkeys(_words(leaf, root) for leaf in leaves))
    elif "enum" in part:
        words = " or ".join(str(value) for value in part["enum"])
    elif "const" in part:
        words = str(part["const"])
    elif part.get("format") == "path":
        words = "the path of a file"
    else:
        words = TYPES.get(part.get("type", ""), "") + _limits(part)
    about = part.get("description", "").split("\n\n")[0] if part.get("type") != "object" else ""
    return f"{words} ({about})" if words and about else words or about


def _limits(part: dict[str, Any]) -> str:
    low, high = part.get("minimum"), part.get("maximum")
    if low is not None and high is not None:
        return f" from {low} to {high}"
    if "examples" in part:
        return f" like {part['examples'][0]}"
    words = {
        "minimum": "of at least {}",
        "maximum": "of at most {}",
        "exclusiveMinimum": "above {}",
        "exclusiveMaximum": "below {}",
    }  # without `pattern`, a regular expression: a field that has one says its form by examples or in its description
    said = " and ".join(words[key].format(part[key]) for key in words if key in part)
    limits = f" {said}" if said else ""
    return limits + _length(part, "Length", "character") + _length(part, "Items", "item")


def _length(part: dict[str, Any], limited: str, one: str) -> str:
    """Return words such as ` of 1 to 40 characters`; "" without a limit."""
    low, high = part.get(f"min{limited}"), part.get(f"max{limited}")
    if low is None and high is None:
        return ""
    words = f"at most {high}" if low is None else f"at least {low}" if high is None else f"{low} to {high}"
    most = low if high is None else high
    return f" of {high if low == high else words} {one if most == 1 else f'{one}s'}"
