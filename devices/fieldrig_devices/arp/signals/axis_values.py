"""The values of the axes that analog outputs, cam switches and regulators use."""

from typing import Protocol


class AxisValues(Protocol):
    def position(self, axis: int) -> int:
        """Position, raw: the reference, or the reading of an axis that only reads its encoder (digest chapter 7)."""

    def speed(self, axis: int) -> int:
        """Speed, raw, in units per second."""

    def volts(self, axis: int) -> float | None:
        """Voltage from the position loop to the drive, or None if the axis does not own its output."""

    def diagnostic(self, axis: int, code: int) -> float:
        """Value for one of the codes 1 to 9 of digest 6.1."""
