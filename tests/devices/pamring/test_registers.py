"""Table 2-2: the addresses of registers, row by row, and the roll-over."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pamring.registers import Parameter, Primary, Register, Variable, register_at, rolled

# first and last decimal address, kind, bits, periodic; 282 and 538 are misprints for #11B and #21B
TABLE = [
    (27, 255, Variable, 16, False),
    (283, 511, Variable, 16, True),
    (539, 767, Variable, 32, False),
    (795, 1023, Variable, 32, True),
    (1051, 1279, Parameter, 16, False),
    (1307, 1535, Parameter, 16, True),
    (1563, 1791, Parameter, 32, False),
    (1819, 2047, Parameter, 32, True),
]


@pytest.mark.manual("PAML-142")
def test_the_address_map() -> None:
    expected: dict[int, tuple[type, int, bool]] = dict.fromkeys(range(4), (Primary, 32, True))
    expected[4] = (Primary, 16, True)
    for first, last, kind, bits, is_periodic in TABLE:
        expected |= dict.fromkeys(range(first, last + 1), (kind, bits, is_periodic))
    for address in range(-10, 3000):
        found = register_at(address)
        assert (found and (found.kind, found.bits, found.is_periodic)) == expected.get(address), address


@pytest.mark.manual("PAML-149")
def test_the_manual_s_example_of_an_address() -> None:
    assert register_at(1273) == Register(16, False, Parameter.DAP_TEMP, Parameter)


@pytest.mark.manual("PAML-146")
@pytest.mark.parametrize(
    ("value", "bits", "shown"),
    [(0x7FFF, 16, 0x7FFF), (0x8000, 16, -0x8000), (0x1_0005, 16, 5), (-1, 16, -1), (1 << 31, 32, -(1 << 31))],
)
def test_a_register_rolls_over(value: int, bits: int, shown: int) -> None:
    assert rolled(value, bits) == shown


@given(st.integers(), st.sampled_from([16, 32]))
def test_a_rolled_value_has_the_same_bits(value: int, bits: int) -> None:
    assert (rolled(value, bits) - value) % (1 << bits) == 0
    assert -(1 << (bits - 1)) <= rolled(value, bits) < 1 << (bits - 1)
