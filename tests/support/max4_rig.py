"""The part that benches with a controller have in common: reading it, operating it, and letting time pass."""

from typing import Self

from device_of import device_of

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.virtual.rig import Rig
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.controller import Max4


class Max4Rig:
    """A rig whose device `max4` is the controller; a bench sets `rig`."""

    rig: Rig

    @property
    def max4(self) -> Max4:
        return device_of(self.rig, "max4", Max4)

    def axis(self, name: str) -> Axis:
        return self.max4.firmware.axes[name]

    def run(self, ms: float) -> Self:
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def get(self, key: str) -> Value:
        return self.rig.get("max4", key)

    def set(self, key: str, value: Value) -> Self:
        self.rig.set("max4", key, value)
        return self

    def codes(self) -> list[int]:
        """Return the codes of the log, oldest first."""
        return [entry.code for _, entry in self.max4.firmware.logger.entries()][::-1]
