"""The range of each axis parameter, as in manual 3.2; a value out of range changes nothing."""

import pytest

from fieldrig_devices.arp.motion.setup import Setup
from fieldrig_devices.arp.parameters import Kind, Parameters

LARGEST = 999_999.999

# Row of the digest, parameter, smallest and largest value, a value that is refused.
PRINTED = [
    ("ARP-018", 1, 0.001, LARGEST, 0.0),
    ("ARP-020", 2, 1.0, 100_000.0, 0.999),
    ("ARP-020", 2, 1.0, 100_000.0, 100_000.001),
    ("ARP-021", 3, 0.0, 3.0, 4.0),
    ("ARP-022", 4, 0.0, 3.0, -1.0),
    ("ARP-023", 5, -LARGEST, LARGEST, 1_000_000.0),
    ("ARP-023", 6, -LARGEST, LARGEST, -1_000_000.0),
    ("ARP-024", 7, 0.001, LARGEST, 0.0),
    ("ARP-025", 8, 0.001, LARGEST, 0.0),
    ("ARP-027", 10, 0.0, LARGEST, -0.001),
    ("ARP-027", 11, 0.0, LARGEST, -0.001),
    ("ARP-027", 12, 0.0, LARGEST, -0.001),
    ("ARP-027", 13, 0.0, LARGEST, -0.001),
    ("ARP-028", 14, 0.0, LARGEST, -0.001),
    ("ARP-029", 15, 0.0, 60.0, 60.001),
    ("ARP-029", 16, 0.0, LARGEST, -0.001),
    ("ARP-030", 19, -LARGEST, LARGEST, 1_000_000.0),
    ("ARP-031", 20, 0.0, LARGEST, -0.001),
    ("ARP-032", 21, -10.0, 10.0, 10.001),
    ("ARP-033", 22, -LARGEST, LARGEST, -1_000_000.0),
    ("ARP-033", 23, 0.0, LARGEST, -0.001),
    ("ARP-034", 24, 0.001, LARGEST, 0.0),
    ("ARP-035", 25, 0.001, 100.0, 100.001),
]


@pytest.mark.parametrize(
    ("number", "low", "high", "wrong"), [pytest.param(*rest, marks=pytest.mark.manual(row)) for row, *rest in PRINTED]
)
@pytest.mark.parametrize("axis", [1, 2])
def test_range_of_a_parameter(axis: int, number: int, low: float, high: float, wrong: float) -> None:
    parameters = Parameters()
    for value in (low, high):
        assert parameters.set_ram(axis, number, round(value * 1000))
        assert parameters.ram[axis][number] == round(value * 1000)
    assert not parameters.set_ram(axis, number, round(wrong * 1000))
    assert parameters.ram[axis][number] == round(high * 1000)


@pytest.mark.manual("ARP-022")
def test_axes_are_read_only_by_default() -> None:
    parameters = Parameters()
    assert Setup.of(parameters.ram[1]).kind is Setup.of(parameters.ram[2]).kind is Kind.ENCODER


@pytest.mark.manual("ARP-035")
def test_entry_speed_is_a_share_of_the_maximum() -> None:
    parameters = Parameters()
    parameters.set_ram(1, 7, 2_000_000)
    parameters.set_ram(1, 25, 12_500)
    assert Setup.of(parameters.ram[1]).entry_speed == 250.0
