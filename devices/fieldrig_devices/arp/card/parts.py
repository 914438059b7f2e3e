"""The parts of one card; this module has no behaviour."""

from dataclasses import dataclass

from fieldrig.clock import Clock
from fieldrig_devices.arp.can.remote_io import RemoteIo
from fieldrig_devices.arp.card.local_io import LocalIo
from fieldrig_devices.arp.card.memory import Memory
from fieldrig_devices.arp.card.permanent import Permanent
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.motion.axes import Axes
from fieldrig_devices.arp.parameters import Parameters
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import AnalogOutputs
from fieldrig_devices.arp.signals.cam_switches import CamSwitches
from fieldrig_devices.arp.signals.regulators import Regulators
from fieldrig_devices.arp.terminal.link import TerminalLink


@dataclass(frozen=True, slots=True)
class Parts:
    clock: Clock
    number: int
    F: list[int]
    I: list[int]  # noqa: E741  the manual's letter
    O: list[int]  # noqa: E741
    parameters: Parameters
    errors: CardErrors
    memory: Memory
    permanent: Permanent
    axes: Axes
    analog_inputs: AnalogInputs
    analog_outputs: AnalogOutputs
    cam_switches: CamSwitches
    regulators: Regulators
    io: LocalIo
    terminal: TerminalLink
    remote_io: RemoteIo | None
    """Master of the I/O nodes, or None without a CAN bus or without I/O nodes."""

    @property
    def V(self) -> list[int]:  # noqa: N802
        return self.permanent.V
