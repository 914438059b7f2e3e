"""Mutated frames over SDO, PDO, NMT, EMCY, SYNC, LSS, guarding and TIME against the I/O module, with a fixed seed.

Valid dialogues are corrupted byte by byte and frame by frame.  In every case there is no exception, nothing is logged
above debug, the heartbeat goes on, and the dictionary is what an independent model says that it is.

What would end the heartbeat for good reason is kept away: 1017h is read-only, LSS takes no node-ID and no bit rate
with a delay away.
"""

import logging
import random
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from canopen_bench import IO32, CanopenBench, parse
from canopen_model import NOT_COMPARED, DictionaryModel, Frame

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.heartbeat import HeartbeatProducer
from fieldrig_devices.canopen.parameters import Parameters
from fieldrig_devices.canopen.pdo.rpdo import Rpdo
from fieldrig_devices.canopen.sdo.block import BlockDownload
from fieldrig_devices.canopen.sync import Sync

SEED = 2026
BATCH = 250
"""Frames between two looks at the whole dictionary."""
PERIOD_MS = 10
MS = 1_000_000


# Dialogues as masters hold them.
DIALOGUES: list[list[str]] = [
    ["605#40 00 10 00 00 00 00 00", "605#40 08 10 00 00 00 00 00"],
    ["605#2b 02 20 00 f6 ff 00 00", "605#40 02 20 00 00 00 00 00"],
    ["605#21 00 20 00 09 00 00 00", "605#00 31 32 33 34 35 36 37", "605#1b 38 39 00 00 00 00 00"],
    ["605#40 00 20 00 00 00 00 00", "605#60 00 00 00 00 00 00 00", "605#70 00 00 00 00 00 00 00"],
    ["605#c6 03 20 00 09 00 00 00", "605#01 31 32 33 34 35 36 37", "605#82 38 39 00 00 00 00 00",
     "605#d5 c3 31 00 00 00 00 00"],
    ["605#c0 03 20 00 00 00 00 00", "605#81 31 32 33 34 35 36 37", "605#c1 00 00 00 00 00 00 00"],
    ["605#a4 00 20 00 7f 00 00 00", "605#a3 00 00 00 00 00 00 00", "605#a2 03 7f 00 00 00 00 00",
     "605#a1 00 00 00 00 00 00 00"],
    ["605#a4 21 10 00 7f 00 00 00", "605#a3 00 00 00 00 00 00 00", "605#a2 7f 10 00 00 00 00 00",
     "605#a2 05 7f 00 00 00 00 00", "605#80 21 10 00 00 00 00 08"],
    ["605#23 00 18 01 85 01 00 c0", "605#2f 00 1a 00 00 00 00 00", "605#23 00 1a 01 10 01 01 64",
     "605#2f 00 1a 00 01 00 00 00", "605#2f 00 18 02 01 00 00 00", "605#23 00 18 01 85 01 00 40"],
    ["605#23 00 14 01 05 02 00 80", "605#2f 00 16 00 00 00 00 00", "605#23 00 16 01 10 01 11 64",
     "605#23 00 16 02 08 00 05 00", "605#23 00 16 03 08 02 00 62", "605#2f 00 16 00 03 00 00 00",
     "605#23 00 14 01 05 02 00 00"],
    ["605#2f 00 14 02 01 00 00 00", "205#01 02 03 04", "080#", "205#05 06 07 08", "080#"],
    ["605#2f 01 14 02 ff 00 00 00", "305#01 02 03 04 05 06 07 08", "305#01 02", "205#ff ff ff ff ff ff"],
    ["605#2b 00 14 05 20 00 00 00", "205#01 02 03 04"],
    ["605#23 07 10 00 88 13 00 00", "080#", "205#11 22 33 44", "080#"],
    ["605#2f 00 14 02 01 00 00 00", "605#23 07 10 00 0a 00 00 00", "080#", "205#31 32 33 34", "080#",
     "205#41 42 43 44", "080#"],
    ["605#2f 19 10 00 0a 00 00 00", "080#01", "080#02", "605#2f 19 10 00 00 00 00 00"],
    ["605#23 06 10 00 e8 03 00 00", "605#23 05 10 00 80 00 00 40", "605#23 05 10 00 80 00 00 00"],
    ["605#23 16 10 01 32 00 09 00", "709#05", "709#7f", "605#23 16 10 01 00 00 00 00"],
    ["605#2b 0c 10 00 14 00 00 00", "605#2f 0d 10 00 03 00 00 00", "705#R", "705#R"],
    ["605#23 28 10 03 83 00 00 00", "083#10 42 09 01 02 03 04 05", "605#23 28 10 03 83 00 00 80"],
    ["605#23 10 10 01 73 61 76 65"],
    ["605#23 10 10 02 73 61 76 65", "000#82 00"],
    ["605#23 11 10 01 6c 6f 61 64", "000#81 00"],
    ["605#23 20 10 01 2f 3d 00 00", "605#23 20 10 02 00 51 25 02"],
    ["605#23 01 12 01 10 02 00 00", "605#23 01 12 02 10 03 00 00", "210#40 00 10 00 00 00 00 00",
     "210#2f 07 62 01 55 00 00 00"],
    ["605#2f 02 60 01 0f 00 00 00", "605#2f 06 62 01 f0 00 00 00", "605#2f 00 62 01 aa 00 00 00"],
    ["100#00 51 25 02 2f 3d", "605#23 12 10 00 00 01 00 00", "605#23 12 10 00 00 01 00 40"],
    ["605#23 80 1f 00 00 00 00 00", "000#82 00"],
    ["7E5#04 01 00 00 00 00 00 00", "7E5#5e 00 00 00 00 00 00 00", "7E5#13 00 02 00 00 00 00 00",
     "7E5#11 05 00 00 00 00 00 00", "7E5#17 00 00 00 00 00 00 00", "7E5#04 00 00 00 00 00 00 00"],
    ["7E5#40 00 00 00 00 00 00 00", "7E5#41 20 00 00 00 00 00 00", "7E5#42 00 00 01 00 00 00 00",
     "7E5#43 01 00 00 00 00 00 00", "7E5#15 00 00 00 00 00 00 00"],
    ["7E5#51 00 00 00 00 80 00 00", "7E5#51 00 00 00 00 1f 00 00"],
    ["000#01 00"], ["000#01 05"], ["000#01 00"], ["000#80 00"], ["000#02 05"], ["000#01 00"], ["000#82 00"],
    ["185#R"], ["285#R"], ["080#"],
]  # fmt: skip


class TimedLink:
    """Takes what the node has sent at the present instant."""

    def __init__(self, bench: CanopenBench) -> None:
        self._bench = bench
        bench.take()

    def take(self) -> list[Frame]:
        now_ns = self._bench.clock.now_ns()
        return [Frame(now_ns, _key(frame), frame.data) for frame in self._bench.can.take()]


def _key(frame: CanFrame) -> int:
    return frame.identifier | (1 << 31 if frame.is_extended else 0)


def spoilt(chance: random.Random) -> Iterator[CanFrame]:
    """Frames without end: half of them as they should be, half of the rest with a byte wrong, the others worse."""
    while True:
        dialogue = [parse(text) for text in chance.choice(DIALOGUES)]
        if chance.random() < 0.1:
            chance.shuffle(dialogue)
        for frame in dialogue:
            fate = chance.random()
            if fate < 0.03:
                continue
            if fate < 0.06:
                yield frame
            yield frame if fate < 0.5 else mutated(frame, chance)


def mutated(frame: CanFrame, chance: random.Random) -> CanFrame:
    data, identifier, is_remote = bytearray(frame.data), frame.identifier, frame.is_remote
    kind = chance.random()
    if kind < 0.6 and data:
        position = chance.randrange(len(data))
        data[position] = chance.choice([data[position] ^ 1 << chance.randrange(8), 0, 0xFF, chance.randrange(256)])
    elif kind < 0.75:
        data = data[: chance.randrange(9)] + bytearray(chance.randbytes(chance.randrange(3)))
    elif kind < 0.85:
        data = bytearray(chance.randbytes(8))
    elif kind < 0.95:
        identifier = chance.choice([identifier ^ 1 << chance.randrange(11), chance.randrange(0x800)])
    else:
        is_remote = not is_remote
    return CanFrame(identifier, b"" if is_remote else bytes(data[:8]), is_remote=is_remote)


def tamed(frame: CanFrame) -> CanFrame:
    """LSS leaves the node its node-ID, and changes bit rates without a delay."""
    if frame.identifier == 0x7E5 and len(frame.data) == 8 and frame.data[0] in (0x11, 0x15):
        return CanFrame(0x7E5, bytes((frame.data[0], 5 if frame.data[0] == 0x11 else 0)) + bytes(6))
    return frame


@pytest.fixture
def eds(tmp_path: Path) -> Path:
    """The I/O module with a heartbeat that no client can stop, and that stays in its state after any error."""
    text = IO32.read_text()
    for name in ("[1017]\n", "[1029sub1]\n"):
        before, section, after = text.partition(name)
        assert section
        text = before + section + after.replace("AccessType=rw", "AccessType=ro", 1)
    path = tmp_path / "io32.eds"
    path.write_text(text)
    return path


def play(eds: Path, count: int) -> None:
    """Send this number of frames; AssertionError if the heartbeat or the dictionary is not as it should be."""
    chance = random.Random(SEED)
    bench = CanopenBench(eds, objects={"1017:00": PERIOD_MS, "1029:01": 1})
    link = TimedLink(bench)
    model = DictionaryModel(eds, 5, {(0x1017, 0): PERIOD_MS, (0x1029, 1): 1})
    frames, told = spoilt(chance), Told(bench)
    for number in range(1, count + 1):
        frame = tamed(next(frames))
        told.append(frame)
        bench.can.deliver(frame)
        bench.clock.advance_to(bench.clock.now_ns())
        came = link.take()
        model.went(Frame(bench.clock.now_ns(), _key(frame), frame.data, frame.is_remote), came)
        came += pass_time(bench, link, model, chance)
        told.check_heartbeat(came)
        if number % BATCH == 0 or number == count:
            told.check_dictionary(model)


@pytest.mark.long
def test_spoilt_frames_do_no_harm(eds: Path, fuzz_frames: int, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    play(eds, fuzz_frames)
    assert [record.getMessage() for record in caplog.records if not is_expected(record)] == []


# That the oracle is one: each of these faults of a node is found.

FAULTS = [
    (BlockDownload, "_check", lambda self: self._data.extend(b"!") if len(self._data) == 14 else None),
    (Parameters, "_on_change", lambda self: None),
    (Parameters, "_load", lambda self, group: None),
    (Rpdo, "_on_sync", lambda self, counter: None),
    (Rpdo, "_is_length_good", lambda self, frame: False),
    (Sync, "is_window_open", True),
    (Dictionary, "restore", lambda self, first, last: None),
    (HeartbeatProducer, "enter", lambda self, state: self._due.stop()),
]


@pytest.mark.long
@pytest.mark.parametrize(("service", "name", "fault"), FAULTS)
def test_fault_of_a_node_is_found(
    eds: Path, service: type, name: str, fault: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, name, fault)
    with pytest.raises(AssertionError):
        play(eds, 20_000)


def pass_time(bench: CanopenBench, link: TimedLink, model: DictionaryModel, chance: random.Random) -> list[Frame]:
    span_ms = chance.choice([0, 0, 0.05, 0.05, 0.5, 1, 3]) if chance.random() < 0.98 else chance.choice([30, 600, 1100])
    until_ns = bench.clock.now_ns() + round(span_ms * MS)
    all_came: list[Frame] = []
    while (next_ns := bench.clock.next_ns()) is not None and next_ns <= until_ns:
        bench.clock.advance_to(next_ns)
        came = link.take()
        model.went(Frame(next_ns, -1, b""), came)
        all_came += came
    bench.clock.advance_to(until_ns)
    return all_came


def is_expected(record: logging.LogRecord) -> bool:
    """Return whether a record is a report of the node's own.

    A mapping that was stored in the middle of its change leaves its PDO empty, and each EMCY message has a line.
    """
    text = record.getMessage()
    is_emcy = record.levelno == logging.INFO and re.fullmatch("error 8[0-9A-F]{3}", text) is not None
    return is_emcy or (record.levelno <= logging.WARNING and "the PDO stays empty" in text)


class Told:
    """The last frames, for the reader of a failure, and two views of the node."""

    def __init__(self, bench: CanopenBench) -> None:
        self._bench = bench
        self._last: list[str] = []
        self._beat_ns = bench.clock.now_ns()

    def append(self, frame: CanFrame) -> None:
        now_ms = self._bench.clock.now_ns() / MS
        self._last.append(f"{now_ms:.3f} {frame.identifier:03X}#{'R' if frame.is_remote else frame.data.hex(' ')}")
        del self._last[:-BATCH]

    def check_heartbeat(self, came: list[Frame]) -> None:
        for item in came:
            if item.key == 0x705:
                assert item.time_ns - self._beat_ns <= PERIOD_MS * MS, self._last[-30:]
                self._beat_ns = item.time_ns
        assert self._bench.clock.now_ns() - self._beat_ns <= PERIOD_MS * MS, self._last[-30:]

    def check_dictionary(self, model: DictionaryModel) -> None:
        dictionary = self._bench.node.dictionary
        found = {(item.index, item.subindex): item.data for item in dictionary if item.index not in NOT_COMPARED}
        wrong = {
            f"{index:04X}:{sub:02X}": (found[index, sub].hex(" "), expected.hex(" "))
            for (index, sub), expected in model.expected()
            if found[index, sub] != expected
        }
        assert wrong == {}, "\n".join(self._last)
