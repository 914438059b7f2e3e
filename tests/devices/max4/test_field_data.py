"""Values of field bus modules in one message, filled from the lowest bit: CiA 301, 7.5.2.36; Modbus V1.1b3, 6.1."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.field_data import Data
from fieldrig_devices.registers.packed import FORMS, Element


def data_of(types: list[str]) -> Data:
    group = ObjectTree().root.group("Data")
    elements = [Element.model_validate({"name": f"v{place}", "type": type}) for place, type in enumerate(types)]
    return Data(group, elements, is_output=False)


@pytest.mark.parametrize(
    ("types", "message"),
    [
        (["bool"], "01"),
        (["bool"] * 8, "81"),
        (["bool"] * 9, "01 01"),
        (["bool", "u8"], "b5 00"),  # 1, then 5Ah
        (["u8", "bool"], "5a 01"),
        (["u16", "s8", "bool"], "34 12 ff 01"),
    ],
)
def test_a_message_has_as_many_bytes_as_its_bits_need(types: list[str], message: str) -> None:
    data = data_of(types)
    data.unpack(bytes.fromhex(message))
    assert data.packed().hex(" ") == message


@given(types=st.lists(st.sampled_from(sorted(FORMS.keys() - {"f32"})), max_size=20), octets=st.binary(max_size=90))
def test_what_is_unpacked_is_packed_again(types: list[str], octets: bytes) -> None:
    data, bits = data_of(types), sum(FORMS[type].bits for type in types)
    size = (bits + 7) // 8
    octets = octets[:size].ljust(size, b"\x00")
    data.unpack(octets)
    word = int.from_bytes(octets, "little") & (1 << bits) - 1
    assert data.packed() == word.to_bytes(size, "little")
