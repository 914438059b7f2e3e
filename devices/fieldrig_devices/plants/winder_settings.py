"""The keys of a winder in a rig file, and its faults."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.faults.faults import Timed, models_of
from fieldrig.settings import Claim
from fieldrig_devices.plants.settings import PlantSettings


class LoadCell(PlantSettings):
    """A measuring roller in the web: a bridge that gives sensitivity times excitation at its rated force."""

    rated_force_n: float = Field(gt=0)
    sensitivity_mv_per_v: float = Field(default=2.0, gt=0, description="at the rated force")
    excitation_v: float = Field(default=10.0, gt=0)
    force_per_tension: float = Field(
        default=2.0, gt=0, le=2, description="force per tension, by the wrap of the web; 2 is half a turn"
    )
    tare_n: float = Field(default=0.0, description="force without web, the weight of the roller")
    resolution_v: float = Field(default=1e-6, ge=0, description="smallest change that is published")
    wire: str | None = None

    def volt(self, tension_n: float) -> float:
        """Return the output, which saturates at 1.5 times the rated force."""
        share = (tension_n * self.force_per_tension + self.tare_n) / self.rated_force_n
        return min(max(share, -1.5), 1.5) * self.sensitivity_mv_per_v * self.excitation_v / 1000


class Dancer(PlantSettings):
    """A roller in a loop of web that a force draws out, against the tension."""

    mass_kg: float = Field(gt=0)
    force_n: float = Field(gt=0, description="force of the cylinder or weight that extends the loop")
    travel_m: float = Field(gt=0)
    spring_n_per_m: float = Field(default=0.0, ge=0, description="against force_n, from 0")
    damping_n_s_per_m: float = Field(default=0.0, ge=0)
    strands: int = Field(default=2, ge=1, description="number of strands of web that pull at it")
    initial_m: float = Field(default=0.0, ge=0, description="position at the start; 0 is the shortest loop")
    resolution_v: float = Field(default=0.001, ge=0, description="smallest change that is published")
    wire: str | None = None

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.initial_m > self.travel_m:
            raise ValueError(f"initial_m is too large; expected 0 to {self.travel_m} (travel_m)")
        return self

    def volt(self, position_m: float) -> float:
        return 20.0 * position_m / self.travel_m - 10.0


class WinderSettings(PlantSettings):
    role: Literal["unwinder", "rewinder"]
    core_radius_m: float = Field(gt=0)
    initial_radius_m: float = Field(gt=0, description="of the roll")
    core_inertia_kg_m2: float = Field(gt=0, description="of the core, the shaft and the drive")
    thickness_m: float = Field(gt=0, le=0.1, description="of the web")
    width_m: float = Field(gt=0, description="of the web")
    density_kg_m3: float = Field(default=1000.0, ge=0, description="of the web")
    modulus_pa: float = Field(default=2e9, gt=0, description="Young's modulus of the web")
    damping_s: float = Field(default=0.002, ge=0, description="of the web: its viscosity over its modulus")
    breaking_tension_n: float | None = Field(default=None, gt=0, description="where the web breaks")
    span_m: float = Field(default=2.0, gt=0, description="of web between the roll and the line, with the dancer at 0")
    initial_tension_n: float = Field(default=0.0, ge=0)
    viscous_nm_s_per_rad: float = Field(default=0.0, ge=0, description="viscous friction of the roll")
    coulomb_nm: float = Field(default=0.0, ge=0, description="dry friction of the roll")
    drive: Literal["motor", "brake"] = Field(default="motor", description="a brake only acts against the rotation")
    torque_nm_at_10_v: float = Field(gt=0, description="of the drive, at the roll; positive pulls the web tight")
    load_cell: LoadCell | None = None
    dancer: Dancer | None = None
    line_m_per_count: float | None = Field(
        default=None, description="if set, line_wire is an encoder; otherwise a speed in m/s"
    )
    encoder_lines: int = Field(
        default=1000, ge=1, le=10_000_000, description="lines per turn of the roll; 4 counts each"
    )
    encoder_tolerance_counts: float = Field(
        default=0.25, gt=0, le=100, description="largest error of the extrapolated value before a new one is published"
    )
    step_us: int = Field(default=1000, ge=10, le=10_000, description="step of the integration")
    line_wire: str = "line.speed"
    reference_wire: str | None = Field(default=None, description="default: NAME.reference, and so on for the others")
    encoder_wire: str | None = None
    web_wire: str | None = None

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.initial_radius_m < self.core_radius_m:
            raise ValueError(f"initial_radius_m is too small; expected at least {self.core_radius_m} (core_radius_m)")
        if self.initial_tension_n >= self.stiffness_n:
            raise ValueError(
                f"initial_tension_n is too large; expected below {self.stiffness_n} N (modulus times cross-section)"
            )
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("wires", "wire", self.wire_for(device, "encoder"), ("encoder_wire",))
        yield Claim("wires", "wire", self.wire_for(device, "web"), ("web_wire",))
        for what, measure in (("load_cell", self.load_cell), ("dancer", self.dancer)):
            if measure is not None:
                yield Claim("wires", "wire", measure.wire or f"{device}.{what}", (what, "wire"))

    @property
    def stiffness_n(self) -> float:
        """Tension at a strain of 1."""
        return self.modulus_pa * self.thickness_m * self.width_m

    @property
    def counts_per_rad(self) -> float:
        return 4 * self.encoder_lines / math.tau

    def length_m(self, radius_m: float) -> float:
        """Return the length of web on a roll: the area of its face divided by the thickness."""
        return math.pi * (radius_m**2 - self.core_radius_m**2) / self.thickness_m

    def inertia_kg_m2(self, radius_m: float) -> float:
        """Return the inertia of the core and a hollow cylinder of web."""
        outer, inner = radius_m * radius_m, self.core_radius_m * self.core_radius_m
        hollow = math.pi / 2 * self.density_kg_m3 * self.width_m * (outer * outer - inner * inner)
        return self.core_inertia_kg_m2 + hollow


class Torn(Timed):
    """The web is torn, and a new one is threaded when the fault ends."""

    what: Literal["torn"]


class Slip(Timed):
    """The web slips in the line, which draws less of it than it turns."""

    what: Literal["slip"]
    percent: float = Field(default=50.0, gt=0, le=100, description="share of the line's way that draws no web")


MODELS: Final[Mapping[str, type[Any]]] = models_of(Annotated[Torn | Slip, Field(discriminator="what")])
