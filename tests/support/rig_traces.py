"""Every rig file of configs/ in virtual time, with work for its devices, and a hash of what passes on each bus.

    python tests/support/rig_traces.py                    all of them
    python tests/support/rig_traces.py ring lab   some, by their names

A line is: file, bus, deliveries, SHA-256 of all of them (instant, sender, bytes, receivers).  Equal lines before and
after a change say that the change left every byte, instant and receiver as it was.  A file for real time runs
with its buses' virtual kinds.  `--keep FOLDER` writes the deliveries themselves, to see where two runs part.
"""

import argparse
import hashlib
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TextIO, get_origin

from pydantic.fields import FieldInfo
from rig_hands import START_ALL, SYNC, CanMaster, ModbusClient

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.kinds import bus_kinds_for, find_bus, settings_model
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal

CONFIGS = Path(__file__).parents[2] / "configs"
NOT_RIGS = ("plates", "registers", "eds", "programs")
SECONDS = 20
BOOTED_NS = 8 * S
"""When a MAx-4 has brought its ring up."""
READ_INPUTS = bytes.fromhex("04 0000 0002")
READ_HOLDING = bytes.fromhex("03 0000 000a")
DEVICE_TYPE = bytes.fromhex("40 00 10 00 00 00 00 00")

Act = tuple[int, Callable[[], None]]
"""When, and what."""


def files() -> list[Path]:
    return sorted(CONFIGS.glob("*.yaml"))


def virtual(path: Path) -> RigConfig:
    """The rig of a file; in a rig for real time, the virtual kinds replace the kinds of the buses."""
    config = load(path)
    if config.time == "virtual":
        return config
    overrides = ["time=virtual", "speed=max"]
    for name, entry in config.buses.items():
        kinds = bus_kinds_for("virtual", entry.bus.family)
        kind = next((kind for kind in kinds if kind.endswith(".virtual")), kinds[0])
        known = settings_model(find_bus(kind)).model_fields
        dumped = entry.bus.settings.model_dump(mode="json", exclude_defaults=True)
        # With a pty, a virtual bus has the times of a serial line; without one, traces stay comparable with older ones.
        kept = {key: value for key, value in dumped.items() if key in known and key != "pty" and value is not None}
        listed = {
            key: list(value) if _is_list(known[key]) else value
            for key, value in kept.items()
            if isinstance(value, dict)
        }
        words = ", ".join(f"{key}: {json.dumps(value)}" for key, value in {**kept, **listed}.items())
        overrides.append(f"buses.{name}={{kind: {kind}, {words}}}")
    return load(path, overrides)


def _is_list(field: FieldInfo) -> bool:
    return get_origin(field.annotation) in (list, tuple)


class Work:
    """The work that the devices of a rig get from outside, over their buses and points."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self._devices = rig, rig.config.devices
        names = {bus: entry.bus.family for bus, entry in rig.config.buses.items()}
        self._cans = {bus: CanMaster(rig, bus, f"plc of {bus}") for bus in names if names[bus] == "can"}
        clients = [bus for bus in names if names[bus] == "modbus"]
        self._modbus = {bus: ModbusClient(rig, bus, member=f"scada of {bus}") for bus in clients}
        wires = [bus for bus in names if names[bus] == "wires"]
        self._wires = [rig.attach(f"hand at {bus}").link(bus) for bus in wires]

    def script(self) -> list[Act]:
        acts = [*self._on_every_bus(), *self._of_the_lab(), *self._of_the_cell(), *self._of_the_ring()]
        return sorted(acts, key=lambda act: act[0])

    def _of_kind(self, kind: str) -> list[str]:
        return [name for name, entry in self._devices.items() if entry.kind == kind]

    def _on_every_bus(self) -> Iterator[Act]:
        nodes = sorted(
            {getattr(entry.settings, "node_id", 0) for entry in self._devices.values()} | {*range(1, 6), 11, 12}
        )
        for can in self._cans.values():
            yield 1 * MS, lambda can=can: can.send(START_ALL)  # type: ignore[misc]  # mypy #12557
            yield BOOTED_NS, lambda can=can: can.send(START_ALL)  # type: ignore[misc]
            yield 3 * S, lambda can=can: can.send(CanFrame(0x201, b"\x01"))  # type: ignore[misc]
            yield 9 * S, lambda can=can: can.send(CanFrame(0x305, bytes.fromhex("4c 1d 00 00")))  # type: ignore[misc]
            for turn in range(1, SECONDS * 10):
                yield turn * 100 * MS, lambda can=can: can.send(SYNC)  # type: ignore[misc]
                ask = CanFrame(0x600 + (nodes[turn % len(nodes)] or 127), DEVICE_TYPE)
                yield turn * 100 * MS + 50 * MS, lambda can=can, ask=ask: can.send(ask)  # type: ignore[misc]
        for client in self._modbus.values():
            for turn in range(1, SECONDS * 10):
                pdu = READ_HOLDING if turn % 2 else READ_INPUTS
                yield turn * 100 * MS + 7 * MS, lambda client=client, pdu=pdu: client.post(pdu)  # type: ignore[misc]

    def _of_the_lab(self) -> Iterator[Act]:
        if "plant.tank" in {entry.kind for entry in self._devices.values()}:
            for drive in self._of_kind("modbus.device"):
                yield 1 * S, lambda drive=drive: self._rig.set(drive, "speed_set", 80)  # type: ignore[misc]
                yield 2 * S, lambda drive=drive: self._rig.set(drive, "run", True)  # type: ignore[misc]

    def _of_the_cell(self) -> Iterator[Act]:
        if self._of_kind("arp"):
            yield 1 * S, lambda: self._rig.set("panel", "6200:01", 1)
            for when_ns, value in ((2 * S, True), (3 * S, False)):
                yield when_ns, lambda value=value: self._drive(Signal("panel.start", value))  # type: ignore[misc]

    def _of_the_ring(self) -> Iterator[Act]:
        drives = self._of_kind("mc4")
        for master in self._of_kind("max4"):
            links = self._devices[master].links
            can, client = self._cans[links["can"][0]], self._modbus[links["modbus"][0]]
            for place in range(len(drives)):
                at_ns = BOOTED_NS + place * 40 * MS
                if place % 2:
                    yield at_ns, lambda client=client, place=place: self._run_by_modbus(client, place)  # type: ignore[misc]
                else:
                    yield at_ns, lambda can=can, place=place: self._run_by_can(can, place)  # type: ignore[misc]
            yield 15 * S, lambda: self._fault(drives[1], {"what": "overtemperature", "duration_ms": 500})
            yield 16 * S, lambda master=master: self._rig.set(master, "command", "quit")  # type: ignore[misc]
            yield 17 * S, lambda: self._rig.set("panel", "6200:01", 0)
            yield 18 * S, lambda: self._rig.set("panel", "6200:01", 15)
            yield 18500 * MS, lambda: self._fault("ring", {"what": "break", "after": drives[0]})

    def _drive(self, signal: Signal) -> None:
        for link in self._wires:
            link.send(signal)

    def _run_by_modbus(self, client: ModbusClient, place: int) -> None:
        first = 1000 + 100 * place
        client.write(first, 1)
        while not client.read(first + 23)[0] & 4:
            self._rig.run_until(self._rig.now_ns + 4 * MS)
        if place % 4 == 1:  # there and back
            client.write(first + 1, 0, 0, 5_000, 0, 10_000, 0, 50_000, 0, 50_000, 0, 0, 0, 2)
        else:  # at a speed
            client.write(first + 1, 1, 0, 0, 0, 10_000, 0, 20_000, 0, 20_000, 0, 3_000 + place, 0, 1)

    def _run_by_can(self, can: CanMaster, place: int) -> None:
        can.run_at(1 + place // 8, place % 8, 2_000_000 + 10_000 * place)

    def _fault(self, where: str, fault: dict[str, Any]) -> None:
        self._rig.add_fault(where, fault)


class Trace:
    """The trace of one rig, as hashes and, if wanted, as a file."""

    def __init__(self, rig: str, keep: Path | None) -> None:
        self._rig, self._keep = rig, keep
        self._hashes: dict[str, Any] = {}
        self._counts: dict[str, int] = {}
        self._files: dict[str, TextIO] = {}
        self._stack = ExitStack()

    def on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        name, data = bus.name, bus.encode(delivery.message).hex()
        line = f"{delivery.time_ns} {delivery.sender} {data} {','.join(delivery.receivers)}\n"
        self._hashes.setdefault(name, hashlib.sha256()).update(line.encode())
        self._counts[name] = self._counts.get(name, 0) + 1
        if self._keep is not None:
            if name not in self._files:
                path = self._keep / f"{self._rig}.{name}.txt"
                self._files[name] = self._stack.enter_context(path.open("w", encoding="utf-8"))
            self._files[name].write(line)

    def close(self) -> list[str]:
        """A line for each bus on which anything passed."""
        self._stack.close()
        return [f"{self._rig} {bus} {self._counts[bus]} {found.hexdigest()}" for bus, found in self._hashes.items()]


def traces(path: Path, keep: Path | None = None) -> list[str]:
    trace = Trace(path.stem, keep)
    with Rig(virtual(path), trace.on_delivery) as rig:
        for when_ns, act in Work(rig).script():
            rig.run_until(max(when_ns, rig.now_ns))
            act()
        rig.run_until(SECONDS * S)
    return trace.close()


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rigs", nargs="*", help="names of files in configs/, without .yaml; none: all")
    parser.add_argument("--keep", type=Path, help="folder for the deliveries themselves")
    given = parser.parse_args(arguments)
    chosen = [CONFIGS / f"{name}.yaml" for name in given.rigs] or files()
    for path in chosen:
        for line in traces(path, given.keep):
            sys.stdout.write(f"{line}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
