"""Names of Modbus messages; the PDUs are those of the examples in Modbus application protocol V1.1b3, chapter 6."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import RigConfig, from_dict
from fieldrig.traces.names import Named, namer_of
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.modbus.names import MOST_OPEN

CONFIGS = Path(__file__).parents[3] / "configs"
RIG = {
    "time": "virtual",
    "buses": {"mb": {"kind": "modbus.virtual"}},
    "devices": {
        "pump": {
            "kind": "modbus.device",
            "unit_id": 1,
            "table": "registers/pump-drive.yaml",
            "links": {"modbus": "mb"},
        },
    },
}


@pytest.fixture(scope="module")
def config() -> RigConfig:
    return from_dict(RIG, CONFIGS)


def exchange(config: RigConfig, request: str, response: str, unit: int = 1) -> tuple[Named, Named]:
    """Return the names of a request and its response."""
    name = namer_of(config, "mb")
    asked = name(ModbusRequest(unit, bytes.fromhex(request), 7))
    return asked, name(ModbusResponse(unit, bytes.fromhex(response), 7))


@pytest.mark.parametrize(
    ("request_pdu", "response_pdu", "asked", "answered"),
    [
        ("03 00 00 00 03", "03 06 01 F4 00 32 07 08", "speed_set, ramp_time, level_limit",
         "speed_set 50 %, ramp_time 5 s, level_limit 1.8 m"),
        ("04 00 02 00 03", "04 06 3D CC CC CD FF F6", "flow, drive_temperature",
         "flow 0.10000000149 m3/s, drive_temperature -1 degC"),
        ("01 00 00 00 02", "01 01 02", "run, alarm_reset", "run off, alarm_reset on"),
        ("05 00 00 FF 00", "05 00 00 FF 00", "run on", "run"),
        ("06 00 00 03 E8", "06 00 00 03 E8", "speed_set 100 %", "speed_set"),
        ("10 00 01 00 02 04 00 0A 03 E8", "10 00 01 00 02", "ramp_time 1 s, level_limit 1 m",
         "ramp_time, level_limit"),
        ("03 00 6B 00 01", "03 02 02 2B", "107", "107 022Bh"),
        ("16 00 00 00 F2 00 25", "16 00 00 00 F2 00 25", "speed_set and 00F2h or 0025h", "speed_set"),
    ],
)  # fmt: skip
def test_registers_have_their_names_and_values(
    config: RigConfig, request_pdu: str, response_pdu: str, asked: str, answered: str
) -> None:
    request, response = exchange(config, request_pdu, response_pdu)
    assert (request.node, request.text) == ("pump", asked)
    assert (response.node, response.text) == ("pump", answered)
    assert response.kind == f"{request.kind}: response"


def test_an_exception_says_which(config: RigConfig) -> None:
    request, response = exchange(config, "01 04 A1 00 01", "81 02")
    assert request == Named("read coils", "pump", "1185")
    assert response == Named("read coils: exception", "pump", "02h illegal data address")


def test_an_unknown_unit_has_its_number(config: RigConfig) -> None:
    request, _ = exchange(config, "03 00 00 00 01", "03 02 00 00", unit=9)
    assert request == Named("read holding registers", "unit 9", "0")


def test_a_response_without_its_request_is_shown_as_bytes(config: RigConfig) -> None:
    assert namer_of(config, "mb")(ModbusResponse(1, bytes.fromhex("03 02 00 2A"), 3)).text == "02 00 2A"


def test_requests_that_nobody_answers_take_no_more_memory(config: RigConfig) -> None:
    name = namer_of(config, "mb")
    for number in range(MOST_OPEN + 10):
        name(ModbusRequest(1, bytes.fromhex("03 00 00 00 01"), number))
    assert name(ModbusResponse(1, bytes.fromhex("03 02 00 0A"), 0)).text == "02 00 0A"
    assert name(ModbusResponse(1, bytes.fromhex("03 02 00 0A"), MOST_OPEN)).text == "speed_set 1 %"


@given(request=st.binary(min_size=1, max_size=40), response=st.binary(min_size=1, max_size=40), unit=st.integers(0, 2))
def test_any_pdu_has_some_name(config: RigConfig, request: bytes, response: bytes, unit: int) -> None:
    for named in exchange(config, request.hex(), response.hex(), unit):
        assert isinstance(named, Named)
