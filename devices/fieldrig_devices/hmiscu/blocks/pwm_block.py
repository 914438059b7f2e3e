"""The block PWM (SCU-066 to SCU-074).  It has no Execute: its inputs are levels that count in each call."""

from fieldrig_devices.hmiscu.blocks.pins import Block
from fieldrig_devices.hmiscu.blocks.tables import PWM as PWM_TYPE
from fieldrig_devices.hmiscu.enumerations import ErrorId
from fieldrig_devices.hmiscu.pwm.channel import PwmChannel, PwmPins, Wave


class PWM(Block):
    type = PWM_TYPE

    def __init__(self, channel: PwmChannel) -> None:
        super().__init__()
        self._channel = channel

    def call(self, now_ns: int) -> None:
        pins, channel = self.inputs, self._channel
        enables = bool(pins["EN_Enable"]), bool(pins["F_Enable"])
        syncs = bool(pins["EN_Sync"]), bool(pins["F_Sync"])
        channel.set_pins(now_ns, PwmPins(*enables, *syncs, Wave(pins["Frequency"], pins["Duty"])))
        is_reached = channel.is_in_frequency
        self.outputs.update(
            InFrequency=is_reached,
            Busy=channel.is_enabled and not is_reached and not channel.is_wrong,
            Error=channel.is_wrong,
            ErrID=ErrorId.PTO_INVALID_PARAMETER if channel.is_wrong else ErrorId.NO_ERROR,
        )
