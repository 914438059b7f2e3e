"""Wires: named signals with units between devices and plants."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Signal:
    """The present value of one wire: digital as bool, analog as a number in `unit` (SI, "" for a digital one)."""

    name: str
    value: bool | int | float
    unit: str = ""
