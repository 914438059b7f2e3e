"""Corrupted files at every reader: rigs, register tables, name plates, EDS files, traces, tokens, stores.

A configuration that is wrong is refused by the errors that are meant for it.  A store is damaged and the device starts
without it, or it is as good as another.
"""

import random
import shutil
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench
from pydantic import ValidationError
from spoiling import spoilt, spoilt_file, spoilt_json, spoilt_lines
from storing_devices import KINDS, Storing

from fieldrig.config import rig_file as config
from fieldrig.errors import ConfigError, ControlError, UsageError
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, token
from fieldrig.outside.untrusted import MalformedError, read_json
from fieldrig.storage import store_format
from fieldrig.storage.store import RAM, FileStore, MemoryStore
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read as read_trace
from fieldrig.traces.trace_files import write as write_trace
from fieldrig_bus.can.codec import encode as can
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus import codec as modbus
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.canopen.eds.text import EdsError
from fieldrig_devices.hiperface.plate_file import load_plate
from fieldrig_devices.registers.table import load_table

pytestmark = pytest.mark.system

SEED = 2026
CONFIGS = Path(__file__).parents[2] / "configs"
SLOW = pytest.mark.share(0.05)
SLOWEST = pytest.mark.share(0.02)


def _fuzz(
    chance: random.Random, make: Callable[[random.Random, list[bytes]], bytes], seeds: list[bytes], inputs: int,
    look: Callable[[bytes], Any],
) -> None:  # fmt: skip
    for _ in range(inputs):
        data = make(chance, seeds)
        try:
            look(data)
        except Exception as fault:
            raise AssertionError(f"{data!r}: {fault!r}") from fault


# Configuration


@SLOWEST
@pytest.mark.parametrize("name", [path.name for path in sorted(CONFIGS.glob("*.yaml"))])
def test_a_rig_file_is_loaded_or_refused(name: str, tmp_path: Path, inputs_a_target: int) -> None:
    folder = shutil.copytree(CONFIGS, tmp_path / "configs")
    path = folder / "spoilt.yaml"

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(ConfigError):
            config.load(path)

    _fuzz(random.Random(f"{SEED}/{name}"), spoilt_file, [(CONFIGS / name).read_bytes()], inputs_a_target, look)


@SLOW
@pytest.mark.parametrize(("folder", "load"), [("registers", load_table), ("plates", load_plate)])
def test_a_file_that_a_rig_names_is_loaded_or_refused(
    folder: str, load: Callable[[Path], Any], tmp_path: Path, inputs_a_target: int
) -> None:
    path = tmp_path / "spoilt.yaml"

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(ConfigError):
            load(path)

    seeds = [item.read_bytes() for item in sorted((CONFIGS / folder).glob("*.yaml"))]
    _fuzz(random.Random(f"{SEED}/{folder}"), spoilt_file, seeds, inputs_a_target, look)


@SLOW
@pytest.mark.parametrize("seed", [LEVEL_SENSOR, IO32], ids=["level-sensor", "io32"])
def test_an_eds_file_becomes_a_running_node_or_is_refused(seed: Path, tmp_path: Path, inputs_a_target: int) -> None:
    """The reader keeps what it read by name and time of the file, so each input has a name of its own."""
    names = (tmp_path / f"{number}.eds" for number in range(1 << 62))

    def look(data: bytes) -> None:
        path = next(names)
        path.write_bytes(data)
        for found in check_eds(path):
            assert str(found)
        try:
            eds.load(path, 5)
            bench = CanopenBench(path)
        except (EdsError, ValidationError, ConfigError):
            return
        finally:
            path.unlink()
        bench.after(20)
        bench.send("000#01 05", "080#", "605#40 00 10 00 00 00 00 00", "605#23 10 10 01 73 61 76 65")
        bench.after(20)
        for point in bench.node.points().values():
            point.read()

    _fuzz(random.Random(f"{SEED}/{seed.name}"), spoilt_file, [seed.read_bytes()], inputs_a_target, look)


def test_the_file_of_the_token_is_read_or_refused(
    tmp_path: Path, inputs_a_target: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "token"
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    monkeypatch.setenv(FILE_VARIABLE, str(path))

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(ConfigError):
            secret = token()
            assert secret
            assert secret.isprintable()

    seeds = [b"q7hR-2_secret\n", b"  blank before and behind \r\n", "schl\u00fcssel".encode()]
    _fuzz(random.Random(f"{SEED}/token"), spoilt, seeds, inputs_a_target, look)


TRACES = [
    ".jsonl",
    ".log",
    ".asc",
    ".blf",
    ".trc",
    ".csv",
    ".db",
    ".pcap",
    ".pcapng",
    pytest.param(".mf4", marks=SLOWEST),
]


@pytest.mark.parametrize("suffix", TRACES)
def test_a_trace_is_read_or_refused(suffix: str, tmp_path: Path, inputs_a_target: int) -> None:
    path = tmp_path / f"trace{suffix}"
    entries = [TraceEntry(number, "can0", "can", "io", bytes.fromhex("23010000020501")) for number in range(3)]
    assert write_trace(entries, path) == len(entries)

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(UsageError):
            list(read_trace(path))

    _fuzz(random.Random(f"{SEED}/{suffix}"), spoilt, [path.read_bytes()], inputs_a_target, look)


@pytest.mark.parametrize("suffix", [".jsonl", ".log", ".asc", ".trc", ".csv", ".gvret"])
def test_a_log_of_text_with_other_fields_is_read_or_refused(suffix: str, tmp_path: Path, inputs_a_target: int) -> None:
    path, seeds = tmp_path / f"trace{suffix}", list[bytes]()
    for begin_ns in (0, 1_700_000_000_123_456_000):
        frames = (CanFrame(0x181, b"\1\2"), CanFrame(0x1ABCDEF0, bytes(8), is_extended=True), CanFrame(0x705, b"\5"))
        write_trace(
            [TraceEntry(begin_ns + n * 1_234_000, "can1", "can", "", can(f)) for n, f in enumerate(frames)], path
        )
        seeds.append(path.read_bytes())

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(UsageError):
            odd = Oddities()
            list(read_trace(path, odd=odd))
            assert all(map(str, odd))

    _fuzz(random.Random(f"{SEED}/fields/{suffix}"), spoilt_lines, seeds, inputs_a_target, look)


def test_a_capture_with_tcp_streams_is_read_or_refused(tmp_path: Path, inputs_a_target: int) -> None:
    path = tmp_path / "trace.pcap"
    asked, answered = ModbusRequest(1, bytes.fromhex("03006b0003"), 7), ModbusResponse(1, bytes.fromhex("03020001"), 7)
    messages: list[tuple[str, ModbusMessage]] = [("a", asked), ("unit", answered)] * 4
    entries = [
        TraceEntry(n, "mb", "modbus", sender, modbus.encode(message)) for n, (sender, message) in enumerate(messages)
    ]
    assert write_trace(entries, path) == len(entries)

    def look(data: bytes) -> None:
        path.write_bytes(data)
        with suppress(UsageError):
            list(read_trace(path))

    _fuzz(random.Random(f"{SEED}/tcp"), spoilt, [path.read_bytes()], inputs_a_target, look)


# Stores


def test_a_file_of_a_store_is_whole_or_damaged(inputs_a_target: int) -> None:
    good = store_format.encode("x", b"what the device kept")

    def look(data: bytes) -> None:
        with suppress(ValueError):
            assert data == store_format.encode("x", store_format.decode("x", data))

    _fuzz(random.Random(f"{SEED}/store"), spoilt, [good], inputs_a_target, look)


def _use(device: Storing) -> None:
    """Ask it as a client does.  The client raises if an answer differs from that of a device with a good store."""
    for ask in (device.read, lambda: device.write(7), device.read):
        try:
            ask()
        except (AssertionError, ValueError, KeyError, ControlError) as complaint:
            asker = traceback.extract_tb(complaint.__traceback__)[-1].filename
            if not isinstance(complaint, ControlError) and "support" not in Path(asker).parts:
                raise


@SLOWEST
@pytest.mark.parametrize("kind", KINDS)
def test_a_device_starts_on_whatever_its_store_holds(kind: str, inputs_a_target: int) -> None:
    """The checksum of the file has no mistakes: only the device itself can tell what it cannot have saved."""
    power_on = KINDS[kind]
    good = MemoryStore()
    power_on(good).write(7)
    saved, ram = good.load(), bytes(good._ram)
    assert saved is not None
    try:
        read_json(saved)
    except MalformedError:
        make = spoilt
    else:
        make = spoilt_json
    chance = random.Random(f"{SEED}/{kind}")

    def look(data: bytes) -> None:
        store = MemoryStore(data if chance.random() < 0.9 else None)
        if ram:
            store.buffered_ram(len(ram))[:] = spoilt(chance, [ram]).ljust(len(ram), b"\0")[: len(ram)]
        _use(power_on(store))
        power_on(store)

    _fuzz(chance, make, [saved], inputs_a_target, look)


@SLOWEST
@pytest.mark.parametrize("kind", KINDS)
def test_a_device_starts_on_whatever_lies_in_the_place_of_its_files(
    kind: str, tmp_path: Path, inputs_a_target: int
) -> None:
    power_on = KINDS[kind]
    path = tmp_path / "state" / "device.bin"
    for value in (1, 2):
        assert power_on(FileStore(path, kind)).write(value)
    files = {item: item.read_bytes() for item in path.parent.iterdir() if item.suffix != RAM}
    chance = random.Random(f"{SEED}/files of {kind}")

    def look(data: bytes) -> None:
        for file in files:
            file.write_bytes(data if chance.random() < 0.5 else chance.choice([*files.values()]))
        power_on(FileStore(path, kind))

    _fuzz(chance, spoilt, list(files.values()), inputs_a_target, look)
