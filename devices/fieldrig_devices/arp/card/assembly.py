"""Assembly of a card: its parts are built from its settings and connected to each other."""

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.arp.can.remote_io import RemoteIo
from fieldrig_devices.arp.card.local_io import LocalIo, wire_names
from fieldrig_devices.arp.card.memory import Memory
from fieldrig_devices.arp.card.parts import Parts
from fieldrig_devices.arp.card.permanent import Permanent
from fieldrig_devices.arp.card.settings import ArpSettings
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.motion.axes import Axes
from fieldrig_devices.arp.parameters import Parameters
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import AnalogOutputs
from fieldrig_devices.arp.signals.cam_switches import CamSwitches
from fieldrig_devices.arp.signals.regulators import Regulators
from fieldrig_devices.arp.terminal.link import TerminalLink


def assemble(
    clock: Clock,
    name: str,
    settings: ArpSettings,
    store: Store,
    wires: Link[Signal] | None,
    io_can: Link[CanFrame] | None,
    terminal_can: Link[CanFrame] | None,
    errors: CardErrors,
) -> Parts:
    """Build the parts.  `io_can` and `terminal_can` are link ends for the masters of the I/O nodes and the terminal."""
    permanent, parameters = Permanent(store), Parameters()
    flags, inputs, outputs = [0] * 321, [0] * 333, [0] * 333
    variables, readings = permanent.V, settings.readings
    axes = Axes(parameters, flags, variables, errors, readings)
    analog_inputs = AnalogInputs(parameters)
    analog_outputs = AnalogOutputs(parameters, errors, axes)
    latches = int(settings.latch1[1:]), int(settings.latch2[1:])
    names = wire_names(name, settings.signals)
    io = LocalIo(clock, wires, names, (inputs, outputs), (analog_inputs, analog_outputs), latches)
    for terminal, value in settings.inputs.items():
        io.put(terminal, value)

    def set_variable(number: int, raw: int) -> None:
        variables[number] = raw
        permanent.keep()

    return Parts(
        clock=clock,
        number=settings.number,
        F=flags,
        I=inputs,
        O=outputs,
        parameters=parameters,
        errors=errors,
        memory=Memory(store),
        permanent=permanent,
        axes=axes,
        analog_inputs=analog_inputs,
        analog_outputs=analog_outputs,
        cam_switches=CamSwitches(axes, flags, outputs, parameters, readings),
        regulators=Regulators(parameters, variables, flags, errors, analog_inputs, analog_outputs, axes, readings),
        io=io,
        terminal=TerminalLink(clock, terminal_can, variables, flags, errors, set_variable, readings),
        remote_io=None
        if io_can is None
        else RemoteIo(clock, io_can, settings.io_nodes, inputs, outputs, errors, readings=readings),
    )
