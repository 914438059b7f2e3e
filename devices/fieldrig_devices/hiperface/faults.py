"""Faults of an encoder: what they may be told, and what they do to it."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, cast

from pydantic import Field, ValidationError

from fieldrig import faults
from fieldrig.clock import Clock
from fieldrig.faults import Fault, Faults, Timed
from fieldrig.wording import explain
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder
from fieldrig_devices.hiperface.plate import HEAD, NamePlate
from fieldrig_devices.hiperface.requests import Trouble


class _Struck(Timed):
    count: int | None = Field(default=None, ge=1, description="telegrams that it strikes; left out: any number")
    probability: float = Field(default=1.0, gt=0, le=1, description="of striking a telegram that fits")


class Silent(_Struck):
    """It doesn't answer: no supply, a broken cable."""

    what: Literal["silent"]


class Memory(_Struck):
    """Data fields can't be read or written: status 06h, checksum of the memory wrong."""

    what: Literal["memory"]


class Checksum(_Struck):
    """A checksum is wrong: the plate's, as one bit of it has gone, or that of the telegrams."""

    what: Literal["checksum"]
    of: Literal["plate", "telegrams"] = "plate"


class WrongPlate(Timed):
    """Another motor's plate is in the memory."""

    what: Literal["wrong_plate"]
    type: str | None = Field(default=None, min_length=1, max_length=24, description="left out: the same")
    serial_number: str = Field(default="SWAPPED", min_length=1, max_length=16, description="of the other motor")
    factor: float = Field(default=1.0, gt=0, le=10, description="its torques, currents and inertia are so much larger")


EncoderFault = Annotated[Silent | Memory | Checksum | WrongPlate, Field(discriminator="what")]
MODELS: Final = faults.models_of(EncoderFault)
TEXTS: Final = frozenset({"what", "of", "type", "serial_number"})
"""Keys whose values are texts, even where YAML would see a number."""


def fault_of(given: Mapping[str, Any]) -> EncoderFault:
    """ValueError if that is no fault: what is wrong, and on further lines what would be right."""
    return cast(EncoderFault, faults.fault_of(given, MODELS, TEXTS))


SCALED: Final = {
    "rated_torque_nm": 3,
    "standstill_torque_nm": 3,
    "peak_torque_nm": 3,
    "rated_current_a": 2,
    "standstill_current_a": 2,
    "peak_current_a": 2,
    "inertia_kgcm2": 3,
}
"""What `factor` makes larger, and the digits that a plate keeps of it."""


class EncoderFaults:
    """Those of one encoder with this plate."""

    def __init__(self, clock: Clock, encoder: HiperfaceEncoder, plate: NamePlate, random: Any) -> None:
        """`random` is the rig's for this device, a random.Random; devices don't import that."""
        self._clock, self._encoder, self._plate = clock, encoder, plate
        self._given: Faults[Fault[Any]] = Faults(Fault, random)
        encoder.requests.trouble = Trouble(
            is_silent=lambda: self._strikes(Silent),
            is_memory_dead=lambda: self._strikes(Memory),
            is_garbling=lambda: self._strikes(Checksum, of="telegrams"),
            plate=self._as_read,
        )

    def add(self, given: Mapping[str, Any]) -> int:
        """ValueError if that is no fault."""
        settings = fault_of(given)
        if isinstance(settings, WrongPlate):
            self._other(settings)
        return self._given.add(self._clock.now_ns(), settings).number

    def clear(self, number: int) -> None:
        self._given.clear(number)

    def about(self) -> Mapping[int, Mapping[str, Any]]:
        return self._given.about(self._clock.now_ns())

    def plate_in_place(self, field: bytes) -> bytes:
        """Data field 0 as it seems to be."""
        now_ns = self._clock.now_ns()
        for fault in self._given.of(WrongPlate):
            if fault.is_on(now_ns):
                field = self._other(fault.settings).encode()
        return field

    def _as_read(self, field: bytes) -> bytes:
        now_ns = self._clock.now_ns()
        for fault in self._given.of(WrongPlate):
            fault.applied += fault.is_on(now_ns)
        field = self.plate_in_place(field)
        if self._strikes(Checksum, of="plate") and len(field) > HEAD.size:
            field = field[: HEAD.size] + bytes((field[HEAD.size] ^ 0x20,)) + field[HEAD.size + 1 :]
        return field

    def _strikes(self, kind: type[Timed], **wanted: str) -> bool:
        now_ns, has_struck = self._clock.now_ns(), False
        for fault in self._given.of(kind):
            fits = all(getattr(fault.settings, key) == value for key, value in wanted.items())
            if fits and fault.is_on(now_ns) and fault.happens(now_ns):
                fault.applied += 1
                has_struck = True
        return has_struck

    def _other(self, fault: WrongPlate) -> NamePlate:
        """ValueError if there can't be such a plate."""
        values = self._plate.model_dump() | {"serial_number": fault.serial_number}
        if fault.type is not None:
            values["type"] = fault.type
        for key, digits in SCALED.items():
            values[key] = round(values[key] * fault.factor, digits)
        try:
            return NamePlate.model_validate(values)
        except ValidationError as cause:
            found = explain(cause, values, NamePlate)[0]
            key = "".join(map(str, found.path))
            raise ValueError(f"there can't be such a plate: {key}: {found.what}\n{found.remedy}") from cause
