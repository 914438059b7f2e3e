"""Waveforms in the hands of the programs that they are written for: GTKWave's converters and sigrok.

`vcd2fst` reads a file as GTKWave does, and `fst2vcd` writes what was understood.  `sigrok-cli` reads it by the library
of PulseView, which takes digital wires only.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.signals.codec import encode
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Motion, Signal

pytestmark = pytest.mark.real

DIGITAL = [
    (0, Signal("cell.valve", True)),
    (7_000, Signal("cell.pump", False)),
    (5_003_000, Signal("cell.valve", False)),
    (1_000_000_000, Signal("cell.pump", True)),
    (1_000_001_000, Signal("cell.valve", True)),
    (1_000_002_000, Signal("cell.valve", False)),
]
NUMBERS = [
    (1, Signal("cell.count", -5)),
    (3_600_000_000_001, Signal("cell.count", 70_000)),
    (3_600_000_000_002, Signal("tank.level", 0.25, "m")),
    (3_600_000_000_003, Motion("shaft", -1.5, "rev", 3_600_000_000_003, 2.0)),
]


def output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout


def wave_file(path: Path, signals: list[tuple[int, Signal]]) -> Path:
    assert write([TraceEntry(at, "wires", "wires", "x", encode(signal)) for at, signal in signals], path) == len(
        signals
    )
    return path


def changes(text: str) -> dict[str, list[tuple[int, str]]]:
    """The values that a foreign program wrote, as instants and values by the last parts of the names."""
    names = dict(re.findall(r"\$var \w+ +\d+ (\S+) (\S+)", text))
    found: dict[str, list[tuple[int, str]]] = {name: [] for name in names.values()}
    time, words = 0, iter(text.partition("$enddefinitions $end")[2].split())
    for word in words:
        if word.startswith("#"):
            time = int(word[1:])
        elif word[0] in "br":
            found[names[next(words)]].append((time, word[1:]))
        elif word[0] in "01x":
            found[names[word[1:]]].append((time, word[0]))
    return {
        name: [change for change in values if change[1].strip("x") not in ("", "nan")] for name, values in found.items()
    }


@pytest.mark.skipif(shutil.which("vcd2fst") is None, reason="gtkwave is not installed")
def test_gtkwave_reads_every_wire_at_its_instants(tmp_path: Path) -> None:
    fst = tmp_path / "x.fst"
    output("vcd2fst", str(wave_file(tmp_path / "x.vcd", DIGITAL + NUMBERS)), str(fst))
    assert changes(output("fst2vcd", str(fst))) == {
        "valve": [(0, "1"), (5_003_000, "0"), (1_000_001_000, "1"), (1_000_002_000, "0")],
        "pump": [(7_000, "0"), (1_000_000_000, "1")],
        "count": [(1, f"{-5 & 0xFFFF_FFFF:032b}"), (3_600_000_000_001, f"{70_000:032b}")],
        "level": [(3_600_000_000_002, "0.25")],
        "shaft": [(3_600_000_000_003, "-1.5")],
    }


@pytest.mark.skipif(shutil.which("sigrok-cli") is None, reason="sigrok-cli is not installed")
def test_sigrok_reads_the_digital_wires(tmp_path: Path) -> None:
    """It takes a sample in each unit of time, here a microsecond, and shows a wire without a value as 0."""
    path = wave_file(tmp_path / "x.vcd", [*DIGITAL, (1_000_010_000, Signal("tank.level", 0.25, "m"))])
    assert changes(output("sigrok-cli", "-i", str(path), "-I", "vcd:downsample=1000", "-O", "vcd")) == {
        "valve": [(0, "1"), (5_003, "0"), (1_000_001, "1"), (1_000_002, "0")],
        "pump": [(0, "0"), (1_000_000, "1")],
    }


@pytest.mark.skipif(shutil.which("vcd2fst") is None, reason="gtkwave is not installed")
def test_gtkwave_reads_every_edge_of_pulses_and_pwm(tmp_path: Path) -> None:
    fst = tmp_path / "x.fst"
    train = PulseTrain("pto.pulse", 0, start_ns=7, frequency=50_000, count=3)
    signals: list[tuple[int, Signal]] = [(7, train), (7, Pwm("pwm", 25, start_ns=7, frequency=65_000))]
    output("vcd2fst", str(wave_file(tmp_path / "x.vcd", signals)), str(fst))
    found = changes(output("fst2vcd", str(fst)))
    assert found["pulse"] == [(7, "1"), (10_007, "0"), (20_007, "1"), (30_007, "0"), (40_007, "1"), (50_007, "0")]
    assert found["pwm"][:4] == [(7, "1"), (7 + 3_847, "0"), (7 + 15_385, "1"), (7 + 19_231, "0")]
