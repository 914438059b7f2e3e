"""The measured values of a drive as the integers of its operation data.

Units are those of `idns`.  Positions are unlimited inside the drive, and modulo 2^32 on the ring.  Values that change
in every cycle are written as Python text, so that one call computes all values of a telegram.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import tau
from typing import Final, cast

from fieldrig_devices.drives.fold import Numbers, compiled
from fieldrig_devices.drives.loops import INCREMENTS, MovingAxis
from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.sercos import standard_idns as std

SPEED_UNIT: Final = tau / 60 * 1e-4
"""Speed of 0.0001 1/min, in rad/s."""
GUARD: Final = 1e-6
"""Added to a number before it is rounded to a whole one.  Half a unit is a common value of a drive that follows or
holds steadily, and the last bits of the model, in which the fold and the steps may differ, must not decide."""
_HALF, _ALL = 0x8000_0000, 0xFFFF_FFFF
Number = Callable[[], int]
STANDING: Final = frozenset(
    {
        std.CLASS_1_DIAGNOSTIC,
        std.MANUFACTURER_CLASS_1,
        std.MANUFACTURER_CLASS_3,
        std.DIAGNOSTIC_NUMBER,
        idns.MC4_STATE,
        idns.AXIS_STATE,
        idns.SIGNALS,
        idns.DIAG_CODE,
    }
)
"""IDNs whose values change only with `Machine.look`, not in every cycle."""


def _clamped(value: str, half: int) -> str:
    return f"n if {-half} <= (n := round({value} + {GUARD!r})) < {half} else max({-half}, min(n, {half - 1}))"


def _wrapped(value: str) -> str:
    return f"(round({value} + {GUARD!r}) + {_HALF} & {_ALL}) - {_HALF}"


MOVING: Final = {
    std.VELOCITY_FEEDBACK: _clamped(f"{{v}} / {SPEED_UNIT!r}", _HALF),
    std.POSITION_FEEDBACK_1: _wrapped(f"{{target}} - {{e}} * {INCREMENTS!r}"),
    std.POSITION_FEEDBACK_2: _wrapped(f"{{target}} - ({{e}} + {{twist}}) * {INCREMENTS!r}"),
    std.TORQUE_FEEDBACK: _clamped("{t} * 1000 / {standstill_nm}", 0x8000),
    std.FOLLOWING_DISTANCE: _clamped(f"{{e}} * {INCREMENTS!r}", _HALF),
}
"""Python expressions for the values of the axis, by IDN; `target` is the set position in increments."""


def _tenths(degc: float) -> int:
    return min(round(degc * 10), 0x7FFF)


def moving_numbers(machine: Machine, numbers: Sequence[int]) -> Callable[[], tuple[int, ...]]:
    """Return a function that gives the present values of these IDNs of `MOVING`."""
    values_of = _values_of(tuple(numbers))
    return lambda: values_of(machine.axis, machine.true_motor.standstill_torque_nm)


@lru_cache(maxsize=256)
def _values_of(numbers: tuple[int, ...]) -> Callable[[MovingAxis, float], tuple[int, ...]]:
    names = {
        "target": "axis.set_increments", "e": "axis.e", "v": "axis.v", "t": "axis.t", "twist": "axis.twist",
        "standstill_nm": "standstill_nm",
    }  # fmt: skip
    values = "".join(f"({MOVING[idn].format_map(names)}), " for idn in numbers)
    text = f"def numbers(axis, standstill_nm):\n    return ({values})\n"
    return cast(Callable[[MovingAxis, float], tuple[int, ...]], compiled(text, "numbers"))


def following_numbers(machine: Machine, numbers: Sequence[int], codes: str) -> Numbers:
    """Return the values of these IDNs as the folded cycle computes and packs them."""
    names = {
        "target": "target", "e": "new_e", "v": "new_v", "t": "new_t", "twist": "axis.twist",
        "standstill_nm": repr(machine.true_motor.standstill_torque_nm),
    }  # fmt: skip
    return Numbers(tuple(MOVING[idn].format_map(names) for idn in numbers), codes)


def position_at(machine: Machine, now_ns: int) -> int:
    """Return S-0-0051 at any instant between two cycles."""
    axis = machine.axis
    increments = axis.position + axis.v * (now_ns - machine.at_ns) / 1e9 * INCREMENTS
    return (round(increments + GUARD) + _HALF & _ALL) - _HALF


def live_numbers(machine: Machine) -> dict[int, Number]:
    """Return functions that give the present values, by IDN."""
    settings = machine.settings

    def moving(idn: int) -> Number:
        numbers = moving_numbers(machine, [idn])
        return lambda: numbers()[0]

    def signals() -> int:
        chain = machine.chain
        lifted = chain.is_brake_lifted << 1
        return machine.is_ready | lifted | machine.hardware_enable << 2 | chain.has_torque << 3

    return {idn: moving(idn) for idn in MOVING} | {
        std.CLASS_1_DIAGNOSTIC: lambda: machine.diagnosis.class_1,
        std.MANUFACTURER_CLASS_1: lambda: machine.diagnosis.manufacturer_class_1,
        std.MANUFACTURER_CLASS_3: lambda: machine.chain.axis_state << 8 | machine.chain.mc4_state,
        std.DC_BUS_VOLTAGE: lambda: min(round(machine.present_dc.volt), 32_767),
        std.MOTOR_TEMPERATURE: lambda: _tenths(machine.present_thermal.motor_c),
        std.AMPLIFIER_TEMPERATURE: lambda: _tenths(machine.present_thermal.amplifier_c),
        std.DIAGNOSTIC_NUMBER: lambda: machine.diagnosis.number,
        std.AMPLIFIER_PEAK_CURRENT: lambda: round(settings.amplifier.continuous_current_a * 2500),
        std.AMPLIFIER_RATED_CURRENT: lambda: round(settings.amplifier.continuous_current_a * 1000),
        idns.MC4_STATE: lambda: machine.chain.mc4_state,
        idns.AXIS_STATE: lambda: machine.chain.axis_state,
        idns.MOTOR_OVERLOAD: lambda: min(round(machine.present_thermal.motor_load * 1000), 65_535),
        idns.AMPLIFIER_OVERLOAD: lambda: min(round(machine.present_thermal.amplifier_load * 1000), 65_535),
        idns.OVERLOAD_POSITION: lambda: (machine.task.overload_position + _HALF & _ALL) - _HALF,
        idns.SIGNALS: signals,
        idns.DIAG_CODE: lambda: int(machine.diagnosis.code),
    }
