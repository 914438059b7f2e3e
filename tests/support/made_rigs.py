"""Rigs that are made from recordings: written into a folder, and run in virtual time with a master."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fieldrig import Rig
from fieldrig.config.rig_file import load
from fieldrig.config.yaml_source import read
from fieldrig.traces import trace_files
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.from_recording.content import Made, content_for


def written_log(folder: Path, *lines: str) -> Path:
    """Write a log of candump with lines such as "0.25 705#00", or "0.25 can1 705#00"."""
    file = folder / "machine.log"
    rows = []
    for line in lines:
        seconds, *bus, frame = line.split()
        rows.append(f"({float(seconds):.6f}) {bus[0] if bus else 'can0'} {frame}\n")
    file.write_text("".join(rows))
    return file


def read_by_sdo(at_s: float, node_id: int, answer: str) -> list[str]:
    """Return the lines of an expedited upload whose answer is these eight bytes, in hex without spaces."""
    request = f"40{answer[2:8]}00000000"
    return [f"{at_s} {0x600 + node_id:03X}#{request}", f"{at_s + 0.001} {0x580 + node_id:03X}#{answer}"]


def put(made: Made, folder: Path) -> Path:
    """Write the files, and return the rig file."""
    for path, data in made.content.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
    return folder / next(iter(made.content))


def rig_file(log: Path, *words: str) -> Path:
    """Make a rig of a recording, and return its file."""
    return put(content_for(log, words), log.parent / "rig")


def keys_of(rig: Path) -> Any:
    return read(rig.read_text(encoding="utf-8"), rig.name).data


def virtual(rig: Path) -> Rig:
    return Rig(load(rig, ["time=virtual"]))


def recorded(rig: Rig) -> list[TraceEntry]:
    """Return the list that takes all messages of a rig from now on."""
    entries: list[TraceEntry] = []

    def take(bus: Any, delivery: Any) -> None:
        entries.append(
            TraceEntry(delivery.time_ns, bus.name, bus.family, delivery.sender, bus.encode(delivery.message))
        )

    rig.on_delivery(take)
    return entries


class SdoMaster:
    """A client of the default SDO channels of a bus."""

    def __init__(self, rig: Rig, bus: str = "can0", pause_ns: int = 5_000_000) -> None:
        self.rig, self._pause_ns = rig, pause_ns
        self.member = rig.attach("master")
        self.can = self.member.link(bus)
        self._answers: list[CanFrame] = []
        self.can.on_receive(self._on_frame)

    def _on_frame(self, frame: CanFrame) -> None:
        if frame.identifier & 0x780 == 0x580:
            self._answers.append(frame)

    def ask(self, node_id: int, request: str) -> str:
        """Send eight bytes in hex, and return those of the answer; "" if there is none."""
        self._answers.clear()
        self.can.send(CanFrame(0x600 + node_id, bytes.fromhex(request)))
        self.rig.run_for(self._pause_ns)
        return self._answers[0].data.hex(" ") if self._answers else ""

    def read(self, node_id: int, index: int, subindex: int = 0) -> str:
        return self.ask(node_id, bytes((0x40, *index.to_bytes(2, "little"), subindex, 0, 0, 0, 0)).hex())

    def write(self, node_id: int, index: int, subindex: int, value: int, size: int) -> str:
        head = bytes((0x23 | 4 - size << 2, *index.to_bytes(2, "little"), subindex))
        return self.ask(node_id, (head + value.to_bytes(4, "little", signed=value < 0)).hex())


def played(rig: Rig, log: Sequence[TraceEntry], master: str = "master") -> list[TraceEntry]:
    """Play the messages of a member of a log in a rig, at their instants, and return what the rig has sent."""
    entries = recorded(rig)
    member = rig.attach(master)
    links = {entry.bus: member.link(entry.bus) for entry in log if entry.sender == master}
    for entry in log:
        if entry.sender == master:
            rig.run_until(max(entry.time_ns, rig.now_ns))
            links[entry.bus].send(rig.buses[entry.bus].decode(entry.data))
    rig.run_until(log[-1].time_ns + 1_000_000)
    return [entry for entry in entries if entry.bus in links and entry.sender != master]


def save(log: Sequence[TraceEntry], file: Path) -> Path:
    trace_files.write(log, file)
    return file
