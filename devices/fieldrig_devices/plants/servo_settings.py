"""The keys of a servo axis in a rig file, and its faults."""

import math
from collections.abc import Iterator, Mapping
from math import inf
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.faults.faults import Timed, models_of
from fieldrig.settings import Claim
from fieldrig_devices.plants.axis_model import Mechanics
from fieldrig_devices.plants.settings import PlantSettings

FASTEST_RAD_PER_S2 = 1e9


class SwitchSettings(PlantSettings):
    """A proximity switch or cam at the load."""

    from_rad: float = Field(description="position of the load where it closes, going up")
    to_rad: float = Field(description="position where it opens, going up")
    every_rad: float | None = Field(
        default=None, ge=1e-3, description="period of repetition; 6.283185307179586 is a turn"
    )

    @model_validator(mode="after")
    def _is_a_range(self) -> Self:
        if not 0 < self.to_rad - self.from_rad < (self.every_rad or inf):
            raise ValueError("to_rad must be above from_rad, by less than every_rad")
        return self


class ServoSettings(PlantSettings):
    rated_torque_nm: float = Field(gt=0, description="torque of the motor at 10 V")
    current_lag_ms: float = Field(default=0.0, ge=0, le=1000, description="time constant of the current loop")
    motor_inertia_kg_m2: float = Field(gt=0)
    load_inertia_kg_m2: float = Field(default=0.0, ge=0, description="inertia of the load, behind the gear")
    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    viscous_nm_s_per_rad: float = Field(default=0.0, ge=0, description="viscous friction at the motor")
    coulomb_nm: float = Field(default=0.0, ge=0, description="dry friction at the motor")
    breakaway_nm: float | None = Field(
        default=None, ge=0, description="torque to start from standstill; default: coulomb_nm"
    )
    load_torque_nm: float = Field(
        default=0.0, description="constant torque at the load, for example of a weight; positive pulls it down"
    )
    low_stop_rad: float | None = Field(default=None, description="lower stop of the load, without rebound")
    high_stop_rad: float | None = Field(default=None, description="of the load")
    initial_position_rad: float = Field(default=0.0, description="of the load")
    brake_torque_nm: float | None = Field(
        default=None, gt=0, description="torque of a holding brake; default: no brake"
    )
    encoder_lines: int = Field(default=1000, ge=1, le=10_000_000, description="lines per turn; 4 counts each")
    encoder_at: Literal["motor", "load"] = "motor"
    encoder_reversed: bool = Field(default=False, description="counts down where the axis goes up")
    encoder_tolerance_counts: float = Field(
        default=0.25, gt=0, le=100, description="largest error of the extrapolated value before a new one is published"
    )
    switches: dict[str, SwitchSettings] = Field(default={}, description="switches by wire")
    index_wire: str | None = Field(
        default=None, description="digital: true for one count per turn of the encoder, from 0"
    )
    reference_wire: str | None = Field(default=None, description="default: NAME.reference, and so on for the others")
    load_torque_wire: str | None = None
    blocked_wire: str | None = None
    brake_wire: str | None = None
    encoder_wire: str | None = None

    @model_validator(mode="after")
    def _fits(self) -> Self:
        low, high = self.low_rad, self.high_rad
        if not low < high:
            raise ValueError("high_stop_rad must be above low_stop_rad")
        if not low <= self.initial_position_rad <= high:
            raise ValueError(f"initial_position_rad is outside the stops; expected {low} to {high}")
        fastest_nm = (self.motor_inertia_kg_m2 + self.load_inertia_kg_m2 / self.gear_ratio**2) * FASTEST_RAD_PER_S2
        if max(self.rated_torque_nm, abs(self.load_torque_nm) / self.gear_ratio) > fastest_nm:
            raise ValueError(
                f"rated_torque_nm and load_torque_nm are too large for the inertia; expected up to {fastest_nm:g} N m"
            )
        if self.breakaway_nm is not None and self.breakaway_nm < self.coulomb_nm:
            raise ValueError(f"breakaway_nm must be at least coulomb_nm: {self.coulomb_nm}")
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("wires", "wire", self.wire_for(device, "encoder"), ("encoder_wire",))
        if self.index_wire is not None:
            yield Claim("wires", "wire", self.index_wire, ("index_wire",))
        for wire in self.switches:
            yield Claim("wires", "wire", wire, ("switches", wire))

    @property
    def low_rad(self) -> float:
        return -inf if self.low_stop_rad is None else self.low_stop_rad

    @property
    def high_rad(self) -> float:
        return inf if self.high_stop_rad is None else self.high_stop_rad

    @property
    def counts_per_rad(self) -> float:
        """Counts per radian of the motor."""
        counts = 4 * self.encoder_lines / math.tau
        counts /= self.gear_ratio if self.encoder_at == "load" else 1.0
        return -counts if self.encoder_reversed else counts

    def mechanics(self, dry_nm: float = 0.0) -> Mechanics:
        """Return the mechanics at the shaft of the motor, with additional dry friction."""
        breakaway_nm = self.coulomb_nm if self.breakaway_nm is None else self.breakaway_nm
        return Mechanics(
            inertia=self.motor_inertia_kg_m2 + self.load_inertia_kg_m2 / self.gear_ratio**2,
            viscous=self.viscous_nm_s_per_rad,
            coulomb=self.coulomb_nm + dry_nm,
            breakaway=breakaway_nm + dry_nm,
            low=self.low_rad * self.gear_ratio,
            high=self.high_rad * self.gear_ratio,
            lag_s=self.current_lag_ms / 1000,
        )


class Blocked(Timed):
    """The axis is jammed: it stands, whatever the torque."""

    what: Literal["blocked"]


class EncoderSignal(Timed):
    """The encoder's signal is lost: the count stays, and the counts that are missed are lost."""

    what: Literal["encoder_signal"]


MODELS: Final[Mapping[str, type[Any]]] = models_of(Annotated[Blocked | EncoderSignal, Field(discriminator="what")])
