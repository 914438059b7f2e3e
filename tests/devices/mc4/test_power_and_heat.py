"""The DC circuit, temperatures and the overload model."""

import pytest

from fieldrig_devices.mc4.power import BALLAST_V, OVER_V, DcCircuit
from fieldrig_devices.mc4.thermal import Thermal

CONTINUOUS_NM, AMPLIFIER_NM = 8.0, 16.0


def charged() -> DcCircuit:
    dc = DcCircuit()
    dc.volt = dc.full_v
    return dc


def warmed(torque_nm: float, seconds: float) -> Thermal:
    thermal = Thermal(CONTINUOUS_NM, AMPLIFIER_NM, winding_limit_c=130.0, casing_s=1800.0)
    for _ in range(round(seconds / 0.064)):
        thermal.go(0.064, torque_nm**2)
    return thermal


@pytest.mark.manual("PD-391")
def test_circuit_charges_to_the_peak_of_the_mains() -> None:
    dc = DcCircuit()
    charged_after = [dc.is_charged]
    for _ in range(40):
        dc.go(0.064, 0.0)
        charged_after.append(dc.is_charged)
    assert 4 <= charged_after.index(True) <= 8
    assert dc.volt == pytest.approx(400.0 * 2**0.5, rel=1e-3)


@pytest.mark.manual("PD-012")
def test_safe_to_touch_five_minutes_after_mains_off_not_after_three() -> None:
    dc = charged()
    dc.is_mains_on = False
    dc.go(180.0, 0.0)
    assert dc.volt > 50
    dc.go(120.0, 0.0)
    assert dc.volt < 50


def test_braking_raises_the_voltage_by_its_energy() -> None:
    dc = charged()
    before = dc.volt
    dc.go(0.0, -50.0)
    assert dc.volt**2 - before**2 == pytest.approx(2 * 50.0 / 1e-3)


def test_ballast_burns_what_comes_above_its_level() -> None:
    dc = charged()
    for _ in range(100):
        dc.go(0.016, -50.0)
    assert dc.volt < OVER_V
    dc.go(1.0, 0.0)
    assert dc.volt == pytest.approx(BALLAST_V, rel=0.01)


def test_more_than_the_ballast_burns_is_overvoltage() -> None:
    dc = charged()
    for _ in range(100):
        dc.go(0.016, -800.0)
    assert dc.is_over


def test_mains_give_what_the_motor_takes() -> None:
    dc = charged()
    for _ in range(10):
        dc.go(0.064, 500.0)
    assert dc.volt == pytest.approx(dc.full_v, rel=1e-6)
    dc.is_mains_on = False
    dc.go(0.064, 100.0)
    assert dc.is_under


@pytest.mark.long
@pytest.mark.manual("PD-176")
def test_casing_is_40_kelvin_warmer_at_continuous_torque() -> None:
    assert warmed(CONTINUOUS_NM, 5 * 1800).casing_c == pytest.approx(25.0 + 40.0, abs=0.5)


@pytest.mark.long
@pytest.mark.manual("PD-176")
def test_thermo_contact_opens_in_the_winding() -> None:
    assert not warmed(CONTINUOUS_NM, 7200).is_motor_hot
    hot = warmed(1.3 * CONTINUOUS_NM, 7200)
    assert hot.is_motor_hot
    assert hot.motor_c > hot.casing_c


@pytest.mark.manual("PD-007")
def test_amplifier_holds_250_percent_for_a_second() -> None:
    torque = 2.5 * AMPLIFIER_NM
    assert warmed(torque, 0.95).amplifier_load < 1
    assert warmed(torque, 1.1).amplifier_load > 1


@pytest.mark.manual("PD-008")
def test_motor_holds_its_fourfold_torque_for_some_seconds() -> None:
    assert warmed(4 * CONTINUOUS_NM, 3.5).motor_load < 1
    assert warmed(4 * CONTINUOUS_NM, 4.5).motor_load > 1


def test_warnings_come_before_the_errors() -> None:
    thermal = warmed(2.5 * AMPLIFIER_NM, 0.95)
    assert thermal.warnings & 1
    assert thermal.overload < 1


def test_heat_sink_is_35_kelvin_warmer_at_the_amplifiers_continuous_current() -> None:
    """The amplifier is warmed by its own current, however small the motor is; 80 degrees are too hot."""
    assert warmed(AMPLIFIER_NM, 2_000).amplifier_c == pytest.approx(25 + 35, abs=0.1)
    assert warmed(CONTINUOUS_NM, 2_000).amplifier_c == pytest.approx(25 + 35 / 4, abs=0.1)
    assert not warmed(1.2 * AMPLIFIER_NM, 2_000).is_amplifier_hot
    assert warmed(1.3 * AMPLIFIER_NM, 2_000).is_amplifier_hot
