"""6072h of an axis on CAN, as the torque limit of its drive (S-0-0092), which holds in every mode.

It goes over the service channel and takes its time (digest PD-028); what is written meanwhile waits, and only the last
of it goes.  Until somebody has written 6072h the drive keeps what its parameters say.
"""

from typing import Final

from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.sercos.idn import ServiceError

TORQUE_LIMIT: Final = 92
MOST: Final = 10_000
"""0.1 %: what the drive takes."""


class TorqueLimit:
    def __init__(self) -> None:
        self._axis: Axis | None = None
        self._wanted: int | None = None
        self._told: int | None = None
        self._is_waiting = False

    def bind(self, axis: Axis | None) -> None:
        self._axis, self._told, self._is_waiting = axis, None, False

    def want(self, most: int) -> None:
        """0.1 % of the rated torque."""
        self._wanted = min(most, MOST)
        self.tell()

    def tell(self) -> None:
        """If the drive is there, and does not know it yet; one that was off begins with its own."""
        axis, wanted = self._axis, self._wanted
        if axis is None or not axis.is_operating:
            self._told, self._is_waiting = None, False
        elif not self._is_waiting and wanted is not None and wanted != self._told:
            self._told, self._is_waiting = wanted, True
            axis.write(TORQUE_LIMIT, wanted.to_bytes(2, "little"), lambda outcome: self._on_told(axis, wanted, outcome))

    def _on_told(self, axis: Axis, value: int, outcome: bytes | ServiceError) -> None:
        if axis is not self._axis:
            return
        self._is_waiting = False
        if not isinstance(outcome, ServiceError):
            axis.object["TorqueLimit"].put(value)
            self.tell()
