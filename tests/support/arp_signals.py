"""An ARP card with real analog channels, cam switches and regulators, and axes that a test moves by hand."""

from collections.abc import Mapping

from arp_card import RecordedCard

from fieldrig.clock import MS
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.parameters import GENERAL, Kind, Parameters, ParX
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import CamSwitch
from fieldrig_devices.arp.runtime.program import ArpProgram
from fieldrig_devices.arp.signals.analog_inputs import AnalogInputs
from fieldrig_devices.arp.signals.analog_outputs import AnalogOutputs
from fieldrig_devices.arp.signals.cam_switches import CamSwitches
from fieldrig_devices.arp.signals.regulators import Regulators


class SignalsCard(RecordedCard):
    """The card, its axes, and its control loop; `positions` and `speeds` are raw."""

    def __init__(self, general: Mapping[int, int] | None = None, readings: Readings | None = None) -> None:
        """`general` are the values of @Par[m] at power-on, as whole numbers."""
        super().__init__()
        self.driven: dict[int, float | None] = {1: None, 2: None}
        self.diagnostics: dict[tuple[int, int], float] = {}
        self.blocked: list[int] = []
        self.real_parameters = Parameters()
        self.errors = CardErrors(self.blocked.append)
        for number, value in (general or {}).items():
            assert self.set_general(number, value)
        readings = readings or Readings()
        self.inputs = AnalogInputs(self.real_parameters)
        self.outputs = AnalogOutputs(self.real_parameters, self.errors, self)
        self.cam_switches = CamSwitches(self, self.F, self.O, self.real_parameters, readings)
        self.regulators = Regulators(
            self.real_parameters, self.V, self.F, self.errors, self.inputs, self.outputs, self, readings
        )
        self.inputs.start()

    def set_general(self, number: int, value: float) -> bool:
        return self.real_parameters.set_ram(GENERAL, number, round(value * SCALE))

    def set_kind(self, axis: int, kind: Kind) -> None:
        assert self.real_parameters.set_ram(axis, ParX.KIND, kind * SCALE)

    def loop(self, ms: int = 1, period_ms: int = 1) -> None:
        """Run control loops for this time."""
        for _ in range(ms // period_ms):
            self.time_ns += period_ms * MS
            self.inputs.control(self.time_ns)
            self.regulators.control(self.time_ns)
            self.cam_switches.control()
            self.outputs.control(self.time_ns)

    # ---- axes

    def volts(self, axis: int) -> float | None:
        return self.driven[axis]

    def diagnostic(self, axis: int, code: int) -> float:
        return self.diagnostics[axis, code]

    # ---- calls of a program

    def warn(self, code: int) -> None:
        self.errors.warn(code)

    def general_parameter(self, number: int) -> int:
        return self.real_parameters.ram[GENERAL][number]

    def axis_parameter(self, axis: int, number: int) -> int:
        return self.real_parameters.ram[axis][number]

    def set_axis_parameter(self, axis: int, number: int, raw: int) -> None:
        assert self.real_parameters.set_ram(axis, number, raw)

    def regulate(self, cell: int, output: int, first: int) -> None:
        self.regulators.regulate(cell, output, first)

    def arm_cam_switch(self, number: int, cam: CamSwitch) -> None:
        self.cam_switches.arm(number, cam)

    def disarm_cam_switch(self, number: int) -> None:
        self.cam_switches.disarm(number)

    def read_analog(self, channel: int) -> int:
        return self.inputs.read(channel)

    def write_analog(self, channel: int, volt: int, slope_ms: int) -> None:
        self.outputs.write(channel, volt, slope_ms)


class SignalsBench:
    """A program on such a card: each loop runs the parts, then 20 instructions."""

    def __init__(self, source: str, card: SignalsCard | None = None) -> None:
        """`source` is a whole program, or the instructions of a main program alone."""
        whole = source if "beg" in source.casefold() else f"BEG MAIN\n{source}\nEND"
        self.card = card or SignalsCard()
        self.program = ArpProgram(compile_text(whole), self.card)
        self.program.start()

    def run(self, ms: int = 1) -> "SignalsBench":
        for _ in range(ms):
            self.card.loop()
            self.program.tick()
            self.program.run(20)
        return self
