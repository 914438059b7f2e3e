"""The controller as its programs see it: configuration objects with their parameters, areas, libraries, time.

Source: PacDrive manual 3048-3074, 3187-3189 (digest PD-023 to PD-028, PD-070, PD-083).
"""

from collections.abc import Callable, Mapping, Sequence

from fieldrig_devices.iec.host import Library, Pending
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.types import ObjectType, Value
from fieldrig_devices.max4.plc.areas import Areas
from fieldrig_devices.max4.plc.object_types import ObjectTypes
from fieldrig_devices.max4.system import System


class PlcHost:
    """The `iec.host.Host` of one boot."""

    def __init__(
        self,
        system: System,
        libraries: Sequence[Library],
        now_ms: Callable[[], int],
        on_input: Callable[[], None],
    ) -> None:
        """`now_ms` is Timer1; `on_input` is called after each change of a digital input."""
        self._system, self.now_ms = system, now_ms
        self._types = ObjectTypes(system.tree)
        self._parameters = self._types.parameters
        self._areas = Areas(system.terminals, on_input)
        self.on_output = self._areas.on_output
        self._libraries = tuple(libraries)

    def connect(self) -> None:
        """Follow the terminals, for a program that is loaded; one that is only compiled leaves them to the present one.

        Once a download that was refused had taken the inputs from the program that went on.
        """
        self._areas.connect()

    @property
    def libraries(self) -> Sequence[Library]:
        return self._libraries

    @property
    def object_types(self) -> Mapping[str, ObjectType]:
        return self._types.types

    @property
    def objects(self) -> Mapping[str, ConfiguredObject]:
        return self._types.objects

    def read(self, address: int) -> Value:
        return self._parameters[address].value

    def write(self, address: int, value: Value) -> None:
        self._parameters[address].set(value)

    def read_slowly(self, address: int) -> Pending:
        pending = Pending()
        node, parameter = self._types.slow[address]
        drive = self._system.drive_parameters.get(node.symbol)
        if drive is None or parameter.name == "DiagQuit":
            pending.finish(parameter.value)
        else:
            drive.read(parameter.name, pending.finish)
        return pending

    def write_slowly(self, address: int, value: Value) -> Pending:
        """Write a parameter of a drive; ValueError if it cannot have this value."""
        pending = Pending()
        node, parameter = self._types.slow[address]
        if parameter.name == "DiagQuit":
            if value:
                self._system.axes[node.symbol].quit_errors(lambda _is_good: pending.finish())
            else:
                pending.finish()
        else:
            self._system.drive_parameters[node.symbol].write(parameter.name, value, pending.finish)
        return pending

    @property
    def inputs(self) -> bytearray:
        return self._areas.inputs

    @property
    def outputs(self) -> bytearray:
        return self._areas.outputs
