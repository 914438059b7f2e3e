"""The slow side of a drive: DC circuit, temperatures and overload, which are evaluated every 64 ms.

Source: digest 1.8, 1.9.  Between two evaluations the axis adds up its heat and work.
"""

from copy import copy
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig_devices.drives.axis import Axis
from fieldrig_devices.mc4.power import DcCircuit
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.mc4.thermal import Thermal

SLOW_NS: Final = 64 * MS
"""Interval of the evaluation."""
SPREAD_NS: Final = 23 * MS
"""Offset of the evaluation from one ring address to the next: any 64 consecutive addresses use other cycles.

If all drives of a ring had their slow cycle at once, that cycle would take a multiple of the others.
"""


class Energy:
    """The DC circuit and the temperatures of one drive.  A simulated drive keeps its start values."""

    __slots__ = ("_address", "_clock", "_is_simulated", "_taken_ns", "dc", "due_ns", "thermal")

    def __init__(self, clock: Clock, settings: Mc4Settings, thermal: Thermal) -> None:
        self._clock, self._address, self._is_simulated = clock, settings.ring_address, settings.simulated
        self.dc = DcCircuit(settings.amplifier.mains_v)
        self.thermal = thermal
        """The temperatures and loads, for the motor that is connected."""
        self._taken_ns = clock.now_ns()
        self.due_ns = self._taken_ns + SLOW_NS
        """The instant of the next evaluation."""

    def begin(self) -> None:
        """Begin with the present instant."""
        self._taken_ns = self._clock.now_ns()

    def evaluate(self, axis: Axis) -> bool:
        """Take heat and work of the axis.  Return true if the DC circuit has become charged, or is no longer."""
        now_ns = self._clock.now_ns()
        seconds = (now_ns - self._taken_ns) / 1e9
        self._taken_ns = now_ns
        self.due_ns = now_ns + SLOW_NS - (now_ns - self._address * SPREAD_NS) % SLOW_NS
        heat, work = axis.take(seconds)
        if self._is_simulated:
            return False
        was_charged = self.dc.is_charged
        self.thermal.go(seconds, heat)
        self.dc.go(seconds, work)
        return was_charged is not self.dc.is_charged

    def dc_now(self, axis: Axis, at_ns: int) -> DcCircuit:
        """Return the DC circuit at the present instant, as a copy; the axis has been advanced to `at_ns`."""
        dc, (seconds, _, work) = copy(self.dc), self._since(axis, at_ns)
        if not self._is_simulated:
            dc.go(seconds, work)
        return dc

    def thermal_now(self, axis: Axis, at_ns: int) -> Thermal:
        """Return the temperatures and loads at the present instant, as a copy."""
        thermal, (seconds, heat, _) = copy(self.thermal), self._since(axis, at_ns)
        if not self._is_simulated:
            thermal.go(seconds, heat)
        return thermal

    def _since(self, axis: Axis, at_ns: int) -> tuple[float, float, float]:
        """Return the seconds since the last evaluation, and the result of `Axis.take` for them."""
        # `take` begins the sums of heat and work again, and a reading must not do that.
        heat, work = copy(axis).take((at_ns - self._taken_ns) / 1e9)
        return (self._clock.now_ns() - self._taken_ns) / 1e9, heat, work
