"""What analog outputs, cams and regulators ask of the axes."""

from typing import Protocol


class AxisValues(Protocol):
    def position(self, axis: int) -> int:
        """Raw: the reference, or the reading of an axis that only reads its encoder (digest chapter 7)."""

    def speed(self, axis: int) -> int:
        """Raw, in units per second."""

    def volts(self, axis: int) -> float | None:
        """What the position loop gives to the driver; None if the axis doesn't own its output."""

    def diagnostic(self, axis: int, code: int) -> float:
        """Codes 1 to 9 of digest 6.1."""
