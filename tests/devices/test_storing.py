"""Laws of every kind of device that stores: on a disk that is full, and on a store that was damaged."""

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from full_store import FullStore
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from storing_devices import KINDS, disk_test

from fieldrig.config import kinds
from fieldrig.storage.store import FileStore, MemoryStore

EVERY_KIND = pytest.mark.parametrize("kind", KINDS)


def test_every_kind_that_asks_for_a_store_is_here() -> None:
    found = [kind.name for kind in kinds.list_devices()]
    assert sorted(KINDS) == [name for name in found if "store" in kinds.constructor_parameters(kinds.find_device(name))]


@pytest.mark.long
@EVERY_KIND
def test_a_full_disk_is_refused_in_the_words_of_the_protocol_and_the_old_is_kept(kind: str) -> None:
    store = FullStore()

    def fill(is_full: bool) -> None:
        store.is_full = is_full

    fill(False)
    with disk_test(kind, lambda: store, fill):
        assert store.refused == 2


@EVERY_KIND
def test_a_device_starts_for_the_first_time_on_a_full_disk(kind: str) -> None:
    store = FullStore()
    device = KINDS[kind](store)
    assert device.write(1).startswith(device.refused)
    store.is_full = False
    assert device.write(2).startswith(device.accepted)
    assert KINDS[kind](store).read() == 2


def factory_value(kind: str) -> int:
    return KINDS[kind](MemoryStore()).read()


@EVERY_KIND
@settings(max_examples=8, deadline=None, phases=[Phase.generate])
@given(data=st.data())
@pytest.mark.long
def test_any_flipped_bits_give_the_previous_version_or_defaults(kind: str, data: st.DataObject) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "device.bin"
        device = KINDS[kind](FileStore(path, kind))
        for value in (11, 12):
            assert device.write(value).startswith(device.accepted)
        flip(path, data)
        assert KINDS[kind](FileStore(path, kind)).read() == 11
        flip(path.with_name("device.bin.previous"), data)
        again = KINDS[kind](FileStore(path, kind))
        assert again.read() == (0xFF if kind == "sm.encoder" else factory_value(kind))
        if kind != "sm.encoder":  # it has to be given a data field first
            assert again.write(13).startswith(again.accepted)
            assert KINDS[kind](FileStore(path, kind)).read() == 13


@EVERY_KIND
@settings(max_examples=5, deadline=None, phases=[Phase.generate])
@given(data=st.data())
@pytest.mark.long
def test_a_damaged_buffered_ram_ends_nothing(kind: str, data: st.DataObject) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "device.bin"
        device = KINDS[kind](FileStore(path, kind))
        assert device.write(11).startswith(device.accepted)
        if path.with_suffix(".ram").exists():
            flip(path.with_suffix(".ram"), data)
        again = KINDS[kind](FileStore(path, kind))
        assert again.read() == 11
        assert again.write(12).startswith(again.accepted)


def flip(path: Path, data: st.DataObject) -> None:
    blob = bytearray(path.read_bytes())
    for bit in data.draw(st.sets(st.integers(0, 8 * len(blob) - 1), min_size=1, max_size=4)):
        blob[bit // 8] ^= 1 << bit % 8
    path.write_bytes(blob)
