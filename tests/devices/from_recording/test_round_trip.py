"""Rigs are recorded with a master at work, rigs are made of the recordings alone, and the master's side is played."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from made_rigs import SdoMaster, keys_of, played, recorded, rig_file, save, virtual

from fieldrig import Rig
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec
from fieldrig_bus.can.frame import EXTENDED_MASK, CanFrame
from fieldrig_bus.can.notices import NOTICE
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.cia402.single.personality import Name

pytestmark = pytest.mark.long
CONFIGS = Path(__file__).parents[3] / "configs"
MOST_LATE_NS = 12 * MS
"""A control cycle of the slowest drive, and the time of some frames."""
LAB = ((0x1000, 0), (0x1018, 1), (0x1018, 2), (0x1017, 0), (0x1A00, 0), (0x1A00, 1), (0x1A00, 2), (0x1A01, 0),
       (0x1A01, 1), (0x1A01, 2), (0x1A01, 3), (0x1A01, 4), (0x1800, 1), (0x2FFF, 0), (0x1018, 9))  # fmt: skip


def streams(entries: Sequence[TraceEntry], log: Sequence[TraceEntry]) -> dict[tuple[str, int], list[TraceEntry]]:
    """Return the messages of the devices by bus, and identifier or unit, on the buses of the master."""
    buses = {entry.bus for entry in log if entry.sender == "master"}
    found: dict[tuple[str, int], list[TraceEntry]] = {}
    for entry in entries:
        if entry.sender == "master" or entry.bus not in buses:
            continue
        key = int.from_bytes(entry.data[:4], "little") if entry.family == "can" else entry.data[1]
        if entry.family == "can" and key & ~EXTENDED_MASK == NOTICE:
            continue  # a fault of the rig file that began
        found.setdefault((entry.bus, key), []).append(entry)
    return found


def differences(
    log: Sequence[TraceEntry], got: Sequence[TraceEntry], tolerance: int = 0, late_ns: int = MOST_LATE_NS
) -> list[str]:
    """Return what differs.

    Numbers at the end of an SDO answer may differ by `tolerance`, and instants by `late_ns`.
    """
    wanted, found = streams(log, log), streams(got, log)
    wrong = [f"{key}: only in one of the two" for key in wanted.keys() ^ found.keys()]
    for key in wanted.keys() & found.keys():
        if len(wanted[key]) != len(found[key]):
            wrong.append(f"{key}: {len(found[key])} messages, expected {len(wanted[key])}")
        for expected, entry in zip(wanted[key], found[key], strict=False):
            later_ns = entry.time_ns - expected.time_ns
            far = abs(_number(entry) - _number(expected)) if tolerance and len(entry.data) == 13 else 0
            is_same = entry.data[:9] == expected.data[:9] and far <= tolerance if far else entry.data == expected.data
            if abs(later_ns) > late_ns or not is_same:
                wrong.append(
                    f"{key}: {entry.data.hex()} at {entry.time_ns}, expected {expected.data.hex()}, {later_ns}"
                )
    return wrong


def _number(entry: TraceEntry) -> int:
    return int.from_bytes(entry.data[9:13], "little", signed=True)


def lab() -> list[TraceEntry]:
    """Record the lab for ten seconds: a master configures two nodes, starts them, and polls them and the pump."""
    with Rig(load(CONFIGS / "lab.yaml", ["time=virtual"])) as rig:
        entries = recorded(rig)
        master = SdoMaster(rig)
        pump = master.member.link("mb_tcp")
        rig.run_until(300 * MS)
        for node_id in (5, 6):
            for index, subindex in LAB:
                master.read(node_id, index, subindex)
            master.read(node_id, 0x1008)
            for turn in range(3):
                master.ask(node_id, f"{0x60 | turn % 2 << 4:02x}00000000000000")
        master.write(5, 0x1000, 0, 5, 4)
        master.write(5, 0x6423, 0, 1, 1)
        master.write(5, 0x1017, 0, 500, 2)
        master.can.send(CanFrame(0, b"\x01\x00"))
        rig.run_for(50 * MS)
        asked = ["06 0000 03e8", "05 0000 ff00", *["03 0000 0002", "04 0000 0003", "01 0000 0001"] * 60, "04 0100 0003"]
        for number, pdu in enumerate(asked, 1):
            pump.send(ModbusRequest(1, bytes.fromhex(pdu), number))
            rig.run_for(50 * MS)
            if number % 20 == 0:
                master.read(5, 0x6401, 1)
                master.read(6, 0x9130, 1)
        for frame in ("205#03000000", "305#1027000000000000"):
            identifier, data = frame.split("#")
            master.can.send(CanFrame(int(identifier, 16), bytes.fromhex(data)))
        rig.run_for(100 * MS)
        return entries


def test_the_lab_answers_as_it_was_recorded(tmp_path: Path) -> None:
    log = lab()
    with virtual(rig_file(save(log, tmp_path / "lab.jsonl"))) as rig:
        assert differences(log, played(rig, log)) == []


def test_a_log_of_candump_is_enough(tmp_path: Path) -> None:
    """The format knows no senders, and microseconds only."""
    log = [entry for entry in lab() if entry.family == "can"]
    with virtual(rig_file(save(log, tmp_path / "lab.log"))) as rig:
        rig.run_until(1 * S)
        assert [rig.get(f"node{node}/1008:00") for node in (5, 6)] == ["IO32", "Level sensor"]


def moved(personality: str | None) -> list[TraceEntry]:
    """Record a drive: a master resets, identifies, configures and enables it, and moves it."""
    chosen = [] if personality is None else [f"devices.axis.personality={personality}"]
    with Rig(load(CONFIGS / "drive.yaml", ["time=virtual", *chosen])) as rig:
        entries = recorded(rig)
        master = SdoMaster(rig, pause_ns=155 * MS)
        rig.run_until(100 * MS)
        master.can.send(CanFrame(0, b"\x81\x00"))
        rig.run_for(7 * S)
        for index in (0x1000, 0x1000, 0x6502, 0x605A, 0x6007, 0x603F, 0x6060, 0x6061, 0x6098, 0x6083, 0x6041):
            master.read(3, index)
        for index, subindex in ((0x1018, 1), (0x1018, 2), (0x607D, 1), (0x607D, 2), (0x608F, 1), (0x608F, 2)):
            master.read(3, index, subindex)
        master.write(3, 0x1017, 0, 200, 2)
        master.can.send(CanFrame(0, b"\x01\x03"))
        rig.run_for(200 * MS)
        master.write(3, 0x6060, 0, 1, 1)
        master.read(3, 0x6061)
        for word in (0x06, 0x0F, 0x07, 0x0F):
            master.write(3, 0x6040, 0, word, 2)
            master.read(3, 0x6041)
        for index, value in ((0x6081, 20_000_000), (0x6083, 100_000_000), (0x607A, 50_000_000)):
            master.write(3, index, 0, value, 4)
        master.write(3, 0x6040, 0, 0x1F, 2)
        for _ in range(12):
            master.read(3, 0x6041)
            master.read(3, 0x6064)
        for word in (0x0F, 0x06):
            master.write(3, 0x6040, 0, word, 2)
        return entries


@pytest.mark.parametrize("personality", [None, "runs-ahead", "mains-inverter"])
def test_a_drive_moves_as_it_was_recorded(tmp_path: Path, personality: str | None) -> None:
    log = moved(personality)
    with virtual(rig_file(save(log, tmp_path / "drive.jsonl"))) as rig:
        assert differences(log, played(rig, log), tolerance=20_000) == []


@pytest.mark.parametrize("personality", [None, *Name.__args__])  # type: ignore[attr-defined]
def test_the_personality_of_a_drive_is_recognised(tmp_path: Path, personality: str | None) -> None:
    device = keys_of(rig_file(save(moved(personality), tmp_path / "drive.jsonl")))["devices"]["node3"]
    assert (device["kind"], device.get("personality")) == ("cia402.drive", personality)
    assert "missing" not in device.get("behaviour", {})


def axis() -> list[TraceEntry]:
    """Record the axis of a MAx-4 on CAN: a master identifies, enables and turns it, and stops it."""
    with Rig(load(CONFIGS / "conveyor.yaml", ["time=virtual"])) as rig:
        entries = recorded(rig)
        master = SdoMaster(rig, pause_ns=20 * MS)
        rig.run_until(4 * S)
        for index in (0x1000, 0x1001, 0x6502, 0x6041, 0x6061, 0x6064, 0x6083, 0x1017):
            master.read(1, index)
        for index, subindex in ((0x1018, 1), (0x1018, 2), (0x1A00, 0), (0x1A00, 1), (0x1A00, 2), (0x1800, 1)):
            master.read(1, index, subindex)
        master.write(1, 0x1017, 0, 200, 2)
        master.can.send(CanFrame(0, b"\x01\x01"))
        rig.run_for(200 * MS)
        master.write(1, 0x6060, 0, 3, 1)
        master.read(1, 0x6061)
        for word in (6, 7, 0xF):
            master.write(1, 0x6040, 0, word, 2)
            rig.run_for(100 * MS)
            master.read(1, 0x6041)
        for speed in (200_000, 0):
            master.write(1, 0x60FF, 0, speed, 4)
            for _ in range(6):
                rig.run_for(50 * MS)
                master.read(1, 0x606C)
                master.read(1, 0x6041)
        master.write(1, 0x6040, 0, 6, 2)
        return [entry for entry in entries if entry.family == "can"]


def test_the_axis_of_a_controller_turns_as_it_was_recorded(tmp_path: Path) -> None:
    """How long a change of the speed takes depends on the load, which no log shows: up to 21 ms less here.

    The timers of the PDOs begin at these changes, so only changes are compared.
    """
    log = axis()
    with virtual(rig_file(save(log, tmp_path / "axis.jsonl"))) as rig:
        found = differences(changes(log), changes(played(rig, log)), tolerance=200_000, late_ns=25 * MS)
    assert found == []


def changes(entries: Sequence[TraceEntry]) -> list[TraceEntry]:
    """Return the messages without the PDOs that repeat their data."""
    kept, last = [], dict[bytes, bytes]()
    for entry in entries:
        is_pdo = entry.data[:2] in (b"\x81\x01", b"\x81\x02")
        if not is_pdo or last.get(entry.data[:4]) != entry.data:
            kept.append(entry)
        last[entry.data[:4]] = entry.data
    return kept


def cell() -> list[TraceEntry]:
    """Record the ARP cell, whose cards are masters themselves; what any master sends has the sender `master`."""

    def sender(entry: TraceEntry) -> str:
        identifier = int.from_bytes(entry.data[:4], "little")
        is_master = identifier in (0, 0x201, 0x202, 0x214) or identifier & 0x780 == 0x600
        return "master" if is_master else entry.sender

    with Rig(load(CONFIGS / "arp-cell.yaml", ["time=virtual"])) as rig:
        entries = recorded(rig)
        master = SdoMaster(rig, pause_ns=20 * MS)
        rig.run_until(1 * S)
        for node_id in (1, 2, 11, 12, 20):
            for index, subindex in ((0x1000, 0), (0x1018, 1), (0x1017, 0), (0x6401, 1), (0x6000, 1), (0x2000, 0)):
                master.read(node_id, index, subindex)
        return [entry._replace(sender=sender(entry)) for entry in entries if entry.family == "can"]


def test_the_cell_differs_only_in_what_its_rig_file_lists(tmp_path: Path) -> None:
    log = cell()
    path = rig_file(save(log, tmp_path / "cell.jsonl"))
    text = " ".join(path.read_text().replace("#", " ").split())
    assert "identifiers that no node accounts for: 24Bh (1 frame), 24Ch (1 frame)" in text
    assert text.count("its faults send them again") == 2  # EMCY of the two cards: 8Bh and 8Ch
    with virtual(path) as rig:
        found = differences(log, played(rig, log))
    missing = [f"('can0', {identifier}): only in one of the two" for identifier in (0x24B, 0x24C)]
    assert sorted(found) == sorted(missing)


def test_frames_are_compared() -> None:
    """The comparison itself finds a wrong byte, a missing frame and a late one."""
    sent = [TraceEntry(0, "can0", "can", "master", codec.encode(CanFrame(0)))]
    good = [*sent, TraceEntry(5 * MS, "can0", "can", "a", codec.encode(CanFrame(0x185, b"\x01")))]
    assert differences(good, good) == []
    for other in (
        sent,
        [*sent, TraceEntry(5 * MS, "can0", "can", "a", codec.encode(CanFrame(0x185, b"\x02")))],
        [*sent, TraceEntry(25 * MS, "can0", "can", "a", codec.encode(CanFrame(0x185, b"\x01")))],
    ):
        assert len(differences(good, other)) == 1
