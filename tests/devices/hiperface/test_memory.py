"""The non-volatile data of the encoder, as bytes for its store."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.hiperface import mode
from fieldrig_devices.hiperface.memory import FREE, Eeprom, RefusedError, size_of, status_for


def kept() -> Eeprom:
    eeprom = Eeprom(0x42, 0xE5, 7, -3)
    eeprom.codes[2] = 0x12
    eeprom.create(0, 0xC1, 0)
    eeprom.store(0, 3, b"abc", 0)
    return eeprom


def test_memory_is_what_it_was() -> None:
    assert Eeprom.decode(kept().encode()) == kept()


@given(st.dictionaries(st.integers(0, len(kept().encode()) - 1), st.integers(0, 255), max_size=4))
def test_what_is_no_memory_is_refused_and_the_rest_is_one(damage: dict[int, int]) -> None:
    data = bytearray(kept().encode())
    for place, byte in damage.items():
        data[place] = byte
    try:
        found = Eeprom.decode(bytes(data))
    except ValueError:
        return
    assert (found.encode(), mode.is_right(found.mode)) == (bytes(data), True)


@pytest.mark.parametrize("length", range(len(kept().encode())))
def test_a_part_is_no_memory(length: int) -> None:
    with pytest.raises(ValueError, match=r"not the memory|incomplete"):
        Eeprom.decode(kept().encode()[:length])


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 255), st.integers(0, 255)), max_size=30))
def test_no_order_of_changes_leads_astray(orders: list[tuple[int, int, int]]) -> None:
    eeprom = Eeprom()
    for number, status, code in orders:
        try:
            eeprom.create(number, status, code)
        except RefusedError:
            continue
    assert eeprom.free == FREE - sum(size_of(field.status) for field in eeprom.fields) >= 0
    assert all(len(field.data) == size_of(field.status) for field in eeprom.fields)
    assert Eeprom.decode(eeprom.encode()) == eeprom


def test_the_last_field_may_grow_into_what_is_free_with_what_it_has() -> None:
    eeprom = Eeprom()
    for number in range(FREE // 128 - 1):
        eeprom.create(number, status_for(128), 0x55)
    last = len(eeprom.fields)
    eeprom.create(last, status_for(64), 0x55)
    eeprom.store(last, 0, b"kept", 0x55)
    eeprom.create(last, status_for(128), 0x55)
    assert (eeprom.free, eeprom.read(last, 0, 4, 0x55)) == (0, b"kept")
    with pytest.raises(RefusedError):
        eeprom.create(last - 1, status_for(64), 0x55)  # another one is behind it
