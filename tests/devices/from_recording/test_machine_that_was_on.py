"""Recordings of a machine that was on before they begin: their rigs send the same at the same instants."""

import math
from collections.abc import Sequence
from pathlib import Path

import pytest
from made_rigs import rig_file, written_log

from fieldrig.config.rig_file import load
from fieldrig.traces.trace_files import read
from fieldrig_devices.replay import ReplayResult, replay

TODAY_S = 1_700_000_000


def lines(begin_s: float, period_s: float = 0.02, *, drop: Sequence[int] = (), skew: float = 0.0) -> list[str]:
    """A node that runs: heartbeats, a PDO in a period with a sine and a counter, and a value that a master reads."""
    rows = [(0.003 + turn / 10, "705#05") for turn in range(30)]
    for turn in range(round(3 / period_s)):
        wave = round(1000 + 500 * math.sin(turn * period_s)).to_bytes(2, "little")
        if turn not in drop:
            rows.append((0.001 + turn * period_s * (1 + skew), f"185#{wave.hex()}{turn // 5:02X}"))
    for turn in range(12):
        at_s, value = 0.5 + turn / 5, (2000 + 10 * turn).to_bytes(2, "little")
        rows += [(at_s, "605#4001200000000000"), (at_s + 0.0006, f"585#4B012000{value.hex()}0000")]
    return [f"{begin_s + at_s:.6f} {frame.upper()}" for at_s, frame in sorted(rows)]


def played_back(tmp_path: Path, rows: Sequence[str], *overrides: str) -> ReplayResult:
    log = written_log(tmp_path, *rows)
    return replay(log, load(rig_file(log), ("time=virtual", *overrides)))


@pytest.mark.parametrize("begin_s", [0, 30, TODAY_S])
def test_values_are_those_of_the_instant_whatever_the_clock_of_the_log(tmp_path: Path, begin_s: float) -> None:
    result = played_back(tmp_path, lines(begin_s))
    assert result.differences == []
    assert result.compared > 150


@pytest.mark.parametrize("period_s", [0.05, 0.13, 0.4])
def test_the_phase_of_a_timer_that_ran_before_is_no_difference(tmp_path: Path, period_s: float) -> None:
    assert played_back(tmp_path, lines(TODAY_S, period_s)).differences == []


def test_a_timer_that_is_a_little_slow_is_no_difference(tmp_path: Path) -> None:
    assert played_back(tmp_path, lines(TODAY_S, 0.1, skew=0.004)).differences == []


def test_another_period_is_a_difference(tmp_path: Path) -> None:
    slower = [f"devices.node5.objects.1800:{number}" for number in ("03=1500", "05=150")]
    words = str(played_back(tmp_path, lines(TODAY_S, 0.1), *slower))
    assert "every 150 ms, the log says 100 ms" in words


def test_a_message_that_only_one_side_has_is_a_difference(tmp_path: Path) -> None:
    rows = lines(TODAY_S, 0.1)
    path = rig_file(written_log(tmp_path, *rows))
    less = written_log(tmp_path, *lines(TODAY_S, 0.1, drop=[13]))
    [more] = replay(read(less), load(path, ("time=virtual",))).differences
    assert "node5 sent TPDO 1" in more.words
    assert more.words.endswith("which the log does not have")
    assert 1.2 < more.time_ns / 1e9 < 1.5
    lost = replay(read(written_log(tmp_path, *rows)), load(path, ("time=virtual", "devices.node5.faults=[]")))
    assert lost.differences == []
