"""The personality of a drive: how it behaves where CiA 402 and CiA 301 leave room, as one small file or key by key.

Source: the differences among the manuals and EDS files of real drives that docs/devices/drive-personalities.md lists.
The files are beside this module; a personality is named for its behaviour.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from enum import StrEnum
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, field_validator

from fieldrig.config import yaml_source
from fieldrig.settings import Settings
from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.cia402 import si_units
from fieldrig_devices.cia402.behaviour import (
    Behaviour,
    EmptyBuffer,
    FaultReset,
    FreeBit,
    HomingBit,
    LimitSwitch,
    ModeDisplay,
    ModeZero,
    VoltageBit,
)
from fieldrig_devices.cia402.homing_methods import ALL_METHODS
from fieldrig_devices.cia402.single.foreign import SPEEDS
from fieldrig_devices.drives.motor import INCREMENTS_PER_TURN

LONGEST_MS: Final = 600_000.0
FOLDER: Final = Path(__file__).with_name("personalities")
Time = Annotated[float, Field(ge=0, le=LONGEST_MS)]
OF_FRAMES: Final = frozenset({
    "missed_syncs", "says_preoperational", "needs_reset_node", "sdo_answer_ms", "sdo_answer_most_ms",
    "loses_first_sdo", "save_ms", "silent_while_saving",
})  # fmt: skip
"""The keys that `manner_link` takes care of."""
ModeNumber = Annotated[int, Field(ge=-128, le=127)]
Index = Annotated[int, Field(ge=0x1001, le=0xFFFF)]
Name = Literal["step-by-step", "runs-ahead", "mains-inverter", "robot-joint", "own-units", "late-and-thin"]


class MappingRule(StrEnum):
    """When a master may change the mapping of the PDOs."""

    FREE = "free"
    PREOPERATIONAL = "preoperational"
    FIXED = "fixed"


class PersonalitySettings(Settings):
    """Every difference with the baseline as its default; only keys that are given have an effect."""

    model_config = ConfigDict(allow_inf_nan=False)

    modes: list[ModeNumber] | None = Field(default=None, description="modes of operation (6060h); default: all")
    homing_methods: list[int] | None = Field(default=None, description="methods (6098h); default: all")
    accepts_no_homing: bool = Field(default=True, description="6098h accepts 0")
    passes_switched_on: bool = Field(default=True, description="0Fh in 'ready to switch on' enables the drive")
    control_cycle_ms: Time = Field(default=0.0, description="the drive looks at the control word once in this time")
    fault_reset: FaultReset = Field(default=FaultReset.EDGE, strict=False, description="what of bit 7 resets a fault")
    resets: int = Field(default=1, ge=1, le=10, description="resets until a fault is gone")
    reset_lock_ms: Time = Field(default=0.0, description="time after a fault without a reset")
    following_error_code: int = Field(default=0x8611, ge=1, le=0xFFFF, description="603Fh for a following error")
    quick_stop_resumes: bool = Field(default=False, description="0Fh during a quick stop enables the drive again")
    voltage_bit: VoltageBit = Field(default=VoltageBit.READY, strict=False, description="meaning of bit 4 of 6041h")
    remote_bit: bool = Field(default=True, description="bit 9 of 6041h")
    bit_14: FreeBit = Field(default=FreeBit.NONE, strict=False, description="meaning of bit 14 of 6041h")
    bit_15: FreeBit = Field(default=FreeBit.NONE, strict=False, description="meaning of bit 15 of 6041h")
    changes_mode_in_halt: bool = Field(default=True, description="6060h takes effect while halt is set")
    mode_display: ModeDisplay = Field(default=ModeDisplay.AT_ONCE, strict=False, description="when 6061h follows 6060h")
    mode_display_ms: Time = Field(default=0.0, description="time until 6061h follows")
    mode_zero: ModeZero = Field(default=ModeZero.NO_CHANGE, strict=False, description="effect of mode 0")
    set_points: int = Field(default=2, ge=1, le=8, description="set-points that the drive holds, with the active one")
    acknowledges_at_start: bool = Field(default=False, description="bit 12 is set after enabling")
    acknowledge_ms: Time = Field(default=0.0, description="time until bit 12 answers bit 4")
    homing_bit: HomingBit = Field(default=HomingBit.STANDING, strict=False, description="bit 10 of 6041h in homing")
    home_offset_sign: Literal[-1, 1] = Field(default=-1, description="sign of 607Ch in the position at home")
    velocity_unit: Literal["user", "counts", "rpm", "scaled"] = Field(
        default="user", description="unit of 60FFh and of all velocities"
    )
    torque_base: Literal["torque", "current"] = Field(
        default="torque", description="what 100 % of torques are: 6076h, or the torque of the current 6075h"
    )
    empty_limits_count: bool = Field(default=False, description="607Dh 0/0 allows position 0 only")
    limit_switch: LimitSwitch = Field(default=LimitSwitch.BLOCKS, strict=False, description="effect of a limit switch")
    empty_buffer: EmptyBuffer = Field(
        default=EmptyBuffer.STANDS, strict=False, description="when interpolation runs dry"
    )
    leaving_counts: bool = Field(default=False, description="6007h applies when the node leaves NMT operational")
    needs_mains: bool = Field(default=False, description="without mains it stays in 'switch on disabled'")
    mains_ms: Time = Field(default=0.0, description="time without mains until it goes there")
    needs_sto: bool = Field(default=False, description="with STO open it stays in 'switch on disabled'")
    sto_faults: bool = Field(default=False, description="an open STO input is a fault, 9000h")
    missed_syncs: int | None = Field(
        default=None, ge=1, le=1_000, description="periods of 1006h without SYNC that are borne; default: any"
    )
    sync_loss: Literal["connection", "fault"] = Field(
        default="connection", description="a missed SYNC acts by 6007h, or is fault 8700h"
    )
    mapping: MappingRule = Field(
        default=MappingRule.FREE, strict=False, description="when the mapping of PDOs can change"
    )
    boot_up_ms: Time = Field(default=0.0, description="time from power-on or reset until the boot-up message")
    says_preoperational: bool = Field(default=False, description="a heartbeat 7Fh follows the boot-up message")
    needs_reset_node: bool = Field(default=False, description="NMT commands count only after a reset of the node")
    sdo_answer_ms: Time = Field(default=0.0, description="time until an SDO answer")
    sdo_answer_most_ms: Time = Field(default=0.0, description="if longer: answers take a time up to this one")
    loses_first_sdo: bool = Field(default=False, description="the first SDO request after each boot is lost")
    save_ms: Time = Field(default=0.0, description="time until the answer to 1010h")
    silent_while_saving: bool = Field(default=False, description="it neither hears nor sends in this time")
    objects: dict[str, bool | int | float | str] = Field(default_factory=dict, description="power-on values")
    missing: list[Index] = Field(default_factory=list, description="indices of objects that the drive lacks")

    @field_validator("homing_methods")
    @classmethod
    def _are_known(cls, methods: list[int] | None) -> list[int] | None:
        unknown = sorted(set(methods or ()) - ALL_METHODS.keys())
        if unknown:
            raise ValueError(f"{unknown[0]} is no homing method: expected numbers from {min(ALL_METHODS)} to 37")
        return methods

    def behaviour(self, base: Behaviour, increments: int) -> Behaviour:
        """Return `base` with the keys that are given, for an encoder of `increments` per turn."""
        known = {field.name for field in fields(Behaviour)}
        given: dict[str, Any] = {name: getattr(self, name) for name in self.model_fields_set & known}
        for name in ("modes", "homing_methods"):
            if name in given:
                given[name] = getattr(base, name) if given[name] is None else frozenset(given[name])
        if "velocity_unit" in given:
            given["velocity_unit"] = _unit(self.velocity_unit, increments)
        return replace(base, **given)

    @property
    def concerns_frames(self) -> bool:
        """True if the end of the bus has to behave in another way than by the book."""
        return not self.model_fields_set.isdisjoint(OF_FRAMES)

    def trim(self, dictionary: Dictionary) -> None:
        """Take away the objects that the drive lacks, and the PDOs that would carry them."""
        for index in self.missing:
            dictionary.remove(index)
        for index in (*dictionary.indices(0x1600, 0x17FF), *dictionary.indices(0x1A00, 0x1BFF)):
            if any(entry.number >> 16 in self.missing for entry in dictionary.members(index)):
                for variable in (dictionary.find(index, 0), *dictionary.members(index)):
                    variable.start = variable.data = bytes(len(variable.data))


def _unit(name: str, increments: int) -> float | None:
    """Turns of the motor per second of one unit; `scaled` is min-1 times 512 times the resolution by 1875."""
    return {"user": None, "counts": 1 / increments, "rpm": 1 / 60, "scaled": 1875 / 512 / increments / 60}[name]


def scale_speeds(dictionary: Dictionary, unit: float | None, given: Mapping[str, object]) -> None:
    """Give the speeds of our own EDS in another unit, in turns per second, except those that are `given` by key."""
    if unit is None:
        return
    for index in SPEEDS:
        for variable in dictionary.members(index) or (dictionary.find(index, 0),):
            if variable.key not in given and isinstance(variable.type, Integer):
                number = round(variable.number / INCREMENTS_PER_TURN / unit)
                most = (1 << 8 * len(variable.data)) - 1
                variable.start = variable.data = min(number, most).to_bytes(len(variable.data), "little")
    said = dictionary.get(si_units.VELOCITY, 0)
    if said is not None and said.key not in given:
        number = si_units.RPM if unit == 1 / 60 else 0
        said.start = said.data = number.to_bytes(len(said.data), "little")


@lru_cache(maxsize=len(Name.__args__))  # type: ignore[attr-defined]
def rows_of(name: str) -> dict[str, Any]:
    """Return the keys of a personality.  Do not change them."""
    source = yaml_source.read_file(FOLDER / f"{name}.yaml")
    assert not source.mistakes, source.mistakes
    return dict(source.data)


def starts_of(name: str, own: PersonalitySettings) -> dict[str, Any]:
    """Return the power-on values of a personality, without a mode or a homing method that `own` does not have."""
    starts = dict(rows_of(name).get("objects", {}))
    for key, numbers in (("6060:00", own.modes), ("6098:00", own.homing_methods)):
        if numbers is not None and starts.get(key, 0) not in (0, *numbers):
            del starts[key]
    return starts


def personality(name: str | None, own: PersonalitySettings) -> PersonalitySettings:
    """Return the personality of this name with the keys of `own` that are given."""
    of_file = {} if name is None else rows_of(name)
    return PersonalitySettings.model_validate({**of_file, **own.model_dump(exclude_unset=True)})
