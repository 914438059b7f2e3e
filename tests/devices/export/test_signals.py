"""Signals of any mapping: all of its bits are in one signal each, and names are those of C and differ."""

from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.signals import SignalSettings, bind
from fieldrig_devices.canopen.variable import Access, Variable
from fieldrig_devices.export.network import Signal, identifier_of, with_unique_names
from fieldrig_devices.export.objects import Objects
from fieldrig_devices.export.pdos import SENT, pdos

NUMBERS = {0x05: 8, 0x06: 16, 0x07: 32, 0x02: 8, 0x03: 16, 0x04: 32}
"""Data types of CiA 301 with their lengths in bits."""


def variable(index: int, subindex: int, type: int, name: str, number: int = 0) -> Variable:
    start = DATA_TYPES[type].encode(number)
    return Variable(index, subindex, name, DATA_TYPES[type], Access.RW, start=start, is_mappable=True)


def node(types: list[int], index: int, name: str, wired: dict[int, int]) -> Objects:
    """A node with one TPDO of these objects; bits of some objects have wires."""
    objects = [variable(index, number, type, name) for number, type in enumerate(types, 1)]
    entries = [index << 16 | number << 8 | NUMBERS[type] for number, type in enumerate(types, 1)]
    mapping = [variable(0x1A00, sub, 0x07, "mapping", entry) for sub, entry in enumerate(entries, 1)]
    parameters = [variable(0x1800, 1, 0x07, "COB-ID", 0x181), variable(0x1A00, 0, 0x05, "entries", len(entries))]
    dictionary = Dictionary([*objects, *mapping, *parameters])
    keys = {
        f"{index:04X}:{number:02X}.{bit % NUMBERS[types[number - 1]]}": SignalSettings(wire=f"w{number}")
        for number, bit in wired.items()
        if number <= len(types)
    }
    return Objects(dictionary, tuple(bind(dictionary, keys)))


@given(
    st.lists(st.sampled_from([*NUMBERS]), min_size=1, max_size=9),
    st.sampled_from([0x2000, 0x6041, 0x6841, 0x6040, 0x60FD, 0x6061, 0x603F]),
    st.sampled_from(["Statusword", "Controlword", "Digital inputs", "Modes of operation display", "x", "32 Ω"]),
    st.dictionaries(st.integers(1, 9), st.integers(0, 63)),
)
def test_each_bit_of_a_mapping_is_in_one_signal(types: list[int], index: int, name: str, wired: dict[int, int]) -> None:
    [message] = pdos(SENT, "node", node(types, index, name, wired), "master")
    bits = [bit for signal in message.signals for bit in range(signal.start, signal.start + signal.length)]
    fitting, at = 0, 0
    for type in types:
        at += NUMBERS[type]
        fitting = at if at <= 64 else fitting
        if at > 64:
            break
    assert sorted(bits) == list(range(fitting))
    assert message.length == fitting // 8


@given(st.lists(st.text(max_size=6), max_size=12))
def test_names_are_those_of_c_and_differ(texts: list[str]) -> None:
    names = [signal.name for signal in with_unique_names(Signal(text, 0, 1) for text in texts)]
    assert all(name.isidentifier() and name.isascii() for name in names)
    assert len({name.lower() for name in names}) == len(texts)
    assert identifier_of("a.b") == "a_b"


def test_bits_of_several_axes_have_their_axis() -> None:
    """CiA 402-2: the objects of axis 2 are 800h above those of axis 1."""
    [message] = pdos(SENT, "node", node([0x06], 0x6841, "Axis 2 Statusword", {}), "master")
    assert [signal.name for signal in message.signals][:3] == [
        "Axis_2_Statusword_state",
        "Axis_2_warning",
        "Axis_2_Statusword_8",
    ]
    [message] = pdos(SENT, "node", node([0x06], 0x6041, "Status word", {}), "master")
    assert [signal.name for signal in message.signals][:2] == ["Status_word_state", "warning"]
