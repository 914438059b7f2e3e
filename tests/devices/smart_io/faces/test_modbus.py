"""The node as a Modbus device: requests against terminals, keyboard and motor."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from smart_io_bench import SmartIoBench

from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.registers.live_table import wrong_entries
from fieldrig_devices.smart_io.faces.registers import table
from fieldrig_devices.smart_io.settings import SmartIoSettings

MOTOR = {"increase": 201, "decrease": 202, "zero": 102, "counter": 101, "braking": 2}


@pytest.fixture
def bench() -> SmartIoBench:
    return SmartIoBench(motors=[MOTOR])


def test_each_entry_of_the_table_has_a_point() -> None:
    everything: dict[str, Any] = {
        "modules": {number: {} for number in range(1, 17)},
        "motors": [MOTOR] * 8,
        "terminals": {},
    }
    bench = SmartIoBench(key_count=32, led_count=32, **everything)
    whole = table(SmartIoSettings.model_validate({**everything, "key_count": 32, "led_count": 32}))
    assert list(wrong_entries(whole, bench.device.find)) == []
    assert (len(whole.coils), len(whole.discrete_inputs)) == (192 + 64, 192 + 32 + 8)


def test_coils_are_outputs_and_leds(bench: SmartIoBench) -> None:
    assert bench.request("05 00 04 ff 00") == "05 00 04 ff 00"  # 105
    assert bench.request("05 01 05 ff 00") == "05 01 05 ff 00"  # led6
    assert (bench.last("valve"), bench.last("lamp")) == (True, True)
    assert bench.request("01 00 00 00 18") == "01 03 10 00 00"
    assert bench.request("05 01 45 ff 00") == "05 01 45 ff 00"
    assert bench.get("led6.blink") is True


def test_discrete_inputs_are_scanned_inputs_and_keys(bench: SmartIoBench) -> None:
    bench.wire("button", True)
    bench.wire("limit", True)
    bench.wire("start", True)
    bench.run(1)
    assert bench.request("02 00 00 00 18") == "02 03 04 00 08"  # 103 and 208
    assert bench.request("02 01 00 00 10") == "02 02 00 08"  # key12
    assert bench.request("02 01 40 00 01") == "02 01 01"  # motor 1 is ready


def test_a_module_that_is_not_there_does_not_exist(bench: SmartIoBench) -> None:
    assert bench.request("01 00 18 00 01") == "81 02"


def test_registers_are_analog_output_display_and_motor(bench: SmartIoBench) -> None:
    assert bench.request("06 00 00 fe 0c") == "06 00 00 fe 0c"  # -500 mV
    assert bench.last("speed") == -0.5
    assert bench.request("06 00 01 00 45") == "06 00 01 00 45"
    assert bench.get("display") == "E"
    assert bench.request("06 00 00 7f ff") == "86 04", "beyond 10 V"
    bench.request("10 00 11 00 02 04 00 0a 00 00")  # value 10
    bench.request("06 00 10 00 01")  # absolute move
    bench.pulse(10)
    assert bench.request("04 00 10 00 02") == "04 04 00 0a 00 00"
    bench.run(500)
    bench.device.add_fault({"what": "overtemperature"})
    assert bench.request("04 00 00 00 02") == "04 04 10 00 00 00"


def test_a_write_is_refused_while_a_pam_has_the_outputs(bench: SmartIoBench) -> None:
    bench.configure()
    assert bench.request("05 00 04 ff 00") == "85 04"
    assert bench.request("06 00 00 00 01") == "86 04"
    assert bench.request("01 00 04 00 01") == "01 01 00"


@given(st.binary(min_size=1, max_size=20))
def test_any_request_is_answered_and_the_node_works_on(pdu: bytes) -> None:
    bench = SmartIoBench(motors=[MOTOR])
    bench.modbus.deliver(ModbusRequest(1, pdu, 1))
    bench.run(1_000)
    assert bench.request("01 00 00 00 01")[:2] == "01"
