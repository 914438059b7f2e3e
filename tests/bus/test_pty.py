import asyncio
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig.errors import BusError
from fieldrig_bus.pty import MOST_PENDING, Pty

pytestmark = [pytest.mark.system, pytest.mark.skipif(sys.platform == "win32", reason="no ptys on Windows")]

OWNER = """
import asyncio, sys
from pathlib import Path
from fieldrig_bus.pty import Pty

async def main():
    Pty(Path(sys.argv[1])).open(print)
    print("ready", flush=True)
    await asyncio.Event().wait()

asyncio.run(main())
"""


@contextmanager
def client_of(pty: Pty) -> Iterator[int]:
    descriptor = os.open(pty.path, os.O_RDWR | os.O_NOCTTY)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def read_some(descriptor: int) -> bytes:
    readable, _, _ = select.select([descriptor], [], [], 5)
    return os.read(descriptor, 65536) if readable else b""


async def heard(received: list[bytes], count: int) -> bytes:
    async with asyncio.timeout(PATIENCE_S):
        while sum(map(len, received)) < count:
            await asyncio.sleep(0.001)
    return b"".join(received)


@in_loop
async def test_bytes_go_both_ways_unchanged_and_clients_come_and_go(tmp_path: Path) -> None:
    received: list[bytes] = []
    everything = bytes(range(256))
    with closing(Pty(tmp_path / "deep" / "com1")) as pty:
        pty.open(received.append)
        for _ in range(2):
            with client_of(pty) as client:
                received.clear()
                os.write(client, everything)
                assert await heard(received, 256) == everything
                pty.write(everything)
                assert read_some(client) == everything


@in_loop
async def test_nothing_is_left_after_closing(tmp_path: Path) -> None:
    pty = Pty(tmp_path / "com1")
    pty.open(print)
    pty.close()
    pty.close()
    assert list(tmp_path.iterdir()) == []


@in_loop
async def test_link_of_a_living_owner_is_refused_and_stays(tmp_path: Path) -> None:
    first, second = Pty(tmp_path / "com1"), Pty(tmp_path / "com1")
    first.open(print)
    with pytest.raises(BusError, match="another rig that is running"):
        second.open(print)
    assert (tmp_path / "com1").exists()
    first.close()
    second.open(print)
    second.close()


@in_loop
async def test_link_of_a_killed_owner_is_replaced(tmp_path: Path) -> None:
    link = tmp_path / "com1"
    owner = subprocess.Popen([sys.executable, "-c", OWNER, str(link)], stdout=subprocess.PIPE)
    assert owner.stdout is not None
    assert owner.stdout.readline() == b"ready\n"
    with pytest.raises(BusError, match="another rig"):
        Pty(link).open(print)
    owner.send_signal(signal.SIGKILL)
    owner.wait()
    owner.stdout.close()
    assert link.is_symlink()
    pty = Pty(link)
    pty.open(print)
    assert link.resolve().exists()
    pty.close()


@in_loop
async def test_what_is_no_stale_link_of_ours_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("dear")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    for name in ("file", "link"):
        with pytest.raises(BusError, match="choose another path"):
            Pty(tmp_path / name).open(print)
    assert (tmp_path / "file").read_text() == (tmp_path / "link").read_text() == "dear"
    assert len(list(tmp_path.iterdir())) == 2


@in_loop
async def test_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(BusError, match="file/com1"):
        Pty(tmp_path / "file" / "com1").open(print)


@in_loop
async def test_writing_without_a_reader_neither_blocks_nor_grows_and_loses_whole_messages(tmp_path: Path) -> None:
    message = b"t1238" + b"0011223344556677" + b"\r"
    got = b""
    with closing(Pty(tmp_path / "com1")) as pty:
        pty.open(print)
        for _ in range(20_000):
            pty.write(message)
        with client_of(pty) as client:
            async with asyncio.timeout(PATIENCE_S):
                while len(got) < MOST_PENDING:
                    await asyncio.sleep(0.001)
                    got += read_some(client)
    assert got.startswith(message)


@in_loop
async def test_baud_rate_is_what_the_client_set(tmp_path: Path) -> None:
    import termios

    with closing(Pty(tmp_path / "com1")) as pty:
        pty.open(print)
        with client_of(pty) as client:
            attributes = termios.tcgetattr(client)
            attributes[4] = attributes[5] = termios.B115200
            termios.tcsetattr(client, termios.TCSANOW, attributes)
            assert pty.baud() == 115200


@pytest.mark.parametrize("name", ["modbus.new", "modbus.lock"])
def test_files_of_another_program_beside_the_link_stay(name: str, tmp_path: Path) -> None:
    other = tmp_path / name
    other.write_text("of another program")

    async def scene() -> None:
        pty = Pty(tmp_path / "modbus")
        try:
            pty.open(lambda _data: None)
        except BusError as refused:
            assert "is a file of another program" in refused.what  # noqa: PT017  the other name is no reason to refuse
        pty.close()

    asyncio.run(scene())
    assert other.read_text() == "of another program"
