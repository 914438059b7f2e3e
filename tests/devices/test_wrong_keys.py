"""The keys of mappings in settings: a wrong key, and a wrong value under one, is named with what is expected."""

from collections.abc import Iterator
from importlib.metadata import entry_points
from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig.config.kinds import settings_model
from fieldrig.config.wording import _WithForms, explain
from fieldrig.settings import Settings

WRONG = "? no key"
KINDS = sorted(
    (point for group in ("fieldrig.devices", "fieldrig.buses") for point in entry_points(group=group)),
    key=lambda point: point.name,
)


def mappings(part: Any, root: Any, depth: int = 0) -> Iterator[tuple[str, ...]]:
    """Yield the paths of the mappings whose keys have a form, without those inside of lists and of mappings."""
    if "$ref" in part:
        part = root["$defs"][part["$ref"].rsplit("/", 1)[-1]]
    if "patternProperties" in part or "propertyNames" in part:
        yield ()
    for choice in [*part.get("anyOf", ()), *part.get("oneOf", ())]:
        yield from mappings(choice, root, depth)
    for key, child in part.get("properties", {}).items() if depth < 3 else ():
        for path in mappings(child, root, depth + 1):
            yield (key, *path)


def found() -> list[tuple[type[Settings], tuple[str, ...]]]:
    models = {settings_model(point.load()): None for point in KINDS}
    return [
        (model, path)
        for model in models
        for schema in [model.model_json_schema(schema_generator=_WithForms)]
        for path in dict.fromkeys(mappings(schema, schema))
    ]


@pytest.mark.parametrize(
    ("model", "path"), [pytest.param(*each, id=f"{each[0].__name__} {'.'.join(each[1])}") for each in found()]
)
def test_a_wrong_key_of_a_mapping_is_named_with_the_form_of_keys(model: type[Settings], path: tuple[str, ...]) -> None:
    data: dict[str, Any] = {WRONG: object()}
    for key in reversed(path):
        data = {key: data}
    with pytest.raises(ValidationError) as refused:
        model.model_validate(data)
    wrong = {found.path: found for found in explain(refused.value, data, model)}
    found_key = wrong[(*path, WRONG)]
    assert found_key.what == f'the key "{WRONG}" doesn\'t fit'
    assert found_key.remedy.startswith("expected ")
    assert "^" not in found_key.remedy
