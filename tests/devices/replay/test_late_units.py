"""A Modbus unit whose answer times vary: what it shows by itself is compared at the instants of the log.

The unit of the log shows the tenths of a second since the log began, and takes 10 ms to answer, or 60 ms now and then.
"""

from pathlib import Path

import pytest

from fieldrig import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode as modbus
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.replay import replay
from fieldrig_devices.replay.replay_result import What

RIG = """\
name: late
time: virtual
buses: {mb: {kind: modbus.tcp, listen: "127.0.0.1:5020"}}
devices:
  unit: {kind: modbus.device, table: table.yaml, unit_id: 1, turnaround_ms: TURNAROUND, links: {modbus: mb}}
"""
TABLE = """\
input_registers:
  - {address: 0, name: tenths, source: {kind: ramp, first: 0, last: 60000, period_ms: 6000000}}
"""
REQUEST = bytes.fromhex("04 0000 0001")
PERIOD_NS, COUNT = 200 * MS, 100


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    (tmp_path / "table.yaml").write_text(TABLE, encoding="utf-8")
    return tmp_path / "rig.yaml"


def recorded(clients: int = 1, wrong_at: int = -1) -> list[TraceEntry]:
    log = []
    for number in range(COUNT):
        for client in range(clients):
            at_ns = PERIOD_NS * (number + 1) + client * 5 * MS
            answered_ns = at_ns + (60 if number % 10 == 5 else 10) * MS
            tenths = (at_ns - PERIOD_NS) // (100 * MS) + (3 if number == wrong_at else 0)
            exchange, sender = number * clients + client, f"10.0.0.{client}:1"
            log.append(TraceEntry(at_ns, "mb", "modbus", sender, modbus(ModbusRequest(1, REQUEST, exchange))))
            answer = modbus(ModbusResponse(1, b"\x04\x02" + tenths.to_bytes(2, "big"), exchange))
            log.append(TraceEntry(answered_ns, "mb", "modbus", "10.0.0.9:502", answer))
    return sorted(log, key=lambda entry: entry.time_ns)


@pytest.mark.parametrize("clients", [1, 2])
def test_a_unit_that_answers_late_does_not_shift_what_it_shows_by_itself(rig: Path, clients: int) -> None:
    rig.write_text(RIG.replace("TURNAROUND", "45"), encoding="utf-8")
    result = replay(recorded(clients), str(rig), time_tolerance_ns=70 * MS, value_tolerances={"tenths": 1}, settle_ns=0)
    assert (result.compared, [each.words for each in result.differences]) == (COUNT * clients, [])


def test_how_late_an_answer_is_counts_from_its_own_request(rig: Path) -> None:
    rig.write_text(RIG.replace("TURNAROUND", "45"), encoding="utf-8")
    result = replay(recorded(2), str(rig), time_tolerance_ns=20 * MS, value_tolerances={"tenths": 1}, settle_ns=0)
    late = [each.late_ns for each in result.differences if each.what is What.LATE]
    assert len(late) == 2 * COUNT * 9 // 10
    assert {round(each / MS) for each in late} <= {34, 35, 36, 40}


def test_a_value_that_is_another_one_is_still_a_difference(rig: Path) -> None:
    rig.write_text(RIG.replace("TURNAROUND", "45"), encoding="utf-8")
    result = replay(
        recorded(wrong_at=50), str(rig), time_tolerance_ns=70 * MS, value_tolerances={"tenths": 1}, settle_ns=0
    )
    [only] = result.differences
    assert "tenths" in only.words
