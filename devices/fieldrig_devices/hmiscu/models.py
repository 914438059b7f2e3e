"""The models of the HMISCU and their terminals.

Source: the data sheets of the four models; the library manual names them only as HMISCUxx5 (lines 272, 409, 1594) and
fixes the fast outputs and the input of Drive Ready (digest SCU-001, SCU-023, section 2.1: output 0 is FQ0, output 1 is
FQ1, Drive Ready is DI2).  Models whose names differ only in the size of the display have the same terminals.
"""

from collections.abc import Iterator, Mapping
from typing import Final, Literal, NamedTuple

ModelName = Literal["HMISCU6A5", "HMISCU8A5", "HMISCU6B5", "HMISCU8B5"]
DRIVE_READY: Final = "DI2"
FAST_OUTPUTS: Final = ("FQ0", "FQ1")
Kind = Literal["digital input", "digital output", "analog input", "temperature input", "analog output"]


class Model(NamedTuple):
    """The numbers of terminals of a model, and its display."""

    inputs: int
    fast_inputs: int
    outputs: int
    analog_inputs: int = 0
    temperature_inputs: int = 0
    analog_outputs: int = 0
    display: tuple[int, int] = (320, 240)
    """Width and height in pixels."""

    def terminals(self) -> Iterator[tuple[str, Kind]]:
        """Yield the name and kind of each terminal, in the order of the image."""
        rows: tuple[tuple[str, int, Kind], ...] = (
            ("DI", self.inputs, "digital input"),
            ("FI", self.fast_inputs, "digital input"),
            ("DQ", self.outputs, "digital output"),
            ("FQ", len(FAST_OUTPUTS), "digital output"),
            ("AI", self.analog_inputs, "analog input"),
            ("TI", self.temperature_inputs, "temperature input"),
            ("AQ", self.analog_outputs, "analog output"),
        )
        for prefix, count, kind in rows:
            for number in range(count):
                yield f"{prefix}{number}", kind


_DIGITAL: Final = Model(inputs=14, fast_inputs=2, outputs=8)
_MIXED: Final = Model(inputs=6, fast_inputs=2, outputs=6, analog_inputs=2, temperature_inputs=2, analog_outputs=2)
MODELS: Final[Mapping[ModelName, Model]] = {
    "HMISCU6A5": _DIGITAL,
    "HMISCU8A5": _DIGITAL,
    "HMISCU6B5": _MIXED,
    "HMISCU8B5": _MIXED,
}
