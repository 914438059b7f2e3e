"""`sm.encoder` in a rig in virtual time: on a serial bus, with a shaft on a wire, with faults, over a power cycle."""

from pathlib import Path
from random import Random
from typing import Any

import pytest
from full_store import FullStore
from hiperface_bench import PLATE, telegram
from pydantic import ValidationError

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.config.build import try_devices
from fieldrig.config.rig_file import from_dict
from fieldrig.device import Value
from fieldrig.errors import ConfigError
from fieldrig.storage.store import MemoryStore
from fieldrig.testing import RecordedLink
from fieldrig.virtual.rig import Rig
from fieldrig_bus.serial.message import Format, SerialMessage
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.hiperface.client import Failure, Motor, write_plate
from fieldrig_devices.hiperface.conversation import Conversation
from fieldrig_devices.hiperface.device import SmEncoder, SmEncoderSettings
from fieldrig_devices.hiperface.drive_end import EncoderEnd, built_in
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder, eeprom_with
from fieldrig_devices.hiperface.plate_file import save_plate
from fieldrig_devices.hiperface.shaft import TYPES, Turning

READ_POSITION = telegram("42")


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    file = tmp_path / "motor.yaml"
    save_plate(PLATE, file)
    return file


class Bench:
    """The device by itself."""

    def __init__(self, plate: Path, store: MemoryStore | None = None, **settings: Any) -> None:
        self.clock, self.store = VirtualClock(), store or MemoryStore()
        self.line, self.wires = RecordedLink[SerialMessage](), RecordedLink[Signal]()
        self.device = SmEncoder(
            self.clock,
            "x",
            SmEncoderSettings(name_plate=plate, **settings),
            self.store,
            Random(1),
            self.line,
            self.wires,
        )
        self.device.start()
        self.wait(200)

    def wait(self, milliseconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(milliseconds * MS))

    def ask(self, request: bytes) -> bytes:
        self.wait(10)
        self.line.take()
        self.line.deliver(request)
        self.wait(150)
        return b"".join(sent for sent in self.line.take() if isinstance(sent, bytes))

    def point(self, key: str) -> Value:
        return self.device.points()[key].read()

    def put(self, key: str, value: Value) -> None:
        write = self.device.points()[key].write
        assert write is not None
        write(value)


def rig(plate: Path, **settings: Any) -> Rig:
    buses = {"line": {"kind": "serial.virtual", "parity": "E"}, "wires": {"kind": "wires.virtual"}}
    encoder = {
        "kind": "sm.encoder",
        "name_plate": str(plate),
        "links": {"line": "line", "wires": "wires"},
        **settings,
    }
    return Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"encoder": encoder}}, plate.parent))


def read_by(rig: Rig, until_ns: int = 2 * S) -> tuple[int, Motor | Failure]:
    """When a drive at the line knows what."""
    drive = rig.attach("drive")
    found = list[tuple[int, Motor | Failure]]()
    end = EncoderEnd(drive.clock, drive.link("line"))
    end.start()
    end.read_motor(lambda result: found.append((drive.clock.now_ns(), result)))
    rig.run_until(until_ns)
    [result] = found
    return result


@pytest.mark.manual("PD-170")
def test_built_in_and_on_a_bus_are_the_same_to_the_nanosecond(plate: Path) -> None:
    on_a_bus = read_by(rig(plate, initial_turns=2.5))
    clock, inside = VirtualClock(), list[tuple[int, Motor | Failure]]()
    encoder = HiperfaceEncoder(TYPES["multi_turn"], eeprom_with(PLATE), lambda _now_ns: Turning(2.5))
    end = built_in(clock, encoder)
    end.start()
    end.read_motor(lambda result: inside.append((clock.now_ns(), result)))
    clock.advance_to(2 * S)
    assert inside == [on_a_bus]
    assert isinstance(on_a_bus[1], Motor)


def test_it_says_how_it_sends(plate: Path) -> None:
    bench = Bench(plate)
    assert Format(9600, 8, "E", 1) in bench.line.sent
    bench.ask(telegram("57 e3 55"))
    bench.line.deliver(telegram("53"))
    assert bench.line.take() == [Format(4800, 8, "E", 1)]


@pytest.mark.manual("PD-173", "PD-174")
@pytest.mark.parametrize(
    ("value", "unit"), [(2_750_000, "count"), (2.75, "turn"), (17.278759594743864, "rad")], ids=["count", "turn", "rad"]
)
def test_shaft_is_seen_in_any_unit(plate: Path, value: float, unit: str) -> None:
    bench = Bench(plate)
    bench.wires.deliver(Signal("x.shaft", value, unit))
    assert bench.ask(READ_POSITION) == telegram("42 00 01 60 00")
    assert bench.point("increments") == 2_750_000


def test_shaft_that_moves_on_is_seen_where_it_is(plate: Path) -> None:
    bench = Bench(plate)
    bench.wires.deliver(Motion("x.shaft", 1.0, "turn", bench.clock.now_ns(), 0.5))
    bench.wait(1000)
    assert bench.point("turns") == 1.5
    bench.wires.deliver(Signal("x.shaft", 3.0, "V"))  # no shaft
    assert bench.point("turns") == 1.5


@pytest.mark.long
@pytest.mark.manual("PD-175")
def test_zero_pulse_comes_once_a_turn(plate: Path) -> None:
    bench = Bench(plate)
    pulses = 0
    before = False
    for step in range(3 * 8192):
        bench.put("turns", (step + 0.5) / 8192)
        now = bool(bench.point("zero"))
        pulses += now and not before
        before = now
    assert pulses == 3
    bench.put("turns", 0.25 / 1024)
    assert bench.point("sine") == pytest.approx(1)
    assert bench.point("cosine") == pytest.approx(0)


def test_temperature_comes_by_its_wire(plate: Path) -> None:
    bench = Bench(plate)
    bench.wires.deliver(Signal("x.temperature", 61.6, "degC"))
    assert bench.ask(telegram("44 48")) == telegram("44 48 00 3e")
    bench.put("temperature", 20)
    assert bench.point("temperature") == 20


@pytest.mark.parametrize(("key", "value"), [("turns", -1), ("turns", "far"), ("temperature", True)])
def test_points_refuse_what_can_not_be(plate: Path, key: str, value: Value) -> None:
    with pytest.raises(ValueError, match="from"):
        Bench(plate).put(key, value)


@pytest.mark.manual("PD-171")
def test_memory_is_kept_over_a_power_cycle(plate: Path) -> None:
    bench = Bench(plate)
    bench.ask(telegram("43 00 00 01 00 55"))
    bench.ask(telegram("4b 00 70 02 55 ab cd"))
    bench.ask(telegram("55 42 55"))
    again = Bench(plate, bench.store)
    assert again.ask(telegram("4a 00 70 02 55", 0x42)) == telegram("4a 00 70 02 ab cd", 0x42)
    assert again.ask(telegram("42", 0x42)) == telegram("42 00 00 01 00", 0x42)


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("43 00 00 01 00 55", "43"), ("47", "47"), ("49 55", "49"), ("4b 00 70 02 55 ab cd", "4b 00 70 02"),
        ("4d 01 c1 55", "4d 01 c1"), ("4f 00 55 11", "4f 00"), ("55 42 55", "55 42"), ("57 e5 55", "57 e5"),
    ],
)  # fmt: skip
def test_what_the_memory_does_not_take_is_refused_and_changes_nothing(plate: Path, request_: str, answer: str) -> None:
    store = FullStore()
    bench = Bench(plate, store)
    before = bench.device.encoder.eeprom.encode()
    for _ in range(2):
        assert bench.ask(telegram(request_)) == telegram("50 05")
    assert bench.device.encoder.eeprom.encode() == before
    store.is_full = False
    assert bench.ask(telegram(request_))[1:-1] == bytes.fromhex(answer)


def test_another_plate_file_is_another_motor(plate: Path) -> None:
    bench = Bench(plate)
    bench.ask(telegram("4b 00 70 02 55 ab cd"))
    save_plate(PLATE.model_copy(update={"serial_number": "17-0002"}), plate)
    again = Bench(plate, bench.store)
    assert again.ask(telegram("4a 00 70 02 55")) == telegram("4a 00 70 02 ff ff")
    assert again.point("plate") == "SM-100/30/080, 17-0002"


def test_damaged_memory_is_empty_and_says_so(plate: Path) -> None:
    bench = Bench(plate)
    bench.ask(telegram("47"))
    kept = bench.store.load()
    assert kept is not None
    again = Bench(plate, MemoryStore(kept[:-1]))
    assert again.ask(telegram("42")) == telegram("c2 00 00 00 00")
    assert again.ask(telegram("50")) == telegram("50 03")
    assert again.ask(telegram("4c 00")) == telegram("50 12")
    assert again.point("plate") == "there is no plate in this memory"


@pytest.mark.manual("PD-171")
@pytest.mark.parametrize(
    ("fault", "failure"),
    [
        ({"what": "silent"}, Failure.NO_ANSWER),
        ({"what": "memory"}, Failure.UNREADABLE),
        ({"what": "checksum"}, Failure.CHECKSUM),
        ({"what": "checksum", "of": "telegrams"}, Failure.UNREADABLE),
        ({"what": "memory", "start_ms": "3000"}, None),
        ({"what": "silent", "count": "3"}, None),
        ({"what": "silent", "duration_ms": "100"}, None),
        ({"what": "wrong_plate"}, None),
    ],
)
def test_drive_finds_what_is_broken(plate: Path, fault: dict[str, Any], failure: Failure | None) -> None:
    broken = rig(plate)
    number = broken.add_fault("encoder", fault)
    _, found = read_by(broken)
    assert isinstance(found, Motor) if failure is None else found is failure
    assert broken.faults("encoder")[number]["what"] == fault["what"]
    broken.clear_fault("encoder", number)
    assert broken.faults("encoder") == {}


def test_wrong_plate_is_a_right_plate_of_another_motor(plate: Path) -> None:
    bench = rig(plate)
    bench.add_fault("encoder", {"what": "wrong_plate", "type": "SM-200", "factor": "0.5"})
    _, found = read_by(bench)
    assert isinstance(found, Motor)
    assert (found.plate.type, found.plate.serial_number) == ("SM-200", "SWAPPED")
    assert (found.plate.peak_torque_nm, found.plate.torque_constant_nm_per_a) == (16.0, 1.6)
    assert bench.get("encoder", "plate") == "SM-200, SWAPPED"
    applied = bench.faults("encoder")[1]["applied"]
    bench.get("encoder", "plate")
    assert bench.faults("encoder")[1]["applied"] == applied == 4  # reads of the field


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "deaf"}, "there is no fault 'deaf'"),
        ({"what": "silent", "count": 0}, "count"),
        ({"what": "wrong_plate", "factor": 100.0}, "factor"),
        ({"what": "wrong_plate", "factor": 0.0001}, "the fault needs an invalid plate"),
        ({"what": "wrong_plate", "type": "Motör"}, "the fault needs an invalid plate: type"),
        ({"what": "checksum", "of": "all"}, "of"),
    ],
)
def test_faults_that_can_not_be_are_refused(plate: Path, fault: dict[str, Any], wrong: str) -> None:
    device = Bench(plate).device
    with pytest.raises(ValueError, match=wrong):
        device.add_fault(fault)
    with pytest.raises(ValueError, match="no fault 1"):
        device.clear_fault(1)


def test_plate_written_by_the_line_is_there_after_a_power_cycle(plate: Path) -> None:
    bench = rig(plate)
    drive = bench.attach("service")
    done = list[Conversation[None]]()
    other = PLATE.model_copy(update={"serial_number": "17-0009"})
    EncoderEnd(drive.clock, drive.link("line")).ask(write_plate(other), done.append)
    bench.run_until(3 * S)
    done[0].result()
    assert bench.get("encoder", "plate") == "SM-100/30/080, 17-0009"


@pytest.mark.parametrize(
    ("settings", "wrong"),
    [
        ({"address": 0x60}, "address"),
        ({"address": 0x3F}, "address"),
        ({"type": "resolver"}, "type"),
        ({"initial_turns": -0.5}, "initial_turns"),
        ({"serial_number": "1234567890"}, "serial_number"),
    ],
)
def test_wrong_settings_are_refused(plate: Path, settings: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ValidationError, match=wrong):
        SmEncoderSettings(name_plate=plate, **settings)


def test_mistakes_in_a_plate_file_are_found_by_check(plate: Path) -> None:
    plate.write_text(plate.read_text(encoding="utf-8").replace("pole_pairs: 4", "pole_pairs: 0"), encoding="utf-8")
    buses = {"line": {"kind": "serial.virtual"}}
    encoder = {"kind": "sm.encoder", "name_plate": plate.name, "links": {"line": "line"}}
    config = from_dict({"time": "virtual", "buses": buses, "devices": {"encoder": encoder}}, plate.parent)
    assert "pole_pairs" in "".join(map(str, try_devices(config.devices.values())))
    with pytest.raises(ConfigError, match="no such file"):
        from_dict(
            {"time": "virtual", "buses": buses, "devices": {"encoder": encoder | {"name_plate": "no.yaml"}}},
            plate.parent,
        )
