"""Reading the name plate and the absolute position of the motor, which takes the encoder many milliseconds.

Source: manual 513-540 (digest PD-170 to PD-174).
"""

from collections.abc import Callable
from typing import NamedTuple

from fieldrig_devices.drives.motor import Encoder, MotorData
from fieldrig_devices.mc4.diagnosis import Code


class Plate(NamedTuple):
    """A plate that has been read."""

    motor: MotorData
    increments: int
    """The position that the encoder has reported."""
    asked_at: float
    """The true position of the shaft when the encoder was asked for it, in increments."""


class PlateReader:
    """Reads the plate of one drive.  `encoder` has to be set before."""

    __slots__ = ("_is_bad", "_readings", "_shaft", "encoder")

    def __init__(self, is_bad: Callable[[], bool], shaft: Callable[[], float]) -> None:
        """`is_bad` tells that a fault spoils the plate, and `shaft` is the true position at present."""
        self._is_bad, self._shaft = is_bad, shaft
        self.encoder: Encoder | None = None
        self._readings = 0

    @property
    def is_reading(self) -> bool:
        return self._readings > 0

    def read(self, done: Callable[[Plate | Code], None]) -> None:
        """Call `done` with the plate, or with the message that tells why there is none."""
        encoder = self.encoder
        assert encoder is not None
        self._readings += 1
        asked_at = 0.0

        def end(result: Plate | Code) -> None:
            self._readings -= 1
            done(result)

        def on_asked() -> None:
            nonlocal asked_at
            asked_at = self._shaft()

        def on_plate(motor: MotorData | None) -> None:
            if motor is None or self._is_bad():
                end(Code.ENCODER_MEMORY)
            else:
                encoder.read_position(lambda increments: on_position(motor, increments), on_asked)

        def on_position(motor: MotorData, increments: int | None) -> None:
            if self._is_bad():  # a fault may have been added meanwhile
                end(Code.ENCODER_MEMORY)
            elif increments is None:
                end(Code.ENCODER_SIGNAL)
            else:
                end(Plate(motor, increments, asked_at))

        encoder.read_plate(on_plate)
