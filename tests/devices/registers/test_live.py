"""Registers with a program behind them: halves, refusals, word order, whatever bytes come."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymodbus.client.mixin import ModbusClientMixin

from fieldrig.device import Value
from fieldrig_bus.modbus.errors import ModbusError
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.registers.live import BitEntry, Entry, LiveBits, LiveRegisters, whole

Type = ModbusClientMixin.DATATYPE
NAMES: dict[str, tuple[Type, int | float | str]] = {
    "u16": (Type.UINT16, 50_000),
    "s16": (Type.INT16, -2),
    "u32": (Type.UINT32, 4_000_000_000),
    "s32": (Type.INT32, -100_000),
    "f64": (Type.FLOAT64, -2.5),
    "string[6]": (Type.STRING, "Gurt"),
}


class Place:
    def __init__(self, address: int, type: str, first: Value = 0, most: int | None = None) -> None:
        self.value = first
        self.written: list[Value] = []
        self.most = most
        self.entry = Entry(address, "place", type, lambda: self.value, self.write, self.check)

    def write(self, value: Value) -> None:
        self.value = value
        self.written.append(value)

    def check(self, value: Value) -> None:
        if self.most is not None and not isinstance(value, str) and value > self.most:
            raise ValueError("too much")


@pytest.mark.parametrize("order", ["big", "little"])
@pytest.mark.parametrize("type", NAMES)
def test_values_are_as_a_foreign_client_has_them(type: str, order: Any) -> None:
    foreign, value = NAMES[type]
    words = ModbusClientMixin.convert_to_registers(
        value, foreign, word_order="big" if foreign is Type.STRING else order
    )
    data = b"".join(word.to_bytes(2, "big") for word in words)
    place = Place(10, type, "" if type.startswith("string") else 0)
    registers = LiveRegisters([place.entry], order)
    size = place.entry.words
    registers.write(10, data.ljust(2 * size, b"\x00"))
    assert place.value == value
    assert registers.read(10, size) == data.ljust(2 * size, b"\x00")


def test_a_value_of_two_registers_acts_with_its_last_one() -> None:
    place = Place(0, "u32", 7)
    registers = LiveRegisters([place.entry])
    registers.write(0, b"\x00\x01")
    assert place.written == []
    assert registers.read(0, 2).hex() == "00000007"
    registers.write(1, b"\x00\x02")
    assert place.written == [0x1_0002]


def test_a_lonely_low_word_goes_with_the_present_high_word() -> None:
    place = Place(0, "u32", 0x5_0000)
    LiveRegisters([place.entry]).write(1, b"\x00\x09")
    assert place.written == [0x5_0009]


def test_a_request_that_is_refused_in_part_is_refused_as_a_whole() -> None:
    first, second = Place(0, "u16"), Place(1, "u16", most=10)
    registers = LiveRegisters([first.entry, second.entry])
    with pytest.raises(ModbusError) as refused:
        registers.write(0, bytes.fromhex("0005 000b"))
    assert refused.value.code == 4
    assert (first.written, second.written) == ([], [])


def test_what_a_refused_request_began_is_forgotten_too() -> None:
    first, second = Place(0, "u16", most=10), Place(1, "u32")
    registers = LiveRegisters([first.entry, second.entry])
    with pytest.raises(ModbusError):
        registers.write(0, bytes.fromhex("000b 7777"))
    registers.write(2, b"\x00\x01")
    assert second.written == [1]


def test_writes_take_effect_in_the_order_of_addresses() -> None:
    seen: list[Value] = []
    places = [Entry(at, str(at), "u16", lambda: 0, seen.append) for at in (2, 0, 1)]
    LiveRegisters(places).write(0, bytes.fromhex("0007 0008 0009"))
    assert seen == [7, 8, 9]


def test_what_is_only_read_and_what_is_not_there() -> None:
    shown = Entry(5, "shown", "u16", lambda: 0x1234)
    registers = LiveRegisters(whole([shown], 3))
    assert registers.read(5, 3).hex() == "123400000000"
    for address in (5, 6):
        with pytest.raises(ModbusError) as refused:
            registers.write(address, b"\x00\x00")
        assert refused.value.code == 2
    for address, quantity in ((4, 1), (7, 2), (0xFFFF, 1)):
        with pytest.raises(ModbusError) as refused:
            registers.read(address, quantity)
        assert refused.value.code == 2


@pytest.mark.parametrize(
    ("type", "value", "shown"),
    [
        ("u16", 70_000, "ffff"),
        ("u16", -1, "0000"),
        ("s16", -40_000, "8000"),
        ("s32", 1 << 40, "7fffffff"),
        ("string[4]", "Förderband", "46f67264"),
        ("string[2]", "→x", "3f78"),
    ],
)
def test_what_does_not_fit_shows_the_end_of_the_type(type: str, value: Value, shown: str) -> None:
    entry = Entry(0, "value", type, lambda: value)
    assert LiveRegisters([entry]).read(0, entry.words).hex() == shown


def test_bits() -> None:
    on = {0: True, 1: False, 2: True}

    def bit(at: int) -> BitEntry:
        return BitEntry(at, "bit", lambda: on[at], lambda value: on.update({at: value}))

    bits = LiveBits([*map(bit, range(3)), BitEntry(3, "shown", lambda: True)])
    assert bits.read(0, 4) == b"\x0d"
    bits.write(1, 2, b"\x01")
    assert on == {0: True, 1: True, 2: False}
    for address, quantity in ((2, 2), (3, 2), (9, 1)):
        with pytest.raises(ModbusError):
            bits.write(address, quantity, b"\xff")
    assert on == {0: True, 1: True, 2: False}


class Data:
    def __init__(self) -> None:
        self.places = [Place(0, "u16"), Place(1, "s32", most=5), Place(3, "f64"), Place(7, "string[5]", "")]
        self.holding_registers = self.input_registers = LiveRegisters(place.entry for place in self.places)
        self.coils = self.discrete_inputs = LiveBits([BitEntry(0, "bit", lambda: True)])

    def fifo(self, address: int) -> list[int]:
        raise ModbusError(2)

    def exception_status(self) -> int:
        return 0


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(
    st.lists(
        st.binary(min_size=1, max_size=40)
        | st.builds(
            lambda address, words: (
                bytes((16,)) + address.to_bytes(2, "big") + bytes((0, len(words) // 2, len(words))) + words
            ),
            st.integers(0, 12),
            st.binary(min_size=2, max_size=20).filter(lambda words: len(words) % 2 == 0),
        ),
        max_size=6,
    )
)
def test_no_request_raises(requests: list[bytes]) -> None:
    server = ModbusServer(Data())
    for pdu in requests:
        answer = server.answer(ModbusRequest(1, pdu))
        assert answer is not None
        assert answer[0] & 0x7F == pdu[0] & 0x7F
