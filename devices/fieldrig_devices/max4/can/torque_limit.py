"""The maximum torque (6072h) of an axis on CAN as the torque limit of its drive (S-0-0092), which applies in all modes.

The service channel is slow (digest PD-028); values that are written meanwhile wait, and only the last one is sent.
Until a master writes 6072h, the drive keeps the limit of its own parameters.
"""

from typing import Final

from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.idn import ServiceError

MOST: Final = 10_000
"""Largest value of the drive, in 0.1 % of the rated torque."""


class TorqueLimit:
    """The torque limit of one axis."""

    def __init__(self) -> None:
        self._axis: Axis | None = None
        self._wanted: int | None = None
        self._sent: int | None = None
        self._is_waiting = False

    def bind(self, axis: Axis | None) -> None:
        """Connect to an axis after a boot."""
        self._axis, self._sent, self._is_waiting = axis, None, False

    def want(self, most: int) -> None:
        """Request a limit in 0.1 % of the rated torque."""
        self._wanted = min(most, MOST)
        self.send()

    def send(self) -> None:
        """Send the limit if the drive is present and does not have it; after power-on a drive has its own limit."""
        axis, wanted = self._axis, self._wanted
        if axis is None or not axis.is_operating:
            self._sent, self._is_waiting = None, False
        elif not self._is_waiting and wanted is not None and wanted != self._sent:
            self._sent, self._is_waiting = wanted, True
            axis.write(
                std.TORQUE_LIMIT, wanted.to_bytes(2, "little"), lambda outcome: self._on_sent(axis, wanted, outcome)
            )

    def _on_sent(self, axis: Axis, value: int, outcome: bytes | ServiceError) -> None:
        if axis is not self._axis:
            return
        self._is_waiting = False
        if not isinstance(outcome, ServiceError):
            axis.object["TorqueLimit"].put(value)
            self.send()
