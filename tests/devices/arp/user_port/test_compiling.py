"""A downloaded program compiles beside the card, whose control loops go on."""

import asyncio
import os
import signal
import struct
import zlib
from pathlib import Path

import pytest
from arp_user_port import PortBench, an_object, client
from in_loop import in_loop

from fieldrig.clock import MS
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.background_process import BackgroundProcesses
from fieldrig.storage.store import FileStore
from fieldrig_devices.arp.card.card import ArpCard
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.card_access import CardState, RefusedError
from fieldrig_devices.languages import resumable

OK, REFUSED, ORDER = 0, 5, 6
STOP, RUN, BEGIN, BLOCK, COMMIT, ABORT = 0x04, 0x03, 0x30, 0x31, 0x32, 0x33
COUNT = "L:\nV1 += 1\nWAIT 0.01\nGOTO L"
LONG, LONGER = (
    an_object("\n".join(f"V{number % 900 + 1} += {number}" for number in range(lines)), name="LONG")
    for lines in (400, 2_000)
)
FAST_LINE = {"baud": 1_000_000}
LONG_MS = len(LONG) * 5_000 / MS
"""The virtual time of its compilation, 5 us for each octet."""


def send_all(bench: PortBench, data: bytes) -> None:
    bench.ok(BEGIN, struct.pack("<II", len(data), zlib.crc32(data)))
    for offset in range(0, len(data), 240):
        bench.ok(BLOCK, struct.pack("<I", offset) + data[offset : offset + 240])


def committed(data: bytes) -> PortBench:
    """A stopped card that compiles a program."""
    bench = PortBench(COUNT, is_enabled=True, user_port=FAST_LINE)
    bench.ok(STOP)
    send_all(bench, data)
    assert bench.send(COMMIT) == []
    return bench


# ---- virtual time


@pytest.mark.long
def test_the_answer_comes_after_a_fixed_time_while_the_control_loops_go_on() -> None:
    bench = committed(LONG)
    begun_ns, cycles = bench.clock.now_ns(), bench.card.cycles
    bench.run_for(LONG_MS - 1)
    assert [body for body in bench.heard() if body[3] == 0xB2] == []
    assert (bench.access.program_name, bench.card.cycles - cycles) == ("program", int(LONG_MS - 1))
    bench.run_for(1)
    assert bench.clock.now_ns() == begun_ns + len(LONG) * 5_000
    assert bench.heard() == [bytes((1, 1, bench.sequence, 0xB2, OK))]
    assert (bench.access.program_name, bench.get("program.loading")) == ("LONG", 0)


@pytest.mark.long
def test_the_progress_is_sent_while_the_pc_waits_and_shown_by_a_point() -> None:
    bench = committed(LONG)
    shown = set()
    for _ in range(int(LONG_MS)):
        bench.run_for(1)
        shown.add(bench.get("program.loading"))
    bodies = [body for body in bench.heard() if body[3] == 0xE2]
    steps = [(body[12:].decode(), *struct.unpack("<II", body[4:12])) for body in bodies]
    assert steps == sorted(steps, key=lambda step: ("starting", "reading", "checking", "building").index(step[0]))
    assert [done for what, done, _ in steps if what == "reading"] != []
    assert {what for what, _, _ in steps} <= {"starting", "reading", "checking", "building"}
    assert len(shown) > 20  # hundredths


@pytest.mark.long
def test_the_client_is_told_of_the_progress() -> None:
    bench = PortBench(user_port=FAST_LINE)
    told: list[str] = []
    client(bench).download(LONG, on_compiling=lambda what, _done, _steps: told.append(what))
    assert bench.access.program_name == "LONG"
    assert "reading" in told


@pytest.mark.long
def test_a_commit_that_is_sent_again_meanwhile_is_not_carried_out_again() -> None:
    bench = committed(LONG)
    for number in (bench.sequence, bench.sequence + 1):  # the same frame, and another request
        assert bench.send(COMMIT, sequence=number) == []
    bench.run_for(LONG_MS + 1)
    answers = [body for body in bench.heard() if body[3] == 0xB2]
    assert answers == [bytes((1, 1, bench.sequence + 1, 0xB2, OK))]
    assert bench.send(COMMIT, sequence=bench.sequence + 1) == answers  # repeated, as its answer may be lost


@pytest.mark.long
def test_other_requests_are_answered_meanwhile() -> None:
    bench = committed(LONG)
    bench.run_for(10)
    bench.heard()
    assert bench.condition()[:2] == (CardState.STOPPED, 3)
    assert bench.ok(0x10, struct.pack("<BHH", ord("V"), 1, 1)) != b""


@pytest.mark.long
@pytest.mark.parametrize("command", [0x01, ABORT])
def test_a_hello_or_an_abort_ends_the_compilation(command: int) -> None:
    bench = committed(LONG)
    bench.run_for(10)
    bench.heard()
    bench.ok(command)
    assert bench.get("program.loading") == 0
    bench.run_for(LONG_MS + 10)
    assert (bench.heard(), bench.access.program_name) == ([], "program")


@pytest.mark.long
def test_a_program_that_was_started_meanwhile_is_not_replaced() -> None:
    bench = committed(LONG)
    bench.run_for(10)
    bench.heard()
    bench.ok(RUN)
    bench.run_for(LONG_MS)
    [answer] = [body for body in bench.heard() if body[3] == 0xB2]
    assert (answer[4], bench.access.program_name) == (REFUSED, "program")


def test_a_loaded_program_is_debugged_without_being_compiled_again(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = PortBench(is_enabled=True)
    bench.ok(0x05)  # reset
    assert bench.downloaded(an_object("L:\nV1 += 1\nV2 += 1\nWAIT 0.01\nGOTO L"))[0] == OK

    def compiled(*_: object) -> bytes:
        raise AssertionError("a build was made in the card's process")

    monkeypatch.setattr(resumable.Texts, "compiled", compiled)
    monkeypatch.setattr(resumable.Texts, "blocks", compiled, raising=False)
    assert bench.ok(0x40, struct.pack("<I", 4)) == struct.pack("<I", 4)
    bench.ok(RUN)
    bench.run_for(50)
    assert (bench.condition()[1], bench.condition()[5], bench.access.V[1]) == (3, 4, 1_000)
    bench.ok(0x43)  # step
    assert bench.condition()[5] == 5
    bench.ok(RUN)
    bench.run_for(50)
    assert bench.access.V[1:3] == [2_000, 1_000]


# ---- real time


class RealCard:
    """A card in a loop of its own, with a worker that a test can hold."""

    def __init__(self, folder: Path) -> None:
        self.clock = RealClock(asyncio.get_running_loop())
        self.processes = BackgroundProcesses(self.clock)
        settings = ArpSettings.model_validate({"inputs": {"I108": False}})
        store = FileStore(folder / "card.bin", "arp")
        self.card = ArpCard(self.clock, "card", settings, store, self.processes.of("card"))
        self.outcome: asyncio.Future[Exception | None] = asyncio.get_running_loop().create_future()
        self.clock.handle(self.card.start)

    async def until_cycles(self, count: int) -> None:
        until = self.card.cycles + count
        while self.card.cycles < until:
            await asyncio.sleep(0)

    async def begin(self) -> int:
        """Begin to load, and return the process id of the worker, which is held."""
        await self.until_cycles(50)  # from INIT to RESET
        self.clock.handle(self._load)
        while self.processes.pid is None:
            await asyncio.sleep(0)
        pid = self.processes.pid
        os.kill(pid, signal.SIGSTOP)
        return pid

    def _load(self) -> None:
        self.card.access.load(LONGER, self.outcome.set_result)

    def close(self) -> None:
        self.processes.close()
        self.clock.close()


@pytest.mark.system
@in_loop
async def test_the_control_loops_go_on_while_a_worker_compiles(tmp_path: Path) -> None:
    real = RealCard(tmp_path)
    try:
        pid = await real.begin()
        await real.until_cycles(300)  # would never end if the card waited for the worker
        assert not real.outcome.done()
        assert real.card.points()["program.loading"].read() == 0
        os.kill(pid, signal.SIGCONT)
        assert await real.outcome is None
        assert real.card.access.program_name == "LONG"
        assert real.card.operation.loading is None
        program = real.card.access.program
        assert program is not None
        assert [program.code.line(0, pc) for pc in (0, 1, 2_000)] == [2, 3, 2_002]
    finally:
        real.close()


@pytest.mark.system
@in_loop
async def test_a_killed_worker_is_a_refusal_and_leaves_the_card_as_it_was(tmp_path: Path) -> None:
    real = RealCard(tmp_path)
    try:
        os.kill(await real.begin(), signal.SIGKILL)
        reason = await real.outcome
        assert isinstance(reason, RefusedError)
        assert "killed by SIGKILL" in str(reason)
        assert real.card.access.program is None
        await real.until_cycles(10)
    finally:
        real.close()
