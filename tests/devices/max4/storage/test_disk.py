"""The write cycles of the flash disk, which its users share with FTP (PacDrive manual 5217 and 6033)."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tcp_client import ServedConnection

from fieldrig.clock import VirtualClock
from fieldrig.storage.store import MemoryStore, StoreError
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.ftp.server import serving
from fieldrig_devices.max4.storage import disk as flash
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.ftp_files import FtpFiles

NAME = "\\A.HTM"


def full(store: MemoryStore | None = None) -> FlashDisk:
    return FlashDisk(store or MemoryStore(), 100_000)


def put(disk: FlashDisk, data: bytes) -> str:
    """Store a file by FTP, and return the last reply."""
    control = ServedConnection(serving(VirtualClock(), FtpFiles(disk), FtpLogin("service", "pacdrive")))
    control.send(b"USER service\r\nPASS pacdrive\r\nEPSV\r\nSTOR A.HTM\r\n")
    assert control.serve_extra is not None
    connection = ServedConnection(control.serve_extra)
    connection.send(data)
    connection.end()
    return control.take().decode().splitlines()[-1]


def test_each_write_is_a_cycle_that_outlives_the_power() -> None:
    store = MemoryStore()
    disk = full(store)
    free = disk.free
    assert put(disk, b"one").startswith("226 ")
    disk.write("\\a.htm", b"two")
    assert (disk.write_cycles(NAME), disk.most_cycles) == (2, 2)
    assert free - disk.free == flash.CLUSTER  # of the file; the counts take none
    disk.rename(NAME, "\\B.HTM")
    again = full(store)
    assert (again.write_cycles("\\B.HTM"), again.write_cycles(NAME)) == (2, 0)
    again.delete("\\B.HTM")
    assert again.most_cycles == 0
    assert full(store).most_cycles == 0


def test_ftp_cannot_write_a_worn_out_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flash, "WRITE_CYCLES", 2)
    disk = full()
    assert [put(disk, data)[:4] for data in (b"one", b"two", b"three")] == ["226 ", "226 ", "552 "]
    assert disk.read(NAME) == b"two"
    disk.delete(NAME)
    assert put(disk, b"four").startswith("226 ")


def test_a_write_that_the_store_refuses_is_no_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_data: bytes) -> None:
        raise StoreError(28, "No space left on device")

    store = MemoryStore()
    disk = full(store)
    disk.write(NAME, b"one")
    monkeypatch.setattr(store, "save", refuse)
    with pytest.raises(ValueError, match="cannot be written"):
        disk.write(NAME, b"two")
    assert (disk.write_cycles(NAME), disk.read(NAME)) == (1, b"one")


@given(st.binary(max_size=60))
def test_damaged_counts_are_no_counts(rubbish: bytes) -> None:
    store = MemoryStore()
    full(store).put_hidden("$CYCLES", rubbish)
    disk = full(store)
    before = disk.write_cycles(NAME)
    disk.write(NAME, b"one")
    assert disk.write_cycles(NAME) == before + 1


@given(st.sampled_from(["../", "/", "//", "\\", "$", "a/", "C:", "..\\", ""]), st.text(max_size=12))
def test_no_name_of_ftp_leads_out_of_the_disk_or_to_hidden_files(start: str, rest: str) -> None:
    disk = full()
    disk.put_hidden("$RETAIN", b"secret")
    disk.write(NAME, b"page")
    files = FtpFiles(disk)
    with suppress(ValueError):
        name = files.name_of(start + rest)
        assert not set(name) & set('\\/:*?"<>| ')
        for known in (name, rest):
            with suppress(ValueError):
                assert files.read(known) != b"secret"
            with suppress(ValueError):
                files.delete(known)
            with suppress(ValueError):
                files.write(known, b"mine")
    assert disk.hidden("$RETAIN") == b"secret"
    assert all(listed.startswith("\\") for listed in disk.names)


@pytest.mark.parametrize("path", ["OK.HTM", "\\OK.HTM", "/OK.HTM", "/\\ok.htm", "./ok.htm", ".\\OK.HTM"])
def test_a_page_has_the_name_of_the_manual(path: str) -> None:
    assert FtpFiles(full()).name_of(path) == "OK.HTM"


@pytest.mark.parametrize(
    "path",
    ["..", ".", "...", "", "/", "\\", "../A.HTM", "..\\A.HTM", "A/B.HTM", "A B.HTM", "A:B", "*.HTM", "a_b.htm", "$X",
     "~", "A" * 40, "é.htm", "a\0.htm", "C:\\A.HTM"],
)  # fmt: skip
def test_a_name_that_no_page_can_have_is_refused(path: str) -> None:
    with pytest.raises(ValueError, match="expected a file name"):
        FtpFiles(full()).name_of(path)


def test_a_file_of_a_program_is_reachable_whatever_its_name_is() -> None:
    disk = full()
    disk.write("\\LOG_1.TXT", b"log")
    assert FtpFiles(disk).name_of("log_1.txt") == "LOG_1.TXT"


def test_hidden_files_are_not_listed() -> None:
    disk = full()
    disk.put_hidden("$RETAIN", b"secret")
    disk.write(NAME, b"page")
    assert FtpFiles(disk).names == ["A.HTM"]
