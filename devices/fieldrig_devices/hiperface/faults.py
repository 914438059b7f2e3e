"""The faults of a HIPERFACE encoder, and their effects."""

from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field, ValidationError

from fieldrig.clock import Clock
from fieldrig.config.wording import explain
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig_devices.hiperface.encoder import HiperfaceEncoder
from fieldrig_devices.hiperface.plate import HEAD, NamePlate
from fieldrig_devices.hiperface.requests import Trouble


class _Struck(Timed):
    counts_uses: ClassVar[bool] = True

    count: int | None = Field(default=None, ge=1, description="number of telegrams affected; default: no limit")
    probability: float = Field(default=1.0, gt=0, le=1, description="probability that a matching telegram is affected")


class Silent(_Struck):
    """The encoder does not answer, as without supply or with a broken cable."""

    what: Literal["silent"]


class Memory(_Struck):
    """Data fields cannot be read or written: status 06h, wrong checksum of the memory."""

    what: Literal["memory"]


class Checksum(_Struck):
    """A checksum is wrong: that of the plate, with one bit flipped, or that of the telegrams."""

    what: Literal["checksum"]
    of: Literal["plate", "telegrams"] = "plate"


class WrongPlate(Timed):
    """Another motor's plate is in the memory."""

    counts_uses: ClassVar[bool] = True

    what: Literal["wrong_plate"]
    type: str | None = Field(default=None, min_length=1, max_length=24, description="of the other motor")
    serial_number: str = Field(default="SWAPPED", min_length=1, max_length=16, description="of the other motor")
    factor: float = Field(default=1.0, gt=0, le=10, description="multiplies its torques, currents and inertia")


EncoderFault = Annotated[Silent | Memory | Checksum | WrongPlate, Field(discriminator="what")]
MODELS: Final = models_of(EncoderFault)

SCALED: Final = {
    "rated_torque_nm": 3,
    "standstill_torque_nm": 3,
    "peak_torque_nm": 3,
    "rated_current_a": 2,
    "standstill_current_a": 2,
    "peak_current_a": 2,
    "inertia_kgcm2": 3,
}
"""The values of a plate that `factor` multiplies, and the digits that the plate keeps of each."""


class EncoderFaults:
    """The faults of one encoder that has this plate."""

    def __init__(self, clock: Clock, encoder: HiperfaceEncoder, plate: NamePlate, random: Any) -> None:
        """`random` is the `random.Random` that the rig gives to this device; devices don't import that module."""
        self._clock, self._plate = clock, plate
        self._records: Faults[Fault[Any]] = Faults(Fault, random)
        self.injected = InjectedFaults(clock, MODELS, self._records, check=self._check)
        encoder.requests.trouble = Trouble(
            is_silent=lambda: self._strikes(Silent),
            is_memory_dead=lambda: self._strikes(Memory),
            is_garbling=lambda: self._strikes(Checksum, of="telegrams"),
            plate=self._as_read,
        )

    def plate_in_place(self, field: bytes) -> bytes:
        """Return data field 0 with the plate that the faults substitute."""
        for settings in self.injected.active(WrongPlate):
            field = self._other(settings).encode()
        return field

    def _check(self, settings: EncoderFault) -> None:
        """Raise ValueError for a fault that would need an impossible plate."""
        if isinstance(settings, WrongPlate):
            self._other(settings)

    def _as_read(self, field: bytes) -> bytes:
        now_ns = self._clock.now_ns()
        for fault in self._records.of(WrongPlate):
            fault.applied += fault.is_on(now_ns)
        field = self.plate_in_place(field)
        if self._strikes(Checksum, of="plate") and len(field) > HEAD.size:
            field = field[: HEAD.size] + bytes((field[HEAD.size] ^ 0x20,)) + field[HEAD.size + 1 :]
        return field

    def _strikes(self, model: type[Timed], **wanted: str) -> bool:
        now_ns, has_struck = self._clock.now_ns(), False
        for fault in self._records.of(model):
            fits = all(getattr(fault.settings, key) == value for key, value in wanted.items())
            if fits and fault.is_on(now_ns) and fault.happens(now_ns):
                self._records.use(fault)
                has_struck = True
        return has_struck

    def _other(self, fault: WrongPlate) -> NamePlate:
        """Return the plate of the other motor.  Raises ValueError if that plate is invalid."""
        values = self._plate.model_dump() | {"serial_number": fault.serial_number}
        if fault.type is not None:
            values["type"] = fault.type
        for key, digits in SCALED.items():
            values[key] = round(values[key] * fault.factor, digits)
        try:
            return NamePlate.model_validate(values)
        except ValidationError as cause:
            wrong = explain(cause, values, NamePlate)[0]
            key = "".join(map(str, wrong.path))
            raise ValueError(f"the fault needs an invalid plate: {key}: {wrong.what}\n{wrong.remedy}") from cause
