"""The node without a PAM: points, wires, motors of the settings, and what a PAM takes over."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from smart_io_bench import SmartIoBench

from fieldrig_devices.pamring.frames import LedItem, SetOutput
from fieldrig_devices.smart_io.settings import SmartIoSettings

MOTOR = {"increase": 201, "decrease": 202, "zero": 102, "counter": 101, "braking": 2}


@pytest.mark.manual("PAMS-111")
def test_a_module_has_12_inputs_and_12_outputs_at_its_addresses() -> None:
    bench = SmartIoBench(modules={16: {}}, terminals={"in1612": "door", "out1601": "horn"})
    assert [key for key in bench.device.points() if key.startswith("out")] == [f"out{1600 + n}" for n in range(1, 13)]
    bench.wire("door", True)
    bench.set("out1601", True)
    bench.run(1)
    assert (bench.get("in1612"), bench.get("scan1612"), bench.last("horn")) == (True, True, True)


def test_the_scan_of_a_module_is_that_of_its_settings() -> None:
    bench = SmartIoBench(modules={1: {"period_ms": 10, "debounce": 3}, 2: {}})
    bench.wire("button", True)
    bench.run(29)
    assert (bench.get("in103"), bench.get("scan103")) == (True, False)
    bench.run(1)
    assert bench.get("scan103") is True


def test_a_node_alone_shows_no_code() -> None:
    bench = SmartIoBench()
    assert (bench.get("display"), bench.get("owner")) == (" ", "alone")
    bench.set("display.character", ord("H"))
    bench.set("display.blink", True)
    assert (bench.get("display"), bench.get("display.blink")) == ("H", True)


def test_a_motor_of_the_settings_moves_by_points() -> None:
    bench = SmartIoBench(motors=[MOTOR])
    bench.set("motor1.value", 10)
    bench.set("motor1.order", 1)
    assert (bench.last("motor.inc"), bench.get("motor1.ready")) == (True, False)
    bench.pulse(8)
    assert bench.last("motor.inc") is False
    bench.pulse(2)
    bench.run(101)
    assert (bench.get("motor1.position"), bench.get("motor1.ready"), bench.get("motor1.error")) == (10, True, 0)
    with pytest.raises(ValueError, match="run takes"):
        bench.set("motor1.order", 3)


def test_inputs_with_a_wire_and_outputs_of_a_pam_can_not_be_written() -> None:
    bench = SmartIoBench()
    assert bench.device.points()["in103"].write is None
    for key, value in (("out105", True), ("led6", True), ("analog1", 5_000), ("display.character", 0x41)):
        bench.set(key, value)
    bench.configure(LedItem(7, 6))
    shown = [bench.get(key) for key in ("owner", "out105", "led6", "analog1", "display.character")]
    assert shown == ["pam", False, False, 0, 0x20], "all is off when the PAM takes over"
    for key, value in (("out105", True), ("led6", True), ("led6.blink", True), ("analog1", 1), ("display.blink", True)):
        with pytest.raises(ValueError, match="the PAM has the outputs"):
            bench.set(key, value)
    bench.order(SetOutput(7, 1))
    assert bench.get("led6") is True


def test_a_motor_stops_when_a_pam_takes_the_node_over() -> None:
    bench = SmartIoBench(motors=[MOTOR])
    bench.set("motor1.value", 1)
    bench.set("motor1.order", 3)
    bench.configure()
    assert bench.last("motor.inc") is False
    bench.pulse(5)
    assert bench.get("motor1.position") == 0
    with pytest.raises(ValueError, match="the PAM has the outputs"):
        bench.set("motor1.order", 3)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"terminals": {"in301": "a"}}, "there is no terminal in301"),
    ({"terminals": {"key25": "a"}}, "there is no terminal key25"),
    ({"terminals": {"analog2": "a"}}, "there is no terminal analog2"),
    ({"modules": {17: {}}}, "less than or equal to 16"),
    ({"keyboard": "none", "terminals": {"led1": "a"}}, "there is no terminal led1"),
    ({"motors": [{**MOTOR, "counter": 301}]}, "there is no address 301"),
    ({"motors": [{**MOTOR, "decrease": 201}]}, "both outputs are the same"),
]


@pytest.mark.parametrize(("settings", "words"), WRONG)
def test_settings_that_can_not_be_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        SmartIoSettings.model_validate({"modules": {1: {}, 2: {}}, **settings})


def test_a_slave_needs_a_bus() -> None:
    assert [claim.what for claim in SmartIoSettings.model_validate({"can_slave": {"node_id": 5}}).claims("io")] == [
        "unit", "node-ID",
    ]  # fmt: skip


@given(st.text(alphabet="inoutkeylda0123456789", max_size=8))
def test_any_name_of_a_terminal_is_there_or_refused(name: str) -> None:
    try:
        SmartIoSettings.model_validate({"terminals": {name: "wire"}})
    except ValidationError:
        return
    assert name.startswith(("in1", "out1", "key", "led", "analog1"))
