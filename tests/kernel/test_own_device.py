"""configs/own-device.yaml, the example of a user's own device, and the manual in configs/press.py."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.pytest_plugin import RigMaker
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal

FILE = Path(__file__).parents[2] / "configs" / "own-device.yaml"
VIRTUAL = ("time=virtual", "buses.can0={kind: can.virtual}", "buses.wires={kind: wires.virtual}")
CLOSE, OPEN, NONSENSE = bytes.fromhex("01"), bytes.fromhex("00"), bytes.fromhex("01 00")


class Bench:
    """The press with a host on its CAN bus and a lamp on its wires."""

    def __init__(self, make: RigMaker) -> None:
        self.rig = make(FILE, *VIRTUAL)
        host = self.rig.attach("host")
        self.can, self.wires = host.link("can0"), host.link("wires")
        self.reports: list[CanFrame] = []
        self.signals: list[Signal] = []
        self.can.on_receive(self.reports.append)
        self.wires.on_receive(self.signals.append)

    def command(self, data: bytes) -> None:
        self.can.send(CanFrame(0x201, data))


@pytest.fixture
def bench(fieldrig_rig: RigMaker) -> Bench:
    return Bench(fieldrig_rig)


def test_the_press_reports_every_100_ms(bench: Bench) -> None:
    bench.rig.run_until(450 * MS)
    assert bench.reports == [CanFrame(0x181, bytes.fromhex("00 00 00"))] * 5


def test_the_press_closes_in_the_time_its_speed_gives(bench: Bench) -> None:
    bench.command(CLOSE)
    bench.rig.run_until(1950 * MS)
    assert bench.reports[-1].data[0] == 1
    assert not any(signal.value for signal in bench.signals)
    bench.rig.run_until(2150 * MS)
    assert bench.reports[-1].data == bytes.fromhex("02 b0 04")  # closed, 120.0 mm
    assert bench.signals[-1] == Signal("press.closed", True)


def test_the_press_turns_round_where_it_is(bench: Bench) -> None:
    bench.command(CLOSE)
    bench.rig.run_until(1 * S)
    bench.command(OPEN)
    bench.rig.run_until(1500 * MS)
    assert bench.rig.get("press", "position") == pytest.approx(30, abs=0.1)
    bench.rig.run_until(2100 * MS)
    assert bench.rig.get("press", "state") == "OPEN"


def test_the_press_ignores_nonsense(bench: Bench) -> None:
    bench.command(NONSENSE)
    bench.rig.run_until(1 * S)
    assert bench.rig.get("press", "position") == 0


def test_the_file_is_right_as_it_stands() -> None:
    config: RigConfig = load(FILE)
    assert (config.time, config.devices["press"].kind) == ("real", "press:Press")
