"""The system that a boot builds from a configuration: object tree, axes, terminals, encoders, real-time process.

Source: PacDrive manual 3604-3640, 4163-4196 (digest PD-020 to PD-025, PD-096).  Groups and parameters that the manual
does not name are ours.
"""

import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig.device import Value
from fieldrig.link import Link
from fieldrig_bus.wires import Signal
from fieldrig_devices.drives.state_words import AXIS_WORDS, MC4_WORDS
from fieldrig_devices.max4.axes.axis import INCREMENTS, Axis
from fieldrig_devices.max4.axes.encoder import LogicEncoder, MasterEncoder
from fieldrig_devices.max4.axes.simulated import SimulatedDrive
from fieldrig_devices.max4.com1.parameters import Com1Parameters
from fieldrig_devices.max4.configuration.files import Configuration
from fieldrig_devices.max4.configuration.limits import CYCLES_MS
from fieldrig_devices.max4.configuration.tree import Access, ObjectTree, Parameter, Type
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import MAX4, Diagnosis
from fieldrig_devices.max4.own_object import Owner, add_own_parameters, add_tasks, trigger
from fieldrig_devices.max4.process import RealTimeProcess
from fieldrig_devices.max4.ring.drive_end import RingDrive
from fieldrig_devices.max4.ring.drive_parameters import DriveParameters
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.terminals import DigitalInput, DigitalOutput, MeasuringInput, Terminals

log = logging.getLogger(__name__)

CYCLE_TIME: Final = "MAx-4.General.CycleTime"


class System:
    """The system of one boot."""

    def __init__(
        self,
        clock: Clock,
        settings: Max4Settings,
        configuration: Configuration,
        start_values: Mapping[str, Value],
        wires: Link[Signal] | None,
        owner: Owner,
    ) -> None:
        """`start_values` that fit no parameter are ignored and named in `unknown`."""
        self._clock, self._settings, self._owner = clock, settings, owner
        self.configuration = configuration
        self.tree = ObjectTree()
        wanted_ms = start_values.get(CYCLE_TIME, settings.cycle_ms)
        self.cycle_ns = (int(wanted_ms) if wanted_ms in CYCLES_MS else settings.cycle_ms) * MS
        self.process = RealTimeProcess(clock, self.cycle_ns, settings.load, self._on_overflow)
        self.terminals = Terminals(wires)
        self.axes: dict[str, Axis] = {}
        self.drives: list[RingDrive] = []
        self.drive_parameters: dict[str, DriveParameters] = {}
        self.unknown: list[str] = []
        add_own_parameters(self.tree, self.process, settings, owner)
        self._bus_objects()
        self._terminal_objects()
        self._encoder_objects()
        add_tasks(self.tree, configuration.iec_tasks, owner.plc)
        self.com1 = Com1Parameters(self.tree, configuration.modems, owner.com1)
        for path, value in start_values.items():
            self._start_value(path, value)

    def start(self) -> None:
        self.terminals.start()
        for simulated in self.process.simulated:
            simulated.start()

    def stored_values(self) -> dict[str, Value]:
        """The values for the parameter file, by path."""
        parameters = self.tree.parameters()
        values = {path: parameter.value for path, parameter in parameters if parameter.access is Access.INPUT_INIT}
        for symbol, drive in self.drive_parameters.items():
            for name, value in drive.start_values.items():
                values[f"{self.axes[symbol].object.path}.{name}"] = value
        return values

    def _start_value(self, path: str, value: Value) -> None:
        try:
            parameter = self.tree.parameter(path)
            if parameter.access is Access.SLOW:
                owner = self.tree.object(path.rpartition(".")[0])
                self.drive_parameters[owner.symbol].start_values[parameter.name] = parameter.checked(value)
            elif parameter.access is Access.INPUT_INIT:
                parameter.set(value)
            else:
                raise ValueError(f"{path}: expected no start value, because it is {parameter.access.value}")
        except KeyError:
            self.unknown.append(f"{path}: expected the path of a parameter")
        except ValueError as wrong:
            self.unknown.append(str(wrong))

    def _on_overflow(self, reserve_us: int) -> None:
        self._owner.report(Code.WRITE_OVERFLOW, MAX4, f"{reserve_us} us")

    # ---- the ring

    def _bus_objects(self) -> None:
        bus = self.tree.root.add("Real-time bus", "RTBUS", "")
        for symbol, drive in self.configuration.drives.items():
            node = bus.add("MC-4", "MC_4", symbol)
            diagnosis = Diagnosis(lambda symbol=symbol: self.axes[symbol].changed())  # type: ignore[misc]  # bound in this iteration
            axis = Axis(symbol, node, drive.ring_address, diagnosis, is_simulated=drive.simulated)
            self.axes[symbol] = axis
            self._axis_parameters(axis)
            if drive.simulated:
                self.process.simulated.append(SimulatedDrive(axis, self.cycle_ns))
            else:
                self.drives.append(RingDrive(axis, drive.commands, self._owner.cycles.on_code))
                self.drive_parameters[symbol] = DriveParameters(self._clock, axis, node)

    def _axis_parameters(self, axis: Axis) -> None:
        general = axis.object.group("General")
        general.add(Parameter("RealTimeBusAdr", Type.UINT, read=lambda: axis.ring_address))
        general.add(Parameter("logAdr", Type.DINT, read=lambda: axis.log_adr))
        general.add(
            Parameter(
                "ControllerEnable",
                Type.BOOL,
                Access.INPUT,
                read=lambda: axis.is_enabled,
                write=lambda value: axis.enable(bool(value)),
            )
        )
        general.add(Parameter("AxisState", Type.UINT, read=lambda: axis.axis_state.value, words=AXIS_WORDS))
        general.add(Parameter("MC4State", Type.UINT, read=lambda: axis.mc4_state, words=MC4_WORDS))
        general.add(Parameter("Position", Type.LREAL, unit="incr", read=lambda: axis.position))
        general.add(Parameter("Velocity", Type.LREAL, unit="incr/s", read=lambda: axis.velocity))
        general.add(Parameter("Torque", Type.INT, unit="0.1%", read=lambda: axis.torque))
        general.add(Parameter("SetValue", Type.LREAL, read=lambda: axis.set_value))
        general.add(Parameter("FollowingError", Type.LREAL, unit="incr", read=lambda: axis.following_error))
        diagnosis = axis.object.group("Diagnosis")
        diagnosis.add(Parameter("DiagCode", Type.UINT, read=lambda: axis.diag_code))
        diagnosis.add(Parameter("DiagMsg", Type.STRING, read=lambda: axis.diag_msg))
        diagnosis.add(trigger("DiagQuit", axis.quit_errors, "acknowledge (quit) the diagnoses of this axis"))
        at_errors = partial(self._owner.cycles.at_errors, axis.ring_address)
        diagnosis.add(Parameter("ATErrors", Type.UDINT, read=at_errors, about="ATs that did not arrive"))
        mechanics = axis.object.group("Mechanics")
        mechanics.add(
            Parameter(
                "FeedConst",
                Type.LREAL,
                Access.INPUT_INIT,
                float(INCREMENTS),
                unit="units",
                about="of cams and positioning functions, in one revolution of the motor",
            )
        )

    # ---- terminals and encoders

    def _terminal_objects(self) -> None:
        root, names, terminals, settings = self.tree.root, self.configuration, self.terminals, self._settings
        outputs = root.add("Digital output group", "D_OUT_GROUP", "")
        for number, symbol in enumerate(names.outputs):
            drive = partial(terminals.drive, settings.outputs.get(symbol, ""))
            terminals.outputs[symbol] = DigitalOutput(outputs.add(f"output_{number}", "D_OUT", symbol), drive)
        inputs = root.add("Digital input group", "D_IN_GROUP", "")
        for number, symbol in enumerate(names.inputs):
            terminal = DigitalInput(inputs.add(f"input_{number}", "D_IN", symbol))
            terminals.inputs[symbol] = terminal
            terminals.listen(settings.inputs.get(symbol, ""), partial(_put, terminal.put))
        probes = root.add("Digital measuring input group", "M_IN_GROUP", "")
        for number, symbol in enumerate(names.measuring_inputs):
            node = probes.add(f"measuring_input_{number}", "M_IN", symbol)
            probe = MeasuringInput(self._clock, node, self.axes, self.cycle_ns)
            terminals.measuring[symbol] = probe
            self.process.measuring.append(probe)
            terminals.listen(settings.measuring_inputs.get(symbol, ""), partial(_put, probe.put))

    def _encoder_objects(self) -> None:
        root, process = self.tree.root, self.process
        for symbol in self.configuration.logic_encoders:
            process.logic_encoders.append(LogicEncoder(root.add("Logic encoder", "LOGIC_ENC", symbol)))
        for symbol in self.configuration.master_encoders:
            master = MasterEncoder(self._clock, root.add("Master encoder", "MASTER_ENC", symbol))
            process.master_encoders.append(master)
            self.terminals.listen(self._settings.master_encoders.get(symbol, ""), master.take)


def _put(put: Callable[[bool], None], signal: Signal) -> None:
    put(bool(signal.value))
