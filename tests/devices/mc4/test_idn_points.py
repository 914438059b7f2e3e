"""The operation data of a drive as points: the same numbers as a master reads over the service channel."""

from types import SimpleNamespace
from typing import Any

import pytest
from mc4_bench import DriveBench

from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig_devices.mc4.values import moving_numbers


@pytest.fixture(scope="module")
def bench() -> DriveBench:
    return DriveBench({}).up()


def test_a_parameter_is_what_the_master_reads_with_its_decimals_and_unit(bench: DriveBench) -> None:
    facts = bench.rig.facts("d1")["S-0-0104"]
    assert bench.rig.get("d1/S-0-0104") == bench.number(104) / 100 == 3.6
    assert facts == {
        "unit": "(m/min)/mm", "about": "position loop Kv-factor", "writable": True, "type": "unsigned, 2 bytes",
        "low": 0.01, "high": 60.0,
    }  # fmt: skip


def test_a_written_parameter_reaches_the_master(bench: DriveBench) -> None:
    bench.rig.set("d1/S-0-0104", 2.4)
    assert bench.number(104) == 240
    bench.write(104, (360).to_bytes(2, "little"))
    assert bench.rig.get("d1/S-0-0104") == 3.6


def test_texts_and_lists_are_texts(bench: DriveBench) -> None:
    assert bench.rig.get("d1/S-0-0141") == bench.text(141)
    assert "S-0-0047" in str(bench.rig.get("d1/S-0-0188")).split()


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("S-0-0104", 61, "expected a number from 0.01 to 60 (m/min)/mm, got 61"),
        ("S-0-0104", "fast", "expected a number from 0.01 to 60 (m/min)/mm, got 'fast'"),
        ("S-0-0051", 5, "can only be read"),
        ("S-0-0099", 3, "can only be read"),  # a command
        ("S-0-0047", 5, "the drive refuses it with 700Ah, cyclic"),
        ("S-0-0032", 3, "the drive refuses it with 7005h, protected now"),
    ],
)
def test_a_value_is_refused_as_over_the_service_channel(bench: DriveBench, key: str, value: Value, why: str) -> None:
    before = bench.rig.get(f"d1/{key}")
    with pytest.raises(ControlError) as refused:
        bench.rig.set(f"d1/{key}", value)
    assert why in str(refused.value)
    assert bench.rig.get(f"d1/{key}") == before


@pytest.mark.parametrize(
    ("torque_nm", "shown"), [(1.26, 126), (32.767, 3_277), (400.0, 0x7FFF), (-400.0, -0x8000), (327.676, 0x7FFF)]
)
def test_a_torque_beyond_its_two_bytes_is_shown_as_their_end(torque_nm: float, shown: int) -> None:
    """S-0-0084 is in thousandths of the standstill torque, which is 10 Nm here."""
    machine: Any = SimpleNamespace(
        axis=SimpleNamespace(t=torque_nm), true_motor=SimpleNamespace(standstill_torque_nm=10.0)
    )
    assert moving_numbers(machine, [84])() == (shown,)
