"""Markers in Modbus messages by the names of a program; the addresses are those of max4-modbus.md and PD-364.

%MD1 is bytes 4 to 7, %MX4.3 bit 3 of word 4, and a register has the high byte first.
"""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import from_dict
from fieldrig.traces.names import Namer, namer_of
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.modbus.marker_names import MarkerNames, markers_in

PROGRAM = """
VAR_GLOBAL
  g_wLow AT %MW0 : WORD;
  g_dwDouble AT %MD1 : DWORD;
  g_bFlag AT %MX4.3 : BOOL;
  g_bOther AT %MX4.12 : BOOL;
  g_iState AT %MW5 : INT;
  g_rSpeed AT %MD3 : REAL;
  g_tWait AT %MD4 : TIME;
  g_byLow AT %MB20 : SINT;
  g_byHigh AT %MB21 : BYTE;
  g_eMode AT %MW11 : E_Mode;
  g_xInput AT %IX0.0 : BOOL;
END_VAR
PROGRAM PLC_PRG
VAR
  own AT %MW40 : UINT;
  other : INT;
END_VAR
END_PROGRAM
"""
RIG = {
    "time": "virtual",
    "buses": {"ring": {"kind": "ring.virtual"}, "mb": {"kind": "modbus.virtual"}},
    "devices": {"plc": {"kind": "max4", "program": "markers.st", "links": {"ring": "ring", "modbus": ["mb"]}}},
}
MARKERS = MarkerNames(markers_in([SourceFile("a.st", PROGRAM)], EPAS_4))


@pytest.fixture(scope="module")
def name(tmp_path_factory: pytest.TempPathFactory) -> Namer:
    folder: Path = tmp_path_factory.mktemp("rig")
    (folder / "markers.st").write_text(PROGRAM)
    return namer_of(from_dict(RIG, folder), "mb")


def exchange(name: Namer, request: str, response: str) -> tuple[str, str]:
    asked = name(ModbusRequest(1, bytes.fromhex(request), 1))
    answered = name(ModbusResponse(1, bytes.fromhex(response), 1))
    assert asked.node == answered.node == "plc"
    return asked.text, answered.text


@pytest.mark.manual("PD-364")
@pytest.mark.parametrize(
    ("request_pdu", "response_pdu", "asked", "answered"),
    [
        ("03 8000 0001", "03 02 1234", "g_wLow", "g_wLow 4660"),
        ("03 8002 0002", "03 04 3344 1122", "g_dwDouble", "g_dwDouble 287454020"),
        ("03 8004 0001", "03 02 0008", "g_bFlag, g_bOther", "g_bFlag on, g_bOther off"),
        ("03 8004 0002", "03 04 1000 FFFE", "g_bFlag, g_bOther, g_iState",
         "g_bFlag off, g_bOther on, g_iState -2"),
        ("03 8006 0002", "03 04 0000 3FC0", "g_rSpeed", "g_rSpeed 1.5"),
        ("03 8008 0002", "03 04 05DC 0000", "g_tWait", "g_tWait 1500 ms"),
        ("03 800A 0001", "03 02 07FF", "g_byLow, g_byHigh", "g_byLow -1, g_byHigh 7"),
        ("03 800B 0001", "03 02 0003", "g_eMode", "g_eMode 3"),
        ("03 8028 0001", "03 02 0001", "PLC_PRG.own", "PLC_PRG.own 1"),
        ("03 8002 0001", "03 02 3344", "g_dwDouble", "g_dwDouble (a part)"),
        ("03 8030 0001", "03 02 00AB", "%MW48", "%MW48 00ABh"),
        ("03 0004 0001", "03 02 00AB", "4", "4 00ABh"),
        ("01 8043 0002", "01 01 01", "g_bFlag, %MX4.4", "g_bFlag on, %MX4.4 off"),
        ("02 0043 0001", "02 01 01", "67", "67 on"),
        ("05 804C FF00", "05 804C FF00", "g_bOther on", "g_bOther"),
        ("06 8005 FFFF", "06 8005 FFFF", "g_iState -1", "g_iState"),
    ],
)  # fmt: skip
def test_a_register_of_the_markers_is_a_variable(
    name: Namer, request_pdu: str, response_pdu: str, asked: str, answered: str
) -> None:
    assert exchange(name, request_pdu, response_pdu) == (asked, answered)


@given(
    st.sampled_from(["coils", "holding_registers"]),
    st.integers(0, 0xFFFF),
    st.integers(0, 0xFFFF),
    st.binary(max_size=20),
)
def test_any_registers_have_some_names(space: str, address: int, count: int, data: bytes) -> None:
    assert isinstance(MARKERS.names(space, address, count), str)
    assert isinstance(MARKERS.registers(space, address, data), str)
    assert isinstance(MARKERS.bits(space, address, count, data), str)


def test_a_source_that_cannot_be_read_has_the_markers_that_are_declared_in_it() -> None:
    text = "VAR_GLOBAL g_wLow AT %MW0 : WORD; END_VAR PROGRAM a x := ( END_PROGRAM"
    assert [marker.name for marker in markers_in([SourceFile("a.st", text)], EPAS_4)] == ["g_wLow"]
