"""The facts of points, for tools and forms: the same in real and in virtual time."""

from pathlib import Path

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.device import Point
from fieldrig.points.facts import facts_of
from fieldrig.virtual.rig import Rig

CONFIGS = Path(__file__).parents[3] / "configs"
RIG = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual"}, "mb": {"kind": "modbus.virtual"}},
    "devices": {
        "io": {"kind": "canopen.node", "node_id": 5, "eds": "eds/io32.eds", "links": {"can": "can0"}},
        "pump": {"kind": "modbus.device", "table": "registers/pump-drive.yaml", "links": {"modbus": "mb"}},
    },
}


def test_a_plain_point_has_unit_description_and_access() -> None:
    facts = facts_of({"level": Point(lambda: 1.0, None, "m", "of the water")})
    assert facts == {"level": {"unit": "m", "about": "of the water", "writable": False}}


def test_limits_of_zero_are_limits() -> None:
    facts = facts_of({"x": Point(lambda: 1, lambda value: None, low=0, high=0, type="U8", states=("a", "b"))})
    assert facts["x"] == {
        "unit": "", "about": "", "writable": True, "type": "U8", "low": 0, "high": 0, "states": ["a", "b"],
    }  # fmt: skip


@pytest.mark.parametrize("processes", ["one", pytest.param("each", marks=pytest.mark.long)])
def test_an_object_and_a_register_say_their_type_and_limits(processes: str) -> None:
    with Rig(from_dict({**RIG, "processes": processes}, CONFIGS)) as rig:
        output, speed = rig.facts("io")["6200:01"], rig.facts("pump")["speed_set"]
    assert output == {
        "unit": "", "about": "Write outputs byte 1", "writable": True, "type": "UNSIGNED8", "low": 0, "high": 255,
    }  # fmt: skip
    assert speed["type"] == "u16, holding register 0"
    assert (speed["low"], speed["high"], speed["unit"]) == (0, 100, "%")
