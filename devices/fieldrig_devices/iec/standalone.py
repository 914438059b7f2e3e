"""A host without a controller: a program alone, for `fieldrig iec run` and for tests.

It has no configuration objects and no native functions of a controller; %I and %Q are bytes that nothing drives.
"""

from collections.abc import Mapping, Sequence

from fieldrig.clock import MS, Clock
from fieldrig_devices.iec.host import Library, Pending
from fieldrig_devices.iec.layout import AREA_SIZE
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value


class StandaloneHost:
    """Implements `host.Host` on a clock."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.libraries: Sequence[Library] = ()
        self.object_types: Mapping[str, ObjectType] = {}
        self.objects: Mapping[str, ConfiguredObject] = {}
        self.inputs, self.outputs = bytearray(AREA_SIZE), bytearray(AREA_SIZE)

    def read(self, address: int) -> Value:
        raise KeyError(address)

    def write(self, address: int, value: Value) -> None:
        raise KeyError(address)

    def read_slowly(self, address: int) -> Pending:
        raise KeyError(address)

    def write_slowly(self, address: int, value: Value) -> Pending:
        raise KeyError(address)

    def on_output(self, byte: int) -> None:
        """Nothing is connected to the outputs."""

    def now_ms(self) -> int:
        return self._clock.now_ns() // MS
