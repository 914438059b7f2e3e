"""A pty whose owner wants to know whether a client is there."""

import asyncio
import errno
import fcntl
import os
import select
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig_bus import pty as pty_module
from fieldrig_bus.pty import MOST_PENDING, Pty

pytestmark = [pytest.mark.system, pytest.mark.skipif(sys.platform != "linux", reason="Linux reports who opens a pty")]

CLIENT = """
import os, signal, sys
client = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
os.write(client, b"here")
signal.pause()
"""
TIOCGEXCL = 0x8004_5440


class Owner:
    """An owner that notes what happens, in order."""

    def __init__(self, link: Path) -> None:
        self.pty = Pty(link)
        self.noted: list[bytes | bool] = []
        self.pty.open(self.noted.append, self.noted.append)

    def close(self) -> None:
        self.pty.close()

    @property
    def data(self) -> bytes:
        return b"".join(entry for entry in self.noted if isinstance(entry, bytes))

    @property
    def presence(self) -> list[bool]:
        return [entry for entry in self.noted if isinstance(entry, bool)]

    async def until(self, is_so: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not is_so():
                await asyncio.sleep(0.001)

    def client(self) -> int:
        return os.open(self.pty.path, os.O_RDWR | os.O_NOCTTY)


@contextmanager
def killed_client(owner: Owner) -> Iterator[None]:
    with subprocess.Popen([sys.executable, "-c", CLIENT, str(owner.pty.path)]) as client:
        try:
            yield
        finally:
            client.send_signal(signal.SIGKILL)


async def turns(count: int = 20) -> None:
    """Let the event loop handle everything that is there."""
    for _ in range(count):
        await asyncio.sleep(0)


@in_loop
async def test_a_client_that_only_listens_is_noticed(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        await turns()
        assert owner.noted == []
        client = owner.client()
        await owner.until(lambda: owner.noted == [True])
        owner.pty.write(b"RING")
        assert os.read(client, 10) == b"RING"
        os.close(client)
        await owner.until(lambda: owner.noted == [True, False])


@in_loop
async def test_what_a_client_wrote_before_it_closed_arrives_before_its_end(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        for _ in range(20):
            owner.noted.clear()
            client = owner.client()
            os.write(client, b"A" * 3000)
            os.close(client)
            await owner.until(lambda: owner.presence == [True, False])
            assert owner.data == b"A" * 3000
            assert owner.noted[-1] is False


@in_loop
async def test_a_client_that_is_killed_is_noticed(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        with killed_client(owner):
            await owner.until(lambda: owner.data == b"here")
            assert owner.presence == [True]
        await owner.until(lambda: owner.presence == [True, False])


@in_loop
async def test_a_client_is_there_until_the_last_one_has_closed(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        first = owner.client()
        await owner.until(lambda: owner.presence == [True])
        os.close(owner.client())  # as `stty -F` does
        second = owner.client()
        await turns()
        os.close(first)
        await turns()
        assert owner.presence == [True]
        os.close(second)
        await owner.until(lambda: owner.presence == [True, False])


@in_loop
async def test_a_client_that_follows_at_once_is_another_one(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        client = owner.client()
        await owner.until(lambda: owner.presence == [True])
        os.close(client)
        client = owner.client()  # before the owner has noticed anything
        await owner.until(lambda: owner.presence == [True, False, True])
        os.write(client, b"ATZ")
        await owner.until(lambda: owner.data == b"ATZ")
        os.close(client)
        await owner.until(lambda: owner.presence == [True, False, True, False])


@in_loop
async def test_a_client_that_left_while_reading_was_paused_is_not_the_next_one(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        client = owner.client()
        await owner.until(lambda: owner.presence == [True])
        owner.pty.read_on(False)
        os.close(client)
        await turns()
        client = owner.client()
        await owner.until(lambda: owner.presence == [True, False, True])
        os.close(client)
        owner.pty.read_on(True)
        await owner.until(lambda: owner.presence == [True, False, True, False])


@in_loop
async def test_a_client_that_has_come_and_gone_without_a_word_is_not_noticed(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        os.close(owner.client())
        await turns()
        assert owner.noted == []


@in_loop
async def test_what_is_written_without_a_client_is_lost(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        owner.pty.write(b"lost")
        client = owner.client()
        await owner.until(lambda: owner.noted == [True])
        for _ in range(2 * MOST_PENDING // 1000):
            owner.pty.write(b"u" * 1000)  # unread, in the kernel and here
        os.close(client)
        await owner.until(lambda: owner.noted == [True, False])
        owner.pty.write(b"lost as well")
        client = owner.client()
        await owner.until(lambda: owner.noted == [True, False, True])
        owner.pty.write(b"new")
        assert os.read(client, 100) == b"new"
        os.close(client)


@in_loop
async def test_the_owner_rests_while_there_is_no_client(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        client = owner.client()
        await owner.until(lambda: owner.noted == [True])
        os.close(client)
        await owner.until(lambda: owner.noted == [True, False])
        await turns()
        before_s = time.thread_time()
        await asyncio.to_thread(select.select, [], [], [], 0.2)
        assert time.thread_time() - before_s < 0.05


@in_loop
async def test_settings_of_a_client_stay_for_the_next_one(tmp_path: Path) -> None:
    with closing(Owner(tmp_path / "com1")) as owner:
        assert owner.pty.set_baud(9600)
        client = owner.client()
        attributes = termios.tcgetattr(client)
        assert attributes[4:6] == [termios.B9600] * 2
        assert not attributes[3] & (termios.ECHO | termios.ICANON)
        attributes[4] = attributes[5] = termios.B19200
        termios.tcsetattr(client, termios.TCSANOW, attributes)
        attributes = termios.tcgetattr(client)
        os.write(client, b"x")
        os.close(client)
        await owner.until(lambda: owner.presence == [True, False])
        assert owner.pty.baud() == 19200
        client = owner.client()
        assert termios.tcgetattr(client) == attributes
        os.close(client)


@in_loop
async def test_a_pty_that_a_killed_client_has_reserved_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def reserved(pty: Pty) -> None:  # as the kernel tells all users but root after TIOCEXCL
        raise OSError(errno.EBUSY, os.strerror(errno.EBUSY), str(pty.path))

    with closing(Owner(tmp_path / "com1")) as owner:
        owner.pty.set_baud(19200)
        client = owner.client()
        fcntl.ioctl(client, termios.TIOCEXCL)
        os.write(client, b"here")
        os.close(client)
        with monkeypatch.context() as as_user:
            as_user.setattr(Pty, "_clean", reserved)
            await owner.until(lambda: owner.presence == [True, False])
        client = owner.client()
        assert fcntl.ioctl(client, TIOCGEXCL, bytes(4)) == bytes(4)
        await owner.until(lambda: owner.presence == [True, False, True])
        assert owner.pty.baud() == 19200
        os.write(client, b" again")
        await owner.until(lambda: owner.data == b"here again")
        os.close(client)
        await owner.until(lambda: owner.presence == [True, False, True, False])


@in_loop
async def test_without_reports_of_the_system_a_client_counts_as_present(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(_path: str) -> None:
        raise OSError("no more inotify instances")

    monkeypatch.setattr(pty_module, "OpenWatch", none)
    with closing(Owner(tmp_path / "com1")) as owner:
        assert owner.noted == [True]
        owner.pty.write(b"kept")
        client = owner.client()
        assert os.read(client, 10) == b"kept"
        os.write(client, b"x")
        await owner.until(lambda: owner.data == b"x")
        os.close(client)
        await turns()
        assert owner.presence == [True]
