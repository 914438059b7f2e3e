import errno
import logging
import os
import signal
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.storage import store_format
from fieldrig.storage.store import FileStore, MemoryStore, Store, StoreError, restore


@pytest.fixture(params=["file", "memory"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Store:
    return FileStore(tmp_path / "state" / "node.bin") if request.param == "file" else MemoryStore()


def test_nothing_was_saved_at_first(store: Store) -> None:
    assert store.load() is None


def test_the_last_save_is_kept(store: Store) -> None:
    store.save(b"old")
    store.save(b"new")
    assert store.load() == b"new"


SAVE_FOR_EVER = """
import sys
from pathlib import Path
from fieldrig.storage.store import FileStore
store = FileStore(Path(sys.argv[1]))
number = 0
while True:
    number += 1
    store.save(number.to_bytes(4, "little") * 4096)
    print(number, flush=True)
"""


@pytest.mark.system
@pytest.mark.parametrize("saves", [1, 2, 17])
def test_a_kill_at_any_moment_loses_nothing_that_was_saved(tmp_path: Path, saves: int) -> None:
    path = tmp_path / "node.bin"
    with subprocess.Popen(
        [sys.executable, "-c", SAVE_FOR_EVER, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told = 0
        for _ in range(saves):
            told = int(process.stdout.readline())
        os.kill(process.pid, signal.SIGKILL)
        told = max([told, *map(int, process.stdout.read().split())])
    data = FileStore(path).load()
    assert data is not None
    number = int.from_bytes(data[:4], "little")
    assert number >= told  # what was reported saved is there, or something later
    assert data == number.to_bytes(4, "little") * 4096  # and whole


def test_buffered_ram_is_blank_at_first_and_keeps_every_write(store: Store) -> None:
    ram = store.buffered_ram(8)
    assert bytes(ram) == bytes(8)
    ram[2:4] = b"ab"
    assert bytes(store.buffered_ram(8)) == b"\0\0ab\0\0\0\0"
    assert store.load() is None  # it is no part of what is saved


COUNT_FOR_EVER = """
import sys
from pathlib import Path
from fieldrig.storage.store import FileStore
words = FileStore(Path(sys.argv[1])).buffered_ram(4000).cast("i")
number = 0
while True:
    number += 1
    words[7] = number
    print(number, flush=True)
"""


@pytest.mark.system
def test_a_kill_loses_no_word_of_buffered_ram(tmp_path: Path) -> None:
    path = tmp_path / "card.bin"
    with subprocess.Popen(
        [sys.executable, "-c", COUNT_FOR_EVER, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        told = int(process.stdout.readline())
        os.kill(process.pid, signal.SIGKILL)
        told = max([told, *map(int, process.stdout.read().split())])
    assert FileStore(path).buffered_ram(4000).cast("i")[7] >= told


# ---- the format


def test_a_file_is_a_line_with_a_checksum_and_then_the_data() -> None:
    checked = b"5 modbus.device\nab\ncd"
    blob = b"FIELDRIG-STORE 1 %08X " % zlib.crc32(checked) + checked
    assert store_format.encode("modbus.device", b"ab\ncd") == blob
    assert store_format.decode("modbus.device", blob) == b"ab\ncd"


def test_the_checksum_is_the_crc_32_of_ieee_802_3() -> None:
    # the catalogue's check value of CRC-32/ISO-HDLC is CBF43926 over 123456789
    assert zlib.crc32(b"123456789") == 0xCBF43926


@given(st.text(st.characters(blacklist_characters="\n", blacklist_categories=["Cs"]), max_size=40), st.binary())
def test_what_is_encoded_is_decoded(owner: str, data: bytes) -> None:
    assert store_format.decode(owner, store_format.encode(owner, data)) == data


@pytest.mark.parametrize(
    ("blob", "reason"),
    [
        (b"", "not a file of a store"),
        (b'{"version": 1}', "not a file of a store"),
        (store_format.encode("arp", b"x").replace(b"STORE 1", b"STORE 2"), "version 2"),
        (store_format.encode("arp", b"x") + b"y", "2 bytes of data, expected 1"),
        (store_format.encode("max4", b"x"), "belongs to 'max4', expected 'arp'"),
        (store_format.encode("arp", b"x")[:-1] + b"y", "checksum"),
    ],
)
def test_what_is_no_file_of_this_store_is_refused_with_the_reason(blob: bytes, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        store_format.decode("arp", blob)


# ---- damage

OLD, NEW = b"the old content", b"the new content"


def saved_twice(folder: Path) -> Path:
    path = folder / "node.bin"
    store = FileStore(path, "node")
    store.save(OLD)
    store.save(NEW)
    return path


@pytest.mark.long
@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_any_flipped_bit_gives_the_previous_version(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = saved_twice(tmp_path_factory.mktemp("store"))
    blob = bytearray(path.read_bytes())
    for bit in data.draw(st.sets(st.integers(0, 8 * len(blob) - 1), min_size=1, max_size=8)):
        blob[bit // 8] ^= 1 << bit % 8
    path.write_bytes(blob)
    assert FileStore(path, "node").load() == OLD


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(last=st.binary(max_size=200), previous=st.binary(max_size=200))
def test_no_files_raise(tmp_path_factory: pytest.TempPathFactory, last: bytes, previous: bytes) -> None:
    path = saved_twice(tmp_path_factory.mktemp("store"))
    path.write_bytes(last)
    path.with_name("node.bin.previous").write_bytes(previous)
    store = FileStore(path, "node")
    assert restore(store, bytes) == (None, True)
    store.save(NEW)
    assert FileStore(path, "node").load() == NEW


@pytest.mark.parametrize("length", range(0, len(store_format.encode("node", NEW)), 7))
def test_a_torn_write_gives_the_previous_version(tmp_path: Path, length: int) -> None:
    path = saved_twice(tmp_path)
    path.write_bytes(path.read_bytes()[:length])
    assert FileStore(path, "node").load() == OLD


def test_damage_and_what_is_used_instead_are_logged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = saved_twice(tmp_path)
    path.write_bytes(b"{}")
    assert FileStore(path, "node").load() == OLD
    assert [record.getMessage() for record in caplog.records] == [
        f"{path} is damaged: it is not a file of a store",
        f"{path}.previous is used instead",
    ]


def test_a_damaged_file_is_kept_aside_and_does_not_replace_the_previous_version(tmp_path: Path) -> None:
    path = saved_twice(tmp_path)
    path.write_bytes(b"of another program")
    FileStore(path, "node").save(b"newest")
    assert path.with_name("node.bin.damaged").read_bytes() == b"of another program"
    path.write_bytes(b"damaged again")
    assert FileStore(path, "node").load() == OLD


def test_damage_is_known_as_damage_until_something_is_saved(tmp_path: Path) -> None:
    path = tmp_path / "node.bin"
    path.write_bytes(b"of another program")
    for _ in range(2):
        assert restore(FileStore(path, "node"), bytes) == (None, True)
    path.rename(tmp_path / "node.bin.damaged")  # killed while it saved, after this step
    assert restore(FileStore(path, "node"), bytes) == (None, True)
    FileStore(path, "node").save(NEW)
    assert restore(FileStore(path, "node"), bytes) == (NEW, False)


def test_content_that_the_device_does_not_accept_gives_the_previous_version(store: Store) -> None:
    def below_600(data: bytes) -> float:
        if (value := float(data)) > 600:
            raise ValueError(f"{value:g} is above 600")
        return value

    store.save(b"500")
    store.save(b"4684.8")
    assert restore(store, below_600) == (500.0, True)
    store.save(b"700")
    assert restore(store, below_600) == (None, True)


# ---- disks that take nothing


class Disk:
    """Makes every write fail for as long as `refusal` says."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.refusal: int | None = None
        real = os.fsync

        def fsync(fd: int) -> None:
            if self.refusal is not None:
                raise OSError(self.refusal, os.strerror(self.refusal))
            real(fd)

        monkeypatch.setattr(os, "fsync", fsync)


@pytest.mark.parametrize("refusal", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
def test_a_disk_that_accepts_nothing_leaves_the_old_and_is_reported_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, refusal: int
) -> None:
    caplog.set_level(logging.INFO)
    disk = Disk(monkeypatch)
    store = FileStore(tmp_path / "node.bin")
    store.save(OLD)
    disk.refusal = refusal
    for _ in range(3):
        with pytest.raises(StoreError) as refused:
            store.save(NEW)
        assert refused.value.errno == refusal
    assert (store.load(), store.trouble()) == (OLD, os.strerror(refusal))
    assert [path.name for path in tmp_path.iterdir()] == ["node.bin"]  # nothing half-written takes up room
    disk.refusal = None
    assert store.trouble() == ""  # also if nothing more is saved
    store.save(NEW)
    assert store.load() == NEW
    assert [record.getMessage() for record in caplog.records] == [
        f"{tmp_path / 'node.bin'} cannot be stored: {os.strerror(refusal)}; the old content is kept",
        f"{tmp_path / 'node.bin'} can be stored again",
    ]


def test_buffered_ram_has_room_on_the_disk_from_the_start(tmp_path: Path) -> None:
    path = tmp_path / "card.bin"
    FileStore(path).buffered_ram(100_000)
    found = path.with_suffix(".ram").stat()
    assert (found.st_size, found.st_blocks * 512 >= 100_000) == (100_000, True)


def test_buffered_ram_without_room_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def allocate(fd: int, offset: int, length: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    store = FileStore(tmp_path / "card.bin")
    with monkeypatch.context() as full:
        full.setattr(os, "posix_fallocate", allocate)
        with pytest.raises(StoreError):
            store.buffered_ram(4000)
        assert store.trouble() == os.strerror(errno.ENOSPC)
    store.buffered_ram(4000)
    assert store.trouble() == ""


def test_a_file_system_that_cannot_allocate_gets_zeros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def allocate(fd: int, offset: int, length: int) -> None:
        raise OSError(errno.EOPNOTSUPP, os.strerror(errno.EOPNOTSUPP))

    monkeypatch.setattr(os, "posix_fallocate", allocate)
    store = FileStore(tmp_path / "card.bin")
    store.buffered_ram(8)[3] = 7
    assert bytes(store.buffered_ram(12)) == bytes((0, 0, 0, 7)) + bytes(8)
