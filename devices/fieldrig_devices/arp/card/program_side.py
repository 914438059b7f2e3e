"""The interface of the card to its program: it passes each instruction to the part that executes it."""

from fieldrig_devices.arp.card.parts import Parts
from fieldrig_devices.arp.fixed import WRONG_PARAMETER
from fieldrig_devices.arp.parameters import GENERAL


class ProgramSide:
    """Implements `runtime.card.Card`, mostly by the parts' own methods, so that calls are direct."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self.V, self.F, self.I, self.O = parts.V, parts.F, parts.I, parts.O
        self.now_ns = parts.clock.now_ns
        self.warn = parts.errors.warn
        axes = parts.axes
        self.position, self.preset_position, self.speed = axes.position, axes.preset_position, axes.speed
        self.latched_rising, self.latched_falling = axes.latched_rising, axes.latched_falling
        self.limit_speed = axes.limit_speed
        self.limit_acceleration, self.limit_deceleration = axes.limit_acceleration, axes.limit_deceleration
        self.home, self.stop_axis = axes.home, axes.stop_axis
        self.move_to, self.move_by, self.move_at = axes.move_to, axes.move_by, axes.move_at
        self.follow_table = axes.follow_table
        self.regulate = parts.regulators.regulate
        self.arm_cam_switch, self.disarm_cam_switch = parts.cam_switches.arm, parts.cam_switches.disarm
        self.read_analog, self.write_analog = parts.analog_inputs.read, parts.analog_outputs.write
        self.store_message, self.clear_screen = parts.terminal.store_message, parts.terminal.clear_screen
        self.erase_text, self.show_text = parts.terminal.erase_text, parts.terminal.show_text
        self.print_text = parts.terminal.print_text

    def fail(self, code: int) -> None:
        self._parts.errors.fail(code)

    def last_error(self) -> int:
        return self._parts.errors.error

    def last_warning(self) -> int:
        return self._parts.errors.warning

    def general_parameter(self, number: int) -> int:
        return self._parts.parameters.ram[GENERAL][number]

    def axis_parameter(self, axis: int, number: int) -> int:
        return self._parts.parameters.ram[axis][number]

    def set_axis_parameter(self, axis: int, number: int, raw: int) -> None:
        if not self._parts.parameters.set_ram(axis, number, raw):
            self._parts.errors.warn(WRONG_PARAMETER)
