"""Load cells, outputs, cam switches and a regulator on a whole card, with its wires."""

from pathlib import Path

import pytest

from fieldrig.clock import MS, VirtualClock
from fieldrig.loop.background import VirtualBackground
from fieldrig.storage.store import MemoryStore
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.arp.card.card import ArpCard
from fieldrig_devices.arp.card.settings import ArpSettings

Group = dict[int, int | float]


class Bench:
    """Card `c` with a control loop of 1 ms, Enable high."""

    def __init__(self, folder: Path, source: str, general: Group | None = None, axis1: Group | None = None) -> None:
        program = folder / "test.I01"
        program.write_text(source)
        parameters = {"general": {1: 1, 16: 10, **(general or {})}, "axis1": axis1 or {}}
        settings = ArpSettings.model_validate({"program": program, "parameters": parameters, "inputs": {"I108": True}})
        self.clock, self.wires = VirtualClock(), RecordedLink[Signal]()
        self.card = ArpCard(self.clock, "c", settings, MemoryStore(), VirtualBackground(self.clock), self.wires)
        self.card.start()

    def run(self, ms: int) -> "Bench":
        self.clock.advance_to(self.clock.now_ns() + ms * MS)
        return self

    def feel(self, terminal: str, volt: float) -> None:
        self.wires.deliver(Signal(f"c.{terminal}", volt, "V"))

    def values_sent(self, name: str) -> list[float]:
        """Every value of a wire, oldest first."""
        return [signal.value for signal in self.wires.sent if signal.name == f"c.{name}"]


@pytest.mark.long
@pytest.mark.manual("ARP-092")
def test_a10_a_slope_on_the_wire(tmp_path: Path) -> None:
    bench = Bench(tmp_path, "BEG M\nDAC 1, -5\nWAIT 0.1\nDAC 1, 5, 2\nLOOP:\nGOTO LOOP\nEND").run(3_000)
    volts = bench.values_sent("dac1")
    assert (volts[:2], volts[-1], len(volts)) == ([0.0, -5.0], 5.0, 2 + 2_000)


@pytest.mark.manual("ARP-112")
def test_a_cam_from_the_wrap_of_a_cyclic_encoder_comes_on_in_every_turn(tmp_path: Path) -> None:
    source = "BEG M\nCAM1 1, 0, 250, O101\nCAM2 1, 1000, 750, O102\nLOOP:\nGOTO LOOP\nEND"
    bench = Bench(tmp_path, source, axis1={4: 0, 5: 1000, 6: 0}).run(100)
    for speed, output, other in ((7_000, "O101", "O102"), (-7_000, "O102", "O101")):  # 7 units per loop
        bench.wires.sent.clear()
        bench.wires.deliver(Motion("c.encoder1", 0, "count", bench.clock.now_ns(), speed))
        bench.run(1_000)  # 7 turns
        assert bench.values_sent(output) == [True, False] * 7
        assert bench.values_sent(other) == []
        bench.wires.deliver(Motion("c.encoder1", 0, "count", bench.clock.now_ns(), 0))
        bench.run(10)


@pytest.mark.manual("ARP-113")
@pytest.mark.manual("ARP-041")
def test_a_regulator_drives_the_wire_until_enable_goes_low(tmp_path: Path) -> None:
    source = """\
BEG M
V50 == 40
V51 == 10
V52 == 100000
V54 == 0.01
V57 == 1
V58 == 1000
V59 == 1000
V60 == -1000
V61 == 1
V62 == 1
V63 == 10
V64 == -10
V65 == 0.5
@PAR2[4] == 3
@PAR2[11] == 0.2
PID 1, 2, V50
SET F303
LOOP:
GOTO LOOP
END"""
    bench = Bench(tmp_path, source, general={2: 1, 4: 1000}).run(100)
    assert bench.values_sent("dac2")[-1] == 8.0
    bench.feel("adc1", 0.0015)  # 1500 uV: a tension of 15
    bench.run(200)
    assert bench.values_sent("dac2")[-1] == pytest.approx(5.0)
    bench.wires.deliver(Signal("c.I108", False))
    bench.run(20)
    assert bench.values_sent("dac2")[-1] == 0.0
    assert bench.card.parts.F[305:307] == [0, 0]
    bench.wires.deliver(Signal("c.I108", True))
    bench.run(100)
    assert bench.values_sent("dac2")[-1] == pytest.approx(5.0)
