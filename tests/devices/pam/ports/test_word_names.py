"""Words of DualPort memories by name, over the applications that the manual prints (pam_ports.py)."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pam_ports import GROUP, SIMATIC, VME
from pam_programs import HEADER

from fieldrig.config.rig_file import from_dict
from fieldrig.faults.note import FaultNote
from fieldrig.traces.names import Named, namer_of
from fieldrig_bus.dualport.message import WORDS, Words
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import crc_of, ports_of
from fieldrig_devices.pam.ports.names import DualPortNames, map_of
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.vme.words import MOST_KEYS, VmeWords
from fieldrig_devices.pam.ports.words import MapRegisters, PlainWords, WordMap

KEY = 0x0003_0009
LEVEL = crc_of("DRO_MachHeadLevel")


def map_in(text: str) -> WordMap:
    program, _ = checked(HEADER + GROUP + text, "app.pam")
    words = map_of(ports_of(program), PortOptions())
    assert words is not None
    return words


@pytest.fixture(scope="module")
def simatic() -> DualPortNames:
    return DualPortNames(["pam", "plc"], map_in(SIMATIC))


@pytest.fixture
def vme() -> DualPortNames:
    return DualPortNames(["pam", "plc"], map_in(VME))


@pytest.mark.manual("PAMS-089", "PAMS-093", "PAMS-095")
@pytest.mark.parametrize(
    ("address", "value", "kind", "text"),
    [
        (0x120, 5, "variable", "DWI_MachPressure = 5"),
        (0x920, 0xFFFD, "variable", "DWO_MachCurrentPressure = -3"),
        (0x124, 7, "variable", "DWI_MachHeadSpeed[2] = 7"),
        # Bit 11 of the cell #104 is bit 3 of byte #105, as the comment in the manual says.
        (0x104, 0x0801, "start",
         "word 130 = DFI_MachRunning on HOST_READY off DFI_MachEmergency on"),
        (0xFFE, 0xFF, "watchdog", "WATCH_DOG = 255"),
        (0xFF0, 6, "panel", "panel origin = 6"),
        (0x002, 0x120, "FIFO", "FIFO_IN 1 = DWI_MachPressure"),
        (0x100, 4, "FIFO", "FIFO_IN_HEAD = 4"),
        (0x700, 0xBEEF, "words", "word 896 = BEEFh"),
    ],
)  # fmt: skip
def test_a_word_of_a_simatic_dualport_is_what_the_application_declares(
    simatic: DualPortNames, address: int, value: int, kind: str, text: str
) -> None:
    assert simatic(Words(address // 2, (value,)), "plc") == Named(kind, "pam", text)


@pytest.mark.manual("PAMS-065", "PAMS-077", "PAMS-079")
def test_the_blocks_of_a_vme_dualport_have_their_variables(vme: DualPortNames) -> None:
    """Input blocks are key, 0, index, value (table 13-8); output blocks begin with 32 bits of key (table 13-9)."""
    pressure = (5, 0, 0, 0xFFFD, 0, 0, 0)  # the fifth input of the listing
    assert vme(Words(29, pressure), "plc") == Named("input block", "pam", "input block 0 = DWI_MachPressure -3")
    factor = (7, 0, 0xFFFF, 0, 0, 0, 0x3FE0)
    assert vme(Words(29 + 7, factor), "plc").text == "input block 1 = DRI_MachHeadFactor[all] 0.5"
    running = (1, 0, 0, 1, 0, 0, 0)
    assert vme(Words(29 + 143 * 7, running), "plc").text == "input block 143 = DFI_MachRunning on"
    output = Words(29 + 144 * 7, (KEY & 0xFFFF, KEY >> 16, 1, 0, 0, 0, 0x3FE0))
    assert vme(output, "pam").text == f"output block 0 = key {KEY} index 1: 0000h 0000h 0000h 3FE0h"
    assert vme(Words(13, (LEVEL, KEY & 0xFFFF, KEY >> 16)), "plc").kind == "parameter"
    assert vme(Words(12, (3,)), "plc") == Named("command", "pam", f"COMMAND = DEF_OUT DRO_MachHeadLevel with key {KEY}")
    assert vme(output, "pam") == Named("output block", "plc", "output block 0 = DRO_MachHeadLevel[2] 0.5")


@pytest.mark.parametrize(
    ("word", "value", "kind", "text"),
    [
        (1, 3, "header", "INPUT HEAD = 3"),
        (9, 14, "header", "OUTPUT BLOC_SIZE = 14"),
        (10, 1, "watchdog", "WATCHDOG = 0001h"),
        (12, 7, "command", "COMMAND = START"),
        (16, 5, "acknowledge", "ACKNOWLEDGE = BAD_CRC"),
        (22, 6, "panel", "panel origin = 0006h"),
        (30, 0, "input block", "input block 0 word 1 = 0000h"),
        (2047, 1, "words", "2047 = 0001h"),
    ],
)
def test_other_words_of_a_vme_dualport_have_the_names_of_the_manual(
    vme: DualPortNames, word: int, value: int, kind: str, text: str
) -> None:
    assert vme(Words(word, (value,)), "plc") == Named(kind, "pam", text)


def test_keys_without_end_take_no_more_memory() -> None:
    words = map_in(VME)
    assert isinstance(words, VmeWords)
    for key in range(MOST_KEYS + 10):
        words.piece(14, [key])
        words.piece(13, [LEVEL])
        words.piece(12, [3])
    assert len(words._outputs) == MOST_KEYS


def test_a_memory_without_an_application_has_numbers() -> None:
    name = DualPortNames([], PlainWords())
    assert name(Words(7, (1, 0xAB)), "plc") == Named("words", "plc", "word 7 = 0001h, word 8 = 00ABh")
    assert name(FaultNote(1, "stuck"), "plc") == Named("fault", "plc", "fault 1: stuck")


@pytest.mark.parametrize("text", [SIMATIC, VME])
def test_any_words_have_some_name(text: str) -> None:
    words = map_in(text)

    @given(first=st.integers(0, WORDS - 1), values=st.lists(st.integers(0, 0xFFFF), max_size=20))
    def check(first: int, values: list[int]) -> None:
        name, registers = DualPortNames(["pam"], words), MapRegisters(words)
        assert isinstance(name(Words(first, tuple(values)), "plc"), Named)
        assert isinstance(registers.names("holding_registers", first, 0xFFFF), str)
        data = b"".join(value.to_bytes(2, "big") for value in values)
        assert isinstance(registers.registers("holding_registers", first, data + b"\x01"), str)

    check()


def test_the_words_of_a_dualport_are_named_on_modbus(tmp_path: Path) -> None:
    (tmp_path / "app.pam").write_text(HEADER + GROUP + SIMATIC)
    rig = {
        "time": "virtual",
        "buses": {"ring": {"kind": "pamring.virtual"}, "mb": {"kind": "modbus.virtual"}},
        "devices": {"pam": {"kind": "pam", "application": "app.pam", "links": {"ring": "ring", "modbus": ["mb"]}}},
    }
    name = namer_of(from_dict(rig, tmp_path), "mb")
    asked = name(ModbusRequest(1, bytes.fromhex("03 0090 0002"), 1))
    assert asked == Named("read holding registers", "pam", "DWI_MachPressure, DWI_MachHeadSpeed[1]")
    answered = name(ModbusResponse(1, bytes.fromhex("03 04 FFFD 0007"), 1))
    assert answered.text == "DWI_MachPressure = -3, DWI_MachHeadSpeed[1] = 7"
