"""The electronic name plate: the data of a motor, and their bytes in the encoder's memory.

Terms: manual 6452-6454, 6718, 6841, 6909, 6955-6961, 7103 (digest PD-177).  The manual does not give the format
(PD-170), so it is ours: data field 0, 128 bytes, big endian, as in docs/devices/pacdrive/nameplate.md.  Values have
fixed resolutions, which a plate file has to observe, so that a plate reads back as it was written.
"""

import binascii
import struct
from collections.abc import Callable
from enum import Enum
from math import pi
from typing import Annotated, Any, Final, NamedTuple, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from fieldrig.config.wording import explain
from fieldrig.settings import Settings
from fieldrig_devices.hiperface.memory import BLANK
from fieldrig_devices.hiperface.shaft import INCREMENTS
from fieldrig_devices.hiperface.telegram import LARGEST_FIELD

MAGIC: Final = b"FRNP"
VERSION: Final = 1
HEAD: Final = struct.Struct(">4sBB")
"""Magic, version, length including head and CRC."""
CRC: Final = struct.Struct(">H")


class Wrong(Enum):
    """Reasons why data are not a valid plate."""

    BLANK = "there is no plate in this memory"
    FOREIGN = "this is no plate that fieldrig knows"
    CHECKSUM = "the plate's checksum is wrong"
    VALUES = "the plate has values that cannot be"


class PlateError(ValueError):
    def __init__(self, wrong: Wrong, detail: str = "") -> None:
        super().__init__(f"{wrong.value}: {detail}" if detail else wrong.value)
        self.wrong = wrong


def _kept_in(scale: int) -> AfterValidator:
    def check(value: float) -> float:
        raw = value * scale
        if abs(raw - round(raw)) > 1e-6 * max(1.0, abs(raw) * 1e-6):
            raise ValueError(
                f"{value:g} is not a multiple of {1 / scale:g}; expected, for example, {round(raw) / scale:g}"
            )
        return round(raw) / scale

    return AfterValidator(check)


def _text(longest: int) -> Any:
    about = "ASCII characters, without a blank at either end"
    return Field(min_length=1, max_length=longest, pattern=r"^[!-~]([ -~]*[!-~])?$", description=about)


_U16, _U32, _I32 = 0xFFFF, 0xFFFF_FFFF, 0x7FFF_FFFF
Current = Annotated[float, Field(gt=0, le=_U16 / 100), _kept_in(100)]
Torque = Annotated[float, Field(gt=0, le=_U32 / 1000), _kept_in(1000)]
Degrees = Annotated[float, Field(ge=-50, le=300), _kept_in(10)]


class NamePlate(Settings):
    type: Annotated[str, _text(24)] = Field(description="of the motor")
    serial_number: Annotated[str, _text(16)] = Field(description="of the motor")
    rated_speed_rpm: int = Field(gt=0, le=_U16, description="at rated torque")
    max_speed_rpm: int = Field(gt=0, le=_U16, description="mechanical limit")
    rated_torque_nm: Torque = Field(description="continuous, at rated speed")
    standstill_torque_nm: Torque = Field(description="continuous, at standstill")
    peak_torque_nm: Torque = Field(description="short-term")
    rated_current_a: Current = Field(description="at rated torque and speed")
    standstill_current_a: Current = Field(description="at standstill torque")
    peak_current_a: Current = Field(description="at peak torque")
    torque_constant_nm_per_a: Annotated[float, Field(gt=0, le=_U16 / 1000), _kept_in(1000)] = Field(
        description="standstill torque over standstill current, to within 5 %"
    )
    inertia_kgcm2: Annotated[float, Field(gt=0, le=_U32 / 1000), _kept_in(1000)] = Field(
        description="including the brake"
    )
    pole_pairs: int = Field(gt=0, le=0xFF)
    is_multi_turn: bool = Field(description="the encoder distinguishes 4096 turns; false: a single turn")
    encoder_increments: int = Field(
        default=INCREMENTS, gt=0, le=_U32, description="increments per turn, as the drive counts"
    )
    offset_increments: int = Field(
        default=0, ge=-_I32, le=_I32, description="from the encoder's zero to the rotor's first pole"
    )
    winding_warning_c: Degrees = Field(default=120.0, description="in degrees Celsius")
    winding_limit_c: Degrees = Field(default=140.0, description="where the thermo contact opens, in degrees Celsius")
    thermal_time_s: int = Field(default=1800, gt=0, le=_U16, description="time constant of the casing")
    brake_torque_nm: Annotated[float, Field(ge=0, le=_U32 / 1000), _kept_in(1000)] = Field(
        default=0.0, description="of the holding brake; 0 without a brake"
    )
    brake_lift_ms: int = Field(default=40, ge=0, le=_U16, description="until the brake has lifted")
    brake_drop_ms: int = Field(default=20, ge=0, le=_U16, description="until the brake holds")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        rising = (
            ("rated_speed_rpm", "max_speed_rpm"),
            ("rated_torque_nm", "standstill_torque_nm"),
            ("standstill_torque_nm", "peak_torque_nm"),
            ("rated_current_a", "standstill_current_a"),
            ("standstill_current_a", "peak_current_a"),
            ("winding_warning_c", "winding_limit_c"),
        )
        for low, high in rising:
            if getattr(self, low) > getattr(self, high):
                raise ValueError(f"{low} is above {high}, {getattr(self, high):g}")
        quotient = self.standstill_torque_nm / self.standstill_current_a
        if abs(self.torque_constant_nm_per_a - quotient) > 0.05 * quotient:  # manual 7103
            raise ValueError(
                f"torque_constant_nm_per_a is not standstill torque over standstill current, {quotient:.3g} Nm/A"
            )
        return self

    @property
    def has_brake(self) -> bool:
        return self.brake_torque_nm > 0

    @property
    def acceleration_time_ms(self) -> float:
        """Time from standstill to rated speed at peak torque, without load (manual 6454)."""
        speed_rad_per_s = self.rated_speed_rpm * pi / 30
        return 1000 * self.inertia_kgcm2 * 1e-4 * speed_rad_per_s / self.peak_torque_nm

    def encode(self) -> bytes:
        """Return the whole content of data field 0."""
        body = b"".join(struct.pack(">" + entry.form, _raw(self, entry)) for entry in LAYOUT)
        plate = HEAD.pack(MAGIC, VERSION, LENGTH) + body
        plate += CRC.pack(binascii.crc_hqx(plate, 0xFFFF))
        return plate.ljust(LARGEST_FIELD, bytes((BLANK,)))

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Return the plate of encoded data.  Raises PlateError for other data."""
        length = plate_length(data)
        if (
            len(data) < length
            or CRC.pack(binascii.crc_hqx(data[: length - CRC.size], 0xFFFF)) != data[length - CRC.size : length]
        ):
            raise PlateError(Wrong.CHECKSUM)
        values, offset = dict[str, Any](), HEAD.size
        for entry in LAYOUT:
            (raw,) = struct.unpack_from(">" + entry.form, data, offset)
            values[entry.name] = entry.value(raw)
            offset += struct.calcsize(">" + entry.form)
        try:
            return cls.model_validate(values)
        except ValidationError as cause:
            mistake = explain(cause, values, cls)[0]
            key = "".join(map(str, mistake.path))
            raise PlateError(Wrong.VALUES, f"{key}: {mistake.what}" if key else mistake.what) from cause


class Place(NamedTuple):
    """A value in the plate: its `struct` code, and its conversion to a raw number."""

    name: str
    form: str
    scale: int = 1

    def value(self, raw: Any) -> Any:
        return _READERS[self.form](raw) if self.form in _READERS else raw if self.scale == 1 else raw / self.scale


_READERS: Final[dict[str, Callable[[Any], Any]]] = {
    "24s": lambda raw: raw.rstrip(b"\x00").decode("latin-1"),
    "16s": lambda raw: raw.rstrip(b"\x00").decode("latin-1"),
    "?": bool,
}

LAYOUT: Final = (
    Place("type", "24s"),
    Place("serial_number", "16s"),
    Place("rated_speed_rpm", "H"),
    Place("max_speed_rpm", "H"),
    Place("rated_torque_nm", "I", 1000),
    Place("standstill_torque_nm", "I", 1000),
    Place("peak_torque_nm", "I", 1000),
    Place("rated_current_a", "H", 100),
    Place("standstill_current_a", "H", 100),
    Place("peak_current_a", "H", 100),
    Place("torque_constant_nm_per_a", "H", 1000),
    Place("inertia_kgcm2", "I", 1000),
    Place("pole_pairs", "B"),
    Place("is_multi_turn", "?"),
    Place("encoder_increments", "I"),
    Place("offset_increments", "i"),
    Place("winding_warning_c", "h", 10),
    Place("winding_limit_c", "h", 10),
    Place("thermal_time_s", "H"),
    Place("brake_torque_nm", "I", 1000),
    Place("brake_lift_ms", "H"),
    Place("brake_drop_ms", "H"),
)
"""The values of version 1, from byte 6 on."""
LENGTH: Final = HEAD.size + sum(struct.calcsize(">" + entry.form) for entry in LAYOUT) + CRC.size


def plate_length(head: bytes) -> int:
    """Return the length of the plate that begins with `head`.  Raises PlateError if no plate does."""
    if not head.strip(b"\xff") or not head.strip(b"\x00"):
        raise PlateError(Wrong.BLANK)
    if len(head) < HEAD.size or head[:4] != MAGIC:
        raise PlateError(Wrong.FOREIGN)
    _, version, length = HEAD.unpack_from(head)
    if version != VERSION:
        raise PlateError(Wrong.FOREIGN, f"its version is {version}; expected {VERSION}")
    if length != LENGTH:
        raise PlateError(Wrong.CHECKSUM)
    return LENGTH


def _raw(plate: NamePlate, place: Place) -> Any:
    value = getattr(plate, place.name)
    if isinstance(value, str):
        return value.encode("ascii")
    return round(value * place.scale) if place.scale != 1 else value
