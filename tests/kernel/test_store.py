import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fieldrig.store import FileStore, MemoryStore, Store


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
from fieldrig.store import FileStore
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
from fieldrig.store import FileStore
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
