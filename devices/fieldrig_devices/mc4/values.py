"""What a drive measures and shows, as the whole numbers of its operation data.

Units are those of `idns`.  Positions are counted on inside the drive, and go over the ring modulo 2^32.  What the axis
moves with every cycle is written as Python text, so that the values of one telegram are one call.
"""

from collections.abc import Callable, Sequence
from math import tau
from typing import Final, cast

from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.axis import INCREMENTS
from fieldrig_devices.mc4.machine import Machine

SPEED_UNIT: Final = tau / 60 * 1e-4
"""rad/s of one 0.0001 1/min."""
_HALF, _ALL = 0x8000_0000, 0xFFFF_FFFF
Number = Callable[[], int]
STANDING: Final = frozenset({11, 129, 182, 390, idns.MC4_STATE, idns.AXIS_STATE, idns.SIGNALS, idns.DIAG_CODE})
"""Those that only change when the machine is looked at, not with every cycle."""


MOVING: Final = {
    40: "n if -HALF <= (n := round(axis.v / SPEED_UNIT)) < HALF else max(-HALF, min(n, HALF - 1))",
    51: "(round(axis.set_increments - axis.e * INCREMENTS) + HALF & ALL) - HALF",
    53: "(round(axis.set_increments - (axis.e + axis.twist) * INCREMENTS) + HALF & ALL) - HALF",
    84: "n if -32768 <= (n := round(axis.t * 1000 / machine.true_motor.standstill_torque_nm)) <= 32767"
    " else max(-32768, min(n, 32767))",
    189: "max(-HALF, min(round(axis.e * INCREMENTS), HALF - 1))",
}
"""Of the axis, by IDN."""


def moving_numbers(machine: Machine, idns: Sequence[int]) -> Callable[[tuple[int, ...]], tuple[int, ...]]:
    """All values of these IDNs of `MOVING`, with those that are given behind them."""
    values = "".join(f"({MOVING[idn]}), " for idn in idns)
    text = f"def numbers(others):\n    axis = machine.axis\n    return ({values}*others)\n"
    space: dict[str, object] = {
        "machine": machine, "INCREMENTS": INCREMENTS, "SPEED_UNIT": SPEED_UNIT, "HALF": _HALF, "ALL": _ALL,
        "round": round, "max": max, "min": min, "__builtins__": {},
    }  # fmt: skip
    exec(text, space)
    return cast(Callable[[tuple[int, ...]], tuple[int, ...]], space["numbers"])


def position_at(machine: Machine, now_ns: int) -> int:
    """S-0-0051 between two cycles."""
    axis = machine.axis
    increments = axis.position + axis.v * (now_ns - machine.at_ns) / 1e9 * INCREMENTS
    return (round(increments) + _HALF & _ALL) - _HALF


def live_numbers(machine: Machine) -> dict[int, Number]:
    """By IDN."""
    settings = machine.settings

    def moving(idn: int) -> Number:
        numbers = moving_numbers(machine, [idn])
        return lambda: numbers(())[0]

    def signals() -> int:
        chain = machine.chain
        lifted = chain.is_brake_lifted << 1
        return machine.is_ready | lifted | machine.hardware_enable << 2 | chain.has_torque << 3

    return {idn: moving(idn) for idn in MOVING} | {
        11: lambda: machine.diagnosis.class_1,
        129: lambda: machine.diagnosis.manufacturer_class_1,
        182: lambda: machine.chain.axis_state << 8 | machine.chain.mc4_state,
        380: lambda: min(round(machine.dc.volt), 32_767),
        383: lambda: round(machine.thermal.motor_c * 10),
        384: lambda: round(machine.thermal.amplifier_c * 10),
        390: lambda: int(machine.diagnosis.code),
        110: lambda: round(settings.amplifier.continuous_current_a * 2500),
        112: lambda: round(settings.amplifier.continuous_current_a * 1000),
        idns.MC4_STATE: lambda: machine.chain.mc4_state,
        idns.AXIS_STATE: lambda: machine.chain.axis_state,
        idns.MOTOR_OVERLOAD: lambda: min(round(machine.thermal.motor_load * 1000), 65_535),
        idns.AMPLIFIER_OVERLOAD: lambda: min(round(machine.thermal.amplifier_load * 1000), 65_535),
        idns.OVERLOAD_POSITION: lambda: (machine.overload_position + _HALF & _ALL) - _HALF,
        idns.SIGNALS: signals,
        idns.DIAG_CODE: lambda: int(machine.diagnosis.code),
    }
