"""Output on a full disk: logs and `fieldrig up` go on, other commands end with a message."""

import io
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldrig.system.log_files import LogText
from fieldrig.system.steady_output import OutputError, SteadyFile, steady, strict

FULL = Path("/dev/full")
NO_SPACE = "No space left on device"

pytestmark = pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")


class Disk:
    """A descriptor to a disk that is full, and then has room."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.fd = os.open(FULL, os.O_WRONLY)

    def make_room(self) -> None:
        file = os.open(self.path, os.O_WRONLY | os.O_CREAT)
        os.dup2(file, self.fd)
        os.close(file)


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Disk]:
    disk = Disk(tmp_path / "out")
    yield disk
    os.close(disk.fd)


def test_what_a_full_disk_refuses_is_counted_and_writing_goes_on_when_there_is_room(disk: Disk) -> None:
    told: list[str] = []
    with os.fdopen(os.dup(disk.fd), "w") as stream:
        os.close(disk.fd)
        disk.fd = stream.fileno()
        output = steady(stream, told.append)
        for _ in range(3):
            print("lost", file=output, flush=True)
        disk.make_room()
        print("there", file=output, flush=True)
        print("more", file=output, flush=True)
        assert disk.path.read_text() == f"\n[15 bytes are missing here: {NO_SPACE}]\nthere\nmore\n"
        assert told == [NO_SPACE]
        disk.fd = os.dup(disk.fd)


def test_a_log_on_a_full_disk_takes_prints_and_log_records(disk: Disk, tmp_path: Path) -> None:
    text = LogText(disk.fd, tmp_path / "io.log")
    handler = logging.StreamHandler(text)
    for _ in range(1000):
        print("a line", file=text)
        handler.emit(logging.makeLogRecord({"msg": "a record"}))
    disk.make_room()
    print("there", file=text)
    assert disk.path.read_text() == f"\n[16000 bytes are missing here: {NO_SPACE}]\nthere\n"


def test_a_command_says_once_that_its_output_is_lost_and_drops_the_rest() -> None:
    with FULL.open("w", encoding="utf-8") as stream:
        output = strict(stream)
        with pytest.raises(OutputError, match=f"the output cannot be written: {NO_SPACE}"):
            print("lost", file=output, flush=True)
        print("lost too", file=output, flush=True)


def test_a_reader_that_has_gone_is_no_fault_of_ours() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as stream:
        assert SteadyFile(writing).write(b"x") == 1
        with pytest.raises(BrokenPipeError):
            print("lost", file=strict(stream), flush=True)


@pytest.mark.parametrize("closed", ["0<&-", ">&-", "2>&-", "0<&- >&- 2>&-"])
def test_a_file_never_gets_the_number_of_a_standard_file(tmp_path: Path, closed: str) -> None:
    code = (
        "import os, sys; from fieldrig.system.steady_output import open_missing; open_missing();"
        " print('out'); print('err', file=sys.stderr); sys.stdin.read(0);"
        f" open({str(tmp_path / 'fd')!r}, 'w').write(str(os.dup(0)))"
    )
    done = subprocess.run(["sh", "-c", f'exec "$0" -c "$1" {closed}', sys.executable, code], check=False)
    assert done.returncode == 0
    assert int((tmp_path / "fd").read_text()) > 2


@pytest.mark.parametrize(
    ("encoding", "errors", "expected"),
    [
        ("cp1252", "strict", b"40 \xb0C \\u2192 \\u03a9"),
        ("ascii", "strict", b"40 \\xb0C \\u2192 \\u03a9"),
        ("utf-8", "strict", "40 °C → Ω".encode()),
        ("ascii", "replace", b"40 ?C ? ?"),
    ],
)
def test_a_character_that_the_output_has_not_is_an_escape(
    tmp_path: Path, encoding: str, errors: str, expected: bytes
) -> None:
    path = tmp_path / "out"
    with path.open("w", encoding=encoding, errors=errors) as stream:
        same = strict(stream)
        same.write("40 °C → Ω")
        same.flush()
    assert path.read_bytes() == expected


def test_the_console_of_windows_stays_what_it_is() -> None:
    """It writes by calls of its own, and not to its descriptor, where letters beyond the code page would be lost."""

    class Console(io.RawIOBase):
        def fileno(self) -> int:
            return 1

        def writable(self) -> bool:
            return True

    console = io.TextIOWrapper(io.BufferedWriter(Console()), encoding="utf-8")
    assert strict(console) is console
    assert steady(console) is console
