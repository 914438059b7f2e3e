"""A fault that names a member or a unit which its bus does not have is refused, in the rig file and at run time."""

from typing import Any

import pytest

from fieldrig import ConfigError, ControlError, Rig, from_dict

TABLE = "configs/registers/pump-drive.yaml"
RIG: dict[str, Any] = {
    "time": "real",
    "buses": {
        "can0": {"kind": "can.hub", "bitrate": 1_000_000},
        "tcp": {"kind": "modbus.tcp", "listen": "127.0.0.1:5020"},
        "rtu": {"kind": "modbus.rtu", "pty": "rtu"},
        "ua": {"kind": "opcua.server", "listen": "127.0.0.1:4840"},
    },
    "devices": {
        "line": {"kind": "max4", "links": {"opcua": "ua"}},
        "axis": {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can0"}},
        "pump": {"kind": "modbus.device", "units": {7: {"table": TABLE}}, "links": {"modbus": "tcp"}},
        "fan": {"kind": "modbus.device", "units": {"8-9": {"table": TABLE}}, "links": {"modbus": "rtu"}},
    },
}
WRONG: list[tuple[str, dict[str, Any], str, str]] = [
    ("can0", {"what": "drop", "node": "axsi"}, "node", "axis"),
    ("can0", {"what": "drop", "receivers": ["axis", "nix"]}, "receivers", "axis"),
    ("can0", {"what": "wrong_bit_rate", "node": "pump", "bitrate": 500_000}, "node", "axis"),
    ("can0", {"what": "babble", "node": "axes", "identifier": 5}, "node", "axis"),
    ("ua", {"what": "drop", "device": "axis"}, "device", "line"),
    ("tcp", {"what": "exception", "unit": 99}, "unit", "there are: 7"),
    ("rtu", {"what": "delay", "unit": 7, "delay_ms": 3}, "unit", "there are: 8, 9"),
]  # fmt: skip
RIGHT: list[tuple[str, dict[str, Any]]] = [
    ("can0", {"what": "drop", "node": "socketcand:1"}),  # a member from outside
    ("can0", {"what": "drop", "node": "axis"}),
    ("tcp", {"what": "exception", "unit": 7}),
    ("tcp", {"what": "exception", "unit": 255}),  # not significant
    ("rtu", {"what": "exception", "unit": 0}),  # a broadcast
    ("rtu", {"what": "exception", "unit": 9}),
]


def with_fault(bus: str, fault: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {**RIG, **keys, "buses": {**RIG["buses"], bus: {**RIG["buses"][bus], "faults": [fault]}}}


@pytest.mark.parametrize(("bus", "fault", "key", "remedy"), WRONG)
def test_a_rig_file_with_it_is_refused(bus: str, fault: dict[str, Any], key: str, remedy: str) -> None:
    with pytest.raises(ConfigError, match=rf"buses\.{bus}\.faults\[0\]\.{key}") as refused:
        from_dict(with_fault(bus, fault))
    assert remedy in str(refused.value)


@pytest.mark.parametrize(("bus", "fault"), RIGHT)
def test_what_is_there_or_may_come_is_taken(bus: str, fault: dict[str, Any]) -> None:
    from_dict(with_fault(bus, fault))
    with Rig(from_dict({**RIG, "time": "virtual"})) as rig:
        assert rig.add_fault(bus, fault) == 1


def test_a_test_may_attach_a_member_of_any_name() -> None:
    with Rig(from_dict(with_fault("can0", {"what": "drop", "node": "master"}, time="virtual"))) as rig:
        rig.attach("master")
        assert rig.add_fault("can0", {"what": "drop", "node": "master"}) == 2


@pytest.mark.parametrize(("bus", "fault", "key"), [wrong[:3] for wrong in WRONG if wrong[1].get("node") != "pump"])
def test_at_run_time_it_is_refused(bus: str, fault: dict[str, Any], key: str) -> None:
    with Rig(from_dict({**RIG, "time": "virtual"})) as rig, pytest.raises(ControlError, match=key):
        rig.add_fault(bus, fault)


def test_a_unit_that_has_no_power_may_have_a_fault() -> None:
    with Rig(from_dict({**RIG, "time": "virtual"})) as rig:
        rig.add_fault("pump", {"what": "power_off"})
        assert rig.add_fault("tcp", {"what": "exception", "unit": 7}) == 1
        with pytest.raises(ControlError, match="nothing on the bus has unit 8"):
            rig.add_fault("tcp", {"what": "exception", "unit": 8})
