"""`dualport.shm`: words in a file that two processes map."""

import asyncio
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import VirtualClock
from fieldrig.errors import BusError
from fieldrig.link import words_behind
from fieldrig_bus.dualport.message import Words, check_sent, decode, encode, show
from fieldrig_bus.dualport.shm import DualPortSettings, DualPortShm, SharedMemory


class At:
    """The surroundings of an end, in a run folder."""

    def __init__(self, run: Path, member: str) -> None:
        self.run, self.member, self.clock = run, member, VirtualClock()
        self.traced: list[tuple[str, Any]] = []

    def path(self, name: str) -> Path:
        return self.run / name

    def heard(self, sender: str, message: Any) -> None:
        self.traced.append((sender, message))


def test_two_ends_and_a_master_outside_have_one_memory(tmp_path: Path) -> None:
    bus = DualPortShm("plc", DualPortSettings())
    at = At(tmp_path, "pam")
    pam, master = (asyncio.run(bus.open(end)) for end in (at, At(tmp_path, "master")))  # type: ignore[arg-type]
    words, others = words_behind(pam), words_behind(master)
    assert words is not None
    assert others is not None
    words[3] = 0x1234
    assert others[3] == 0x1234
    pam.send(Words(2046, (1, 2)))
    assert at.traced == [("pam", Words(2046, (1, 2)))]
    outside = SharedMemory(tmp_path / "dualport/plc")
    assert outside.read(2046, 2) == [1, 2]
    outside.write(0, [0xFFFF])
    assert words[0] == 0xFFFF
    outside.close()
    for member in ("pam", "master"):
        asyncio.run(bus.close(member))
    assert (tmp_path / "dualport/plc").stat().st_size == 4096
    assert str(tmp_path) in bus.tools(tmp_path)[0].line


def test_a_file_that_cannot_be_mapped_is_refused(tmp_path: Path) -> None:
    (tmp_path / "dualport").write_text("a file")
    with pytest.raises(BusError, match="cannot be mapped"):
        asyncio.run(DualPortShm("plc", DualPortSettings()).open(At(tmp_path, "pam")))  # type: ignore[arg-type]


def test_messages_in_bytes() -> None:
    assert encode(Words(5, (0x1234, 7))) == bytes.fromhex("0005 1234 0007")
    assert show(Words(5, (0x1234, 7))) == "word 5: 1234 0007"


@given(st.binary(max_size=20))
def test_any_bytes(data: bytes) -> None:
    with suppress(ValueError):
        assert encode(decode(data)) == data


@pytest.mark.parametrize("wrong", [Words(2047, (1, 2)), Words(0, (0x10000,)), Words(-1, ()), Words(0, (1.5,)), "words"])  # type: ignore[arg-type]
def test_words_that_no_memory_has(wrong: object) -> None:
    with pytest.raises((ValueError, TypeError)):
        check_sent(wrong)
