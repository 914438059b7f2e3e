"""The device `pam.vme-master` and the ports of a PAM in one rig in virtual time."""

from pathlib import Path
from typing import Any

import pytest
from pam_ports import GROUP, VME
from pam_programs import HEADER

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.errors import ConfigError, RigError
from fieldrig.pytest_plugin import RigMaker
from fieldrig.testing import RecordedLink
from fieldrig.virtual.rig import Rig
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest, ModbusResponse
from fieldrig_devices.pam.ports.masters.over_modbus import ModbusScript
from fieldrig_devices.pam.ports.masters.script import MasterError, Read, Script


def rig_of(folder: Path, program: str = HEADER + GROUP + VME, **master: Any) -> dict[str, Any]:
    (folder / "printer.pam").write_text(program)
    return {
        "time": "virtual",
        "buses": {"vme": {"kind": "modbus.virtual"}},
        "devices": {
            "pam": {"kind": "pam_port_kinds:PortHost", "program": HEADER + GROUP + VME, "links": {"modbus": ["vme"]}},
            "plc": {
                "kind": "pam.vme-master",
                "application": str(folder / "printer.pam"),
                "links": {"modbus": "vme"},
                **master,
            },
        },
    }


@pytest.fixture
def rig(fieldrig_rig: RigMaker, tmp_path: Path) -> Rig:
    return fieldrig_rig(rig_of(tmp_path, initial={"DWI_MachPressure": -4, "DLI_MachHeadSpeed": 9}))


def test_the_master_starts_the_pam(rig: Rig) -> None:
    rig.run_until(S)
    assert rig.get("plc", "running") is True
    assert rig.get("plc", "mistakes") == ""
    assert rig.get("pam", "state") == "running"
    assert (rig.get("pam", "DWI_MachPressure.0"), rig.get("pam", "DLI_MachHeadSpeed.5")) == (-4, 9)


def test_values_in_both_directions(rig: Rig) -> None:
    rig.run_until(S)
    rig.set("plc", "DRI_MachHeadFactor.3", 0.5)
    rig.set("plc", "DFI_MachAlarm", True)
    rig.set("pam", "DLO_MachHeadPosition.2", -70_000)
    rig.run_until(S + 60 * MS)
    assert rig.get("pam", "DRI_MachHeadFactor.3") == 0.5
    assert rig.get("pam", "DFI_MachAlarm.0") is True
    assert rig.get("plc", "DLO_MachHeadPosition.2") == -70_000
    for key, wrong in (("DWI_MachPressure", 40_000), ("DFI_MachAlarm", 3), ("DFO_MachStopped", True)):
        with pytest.raises((ValueError, RigError), match=r"expected|can only be read"):
            rig.set("plc", key, wrong)


def test_a_written_value_is_read_back_at_once(rig: Rig) -> None:
    written = {
        "DFI_MachRunning": True,
        "DWI_MachPressure": -7,
        "DLI_MachHeadSpeed.2": 70_000,
        "DRI_MachHeadFactor.3": 0.5,
    }
    for before in (True, False):  # before the start-up, and while the master runs
        for key, value in written.items():
            rig.set("plc", key, value)
            assert rig.get("plc", key) == value
        if before:
            rig.run_until(S)
        rig.set("plc", "DFI_MachRunning", False)
        assert rig.get("plc", "DFI_MachRunning") is False
        rig.run_until(rig.now_ns + 200 * MS)
        assert (rig.get("pam", "DFI_MachRunning.0"), rig.get("pam", "DWI_MachPressure.0")) == (False, -7)
        assert [rig.get("plc", key) for key in written] == [False, -7, 70_000, 0.5]


def test_a_value_has_the_type_of_its_variable_from_the_start(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = fieldrig_rig(rig_of(tmp_path, initial={"DFI_MachAlarm": 1, "DRI_MachHeadFactor": 2}))
    types = {"DF": bool, "DW": int, "DL": int, "DR": float}
    for instant_ns in (0, S):  # before the start-up, and after the master has sent the initial values
        rig.run_until(instant_ns)
        values = {key: value for key, value in rig.values("plc").items() if key[:2] in types}
        assert {key: type(value) for key, value in values.items()} == {key: types[key[:2]] for key in values}
    assert (values["DFI_MachAlarm"], values["DRI_MachHeadFactor.0"]) == (True, 2.0)


def test_the_last_of_many_values_arrives(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    config = rig_of(tmp_path)
    config["devices"]["pam"]["turnaround_ms"] = 2.0
    rig = fieldrig_rig(config)
    rig.run_until(2 * S)
    for value in range(1, 101):  # some while the master is sending the one before
        rig.set("plc", "DWI_MachPressure", value)
        rig.run_until(rig.now_ns + 7 * MS)
        if value % 10 == 0:
            rig.run_until(rig.now_ns + 200 * MS)
            assert rig.get("pam", "DWI_MachPressure.0") == value


def test_the_watchdog_is_served(rig: Rig) -> None:
    rig.run_until(5 * S)
    assert rig.get("pam", "state") == "running"
    assert rig.get("plc", "running") is True


@pytest.mark.parametrize(
    ("program", "initial", "error"),
    [
        (HEADER, {}, RigError),
        (HEADER + "AXIS", {}, ConfigError),
        (HEADER + GROUP + VME, {"DFO_MachStopped": True}, RigError),
    ],
)
def test_wrong_settings(
    fieldrig_rig: RigMaker, tmp_path: Path, program: str, initial: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        fieldrig_rig(rig_of(tmp_path, program, initial=initial)).run_until(S)


def test_the_master_tries_again_without_a_pam(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    config = rig_of(tmp_path)
    config["devices"]["pam"]["has_power"] = False
    rig = fieldrig_rig(config)
    rig.run_until(10 * S)
    assert rig.get("plc", "running") is False


class Answers:
    """A PAM that answers with these PDUs, or not at all, and then with words from 1 on."""

    def __init__(self, *answers: str) -> None:
        self.clock, self.link = VirtualClock(), RecordedLink[ModbusEvent]()
        self.answers = [bytes.fromhex(answer) for answer in answers]

    def play(self, script: Script[list[str]]) -> list[str]:
        """Run a script for 10 s, and return its result."""
        ends: list[str] = []

        def whole() -> Script[None]:
            ends.extend((yield from script))

        runner = ModbusScript(self.clock, self.link, 1, whole(), lambda: ends.append("end"))
        self.link.on_receive(runner.on_message)
        runner.begin()
        for _ in range(20):
            for request in self.link.take():
                assert isinstance(request, ModbusRequest)
                if self.answers and (pdu := self.answers.pop(0)):
                    self.link.deliver(ModbusResponse(1, pdu, request.exchange))
                    self.link.deliver(ModbusResponse(1, pdu, request.exchange))  # the second is late
            self.clock.advance_to(self.clock.now_ns() + 500 * MS)
        return ends


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("03 02 12 34", "4660"),
        ("", "the PAM does not answer"),
        ("83 02", "the PAM has answered 83 02"),
        ("03 04 00 00 00 00", "the PAM has answered 03 04 00 00 00 00"),
    ],
)
def test_a_request_that_fails_is_raised_in_the_script(answer: str, said: str) -> None:
    def script() -> Script[list[str]]:
        try:
            (word,) = yield Read(7)
        except MasterError as fault:
            return [str(fault)]
        return [str(word)]

    assert Answers(answer).play(script()) == [said, "end"]


def test_a_pam_runs_without_a_master_that_stands_until_it_is_reset(rig: Rig) -> None:
    """The PAM notes 07..E01E, which ends with its reset."""
    rig.run_until(S)
    number = rig.add_fault("plc", {"what": "stopped", "start_ms": 100})
    rig.set("plc", "DWI_MachPressure", 3)
    rig.run_until(1_090 * MS)
    assert rig.get("pam", "DWI_MachPressure.0") == 3
    rig.run_until(1_150 * MS)
    rig.set("plc", "DWI_MachPressure", 4)
    rig.run_until(4 * S)
    assert rig.get("pam", "state") == "running without a master"
    assert rig.get("pam", "DWI_MachPressure.0") == 3
    rig.clear_fault("plc", number)
    rig.run_until(6 * S)
    assert rig.get("pam", "state") == "running without a master"


def test_a_slow_master_serves_later(rig: Rig) -> None:
    rig.run_until(S)
    rig.add_fault("plc", {"what": "slow", "delay_ms": 150, "duration_ms": 1000})
    rig.run_until(S + 100 * MS)
    rig.set("plc", "DWI_MachPressure", 5)
    rig.run_until(S + 140 * MS)
    assert rig.get("pam", "DWI_MachPressure.0") == -4
    rig.run_until(S + 400 * MS)
    assert rig.get("pam", "DWI_MachPressure.0") == 5
    rig.run_until(3 * S)
    rig.set("plc", "DWI_MachPressure", 6)
    rig.run_until(3 * S + 40 * MS)
    assert rig.get("pam", "DWI_MachPressure.0") == 6
