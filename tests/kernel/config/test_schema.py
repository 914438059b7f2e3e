from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML

from fieldrig.config import kinds
from fieldrig.config.keys import BusKeys, DeviceKeys
from fieldrig.config.schema import json_schema, names, schema_of
from fieldrig.errors import RigError

CONFIGS = Path(__file__).parents[3] / "configs"


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return json_schema()


@pytest.fixture(scope="module")
def validator(schema: dict[str, Any]) -> Draft202012Validator:
    return Draft202012Validator(schema)


def wrong(validator: Draft202012Validator, data: Any) -> list[str]:
    """Return the places where the schema finds mistakes."""
    return sorted("/".join(map(str, error.absolute_path)) for error in validator.iter_errors(data))


@pytest.mark.long
def test_the_schema_is_one(validator: Draft202012Validator) -> None:
    Draft202012Validator.check_schema(validator.schema)


@pytest.mark.parametrize("file", sorted(CONFIGS.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_rig_of_ours_keeps_to_it(validator: Draft202012Validator, file: Path) -> None:
    assert wrong(validator, YAML(typ="safe", pure=True).load(file)) == []


def rig(**changes: Any) -> dict[str, Any]:
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 250_000}, "can1": {"kind": "can.virtual"}},
        "devices": {"bridge": {"kind": "can.bridge", "links": {"a": "can0", "b": "can1"}, "on_exit": "stop"}},
        **changes,
    }


def test_a_right_rig_is_right(validator: Draft202012Validator) -> None:
    assert wrong(validator, rig()) == []
    assert wrong(validator, {"time": "real", "buses": None}) == []


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"time": "soon"}, "time"),
        ({"sed": 1}, ""),
        ({"speed": 0}, "speed"),
        ({"buses": {"can0": {"kind": "can.virtual", "bitrate": 1}}}, "buses/can0/bitrate"),
        ({"buses": {"can0": {"kind": "can.virtual", "bitrat": 250_000}}}, "buses/can0"),
        ({"buses": {"can0": {"kind": "can.virtal"}}}, "buses/can0/kind"),
        ({"buses": {"can0": {}}}, "buses/can0"),
        ({"buses": {"Can0": {"kind": "can.virtual"}}}, "buses"),
        ({"devices": {"bridge": {"kind": "can.bridge", "links": {"a": "can0"}}}}, "devices/bridge/links"),
        ({"devices": {"bridge": {"kind": "can.bridge", "links": {"a": ["can0"], "b": "can1"}}}},
         "devices/bridge/links/a"),
    ],
)  # fmt: skip
def test_a_mistake_is_found(validator: Draft202012Validator, changes: dict[str, Any], where: str) -> None:
    assert wrong(validator, rig(**changes)) == [where]


def test_a_class_of_ones_own_may_have_any_keys(validator: Draft202012Validator) -> None:
    assert wrong(validator, rig(devices={"press": {"kind": "press:Press", "stroke_mm": 5}})) == []


def test_a_file_that_extends_another_may_leave_out_what_that_has(validator: Draft202012Validator) -> None:
    for extends in ("lab.yaml", ["lab.yaml", "cell.yaml"]):
        assert wrong(validator, {"extends": extends, "devices": {"io": {"node_id": 7}, "tank": None}}) == []
    assert wrong(validator, {"extends": [], "devices": {}}) != []


def test_keys_are_described(schema: dict[str, Any]) -> None:
    definitions = schema["$defs"]
    assert definitions["can.virtual"]["properties"]["bitrate"]["description"].startswith("bit/s")
    links = definitions["can.bridge"]["properties"]["links"]["properties"]
    kind = "can.hub or can.socketcan or can.udp or can.virtual"
    assert links["a"] == {"type": "string", "description": f"a bus of kind {kind}"}


@pytest.mark.parametrize("kind", kinds.list_buses(), ids=lambda kind: kind.name)
def test_no_bus_has_a_setting_that_is_a_key_of_every_bus(kind: kinds.Kind) -> None:
    settings = kinds.settings_model(kinds.find_bus(kind.name)).model_fields
    assert not settings.keys() & BusKeys.model_fields.keys()


@pytest.mark.parametrize("kind", kinds.list_devices(), ids=lambda kind: kind.name)
def test_no_device_has_a_setting_that_is_a_key_of_every_device(kind: kinds.Kind) -> None:
    settings = kinds.settings_model(kinds.find_device(kind.name)).model_fields
    assert not settings.keys() & DeviceKeys.model_fields.keys()


FILES = {"register-table": "registers", "name-plate": "plates"}


@pytest.mark.long
def test_the_files_that_rig_files_name_have_schemas() -> None:
    assert names() == ["rig", *sorted(FILES)]
    assert schema_of("rig") == json_schema()
    with pytest.raises(RigError, match=r"did you mean register-table\?"):
        schema_of("register-tables")


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "file"), [(name, file) for name, folder in FILES.items() for file in sorted((CONFIGS / folder).iterdir())]
)
def test_every_such_file_of_ours_keeps_to_its_schema(name: str, file: Path) -> None:
    schema = schema_of(name)
    Draft202012Validator.check_schema(schema)
    assert wrong(Draft202012Validator(schema), YAML(typ="safe", pure=True).load(file)) == []


@pytest.mark.parametrize(
    ("table", "where"),
    [
        ({"coil": []}, ""),
        ({"coils": [{"address": 70_000, "name": "run"}]}, "coils/0/address"),
        ({"holding_registers": [{"address": 0, "name": "speed", "type": "u17"}]}, "holding_registers/0/type"),
        ({"holding_registers": [{"address": 0, "name": "speed", "min": "low"}]}, "holding_registers/0/min"),
        ({"input_registers": [{"name": "speed"}]}, "input_registers/0"),
        ({"fifos": [{"address": 0, "name": "queue", "depth": 0}]}, "fifos/0/depth"),
    ],
)
def test_a_register_table_that_is_wrong_is_wrong_by_its_schema(table: dict[str, Any], where: str) -> None:
    assert wrong(Draft202012Validator(schema_of("register-table")), table) == [where]
