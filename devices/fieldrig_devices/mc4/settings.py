"""The keys of an MC-4 in a rig file."""

from collections.abc import Iterator
from typing import Annotated, Any, Self

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig_devices.mc4.diagnosis import Code, Language
from fieldrig_devices.mc4.faults import DriveFault
from fieldrig_devices.mc4.idns import settable
from fieldrig_devices.sercos.idn import idn_of, idn_text


class MotorSettings(Settings):
    name_plate: ConfigFile = Field(description="of the motor at the drive's cable")
    expected_type: str | None = Field(default=None, description="motor type that the machine needs; left out: any")


class LoadSettings(Settings):
    """What the motor turns."""

    model_config = ConfigDict(allow_inf_nan=False)

    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    inertia_kg_m2: float = Field(default=0.0, ge=0, description="of the load, behind the gear")
    viscous_nm_s_per_rad: float = Field(default=1e-4, ge=0, description="friction at the motor that grows with speed")
    coulomb_nm: float = Field(default=0.0, ge=0, description="dry friction at the motor")
    torque_nm: float = Field(default=0.0, description="always at the load, as of a weight; positive pulls it back")
    stiffness_nm_per_rad: float | None = Field(default=None, gt=0, description="of a coupling, at the load; else stiff")
    damping_nm_s_per_rad: float = Field(default=0.0, ge=0, description="of that coupling")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.stiffness_nm_per_rad is not None and not self.inertia_kg_m2:
            raise ValueError("stiffness_nm_per_rad needs a load: give inertia_kg_m2")
        return self


def _settable_idns(values: dict[str, int]) -> dict[str, int]:
    ranges = settable()
    for text, value in values.items():
        idn = idn_of(text)
        if idn not in ranges:
            there = ", ".join(map(idn_text, ranges))
            raise ValueError(f"{text} is no parameter that can be set: there are {there}")
        low, high = ranges[idn]
        if not low <= value <= high:
            raise ValueError(f"{text} can't be {value}: {low} to {high} would be right")
    return {idn_text(idn_of(text)): value for text, value in values.items()}


class ParameterSettings(Settings):
    """Of the drive at power-on; the controller may write others."""

    brake_disconnection_ms: int = Field(default=100, ge=0, le=65_535, description="BrakeDisconnectionTime")
    brake_coupling_ms: int = Field(default=50, ge=0, le=65_535, description="BrakeCouplingTime")
    stop_time_limit_ms: int = Field(default=1000, ge=0, le=65_535, description="StopTimeLim")
    enable_coast: bool = Field(default=False, description="CoastOption bEnableCoast")
    error_coast: bool = Field(default=False, description="CoastOption bErrorCoast")
    brake_coast: bool = Field(default=False, description="CoastOption for the brake: it drops at standstill only")
    safe_stop_coasts: bool = Field(
        default=False, description="the loss of Inverter Enable takes the torque at once; else the drive ramps down"
    )
    idns: Annotated[dict[str, int], AfterValidator(_settable_idns)] = Field(
        default_factory=dict, description="others by their IDN, raw: S-0-0104: 400"
    )


class AmplifierSettings(Settings):
    model_config = ConfigDict(allow_inf_nan=False)

    type: str = "MC-4/11/22/400"
    continuous_current_a: float = Field(default=10.0, gt=0, le=100_000, description="for 250 % of it, one second")
    mains_v: float = Field(default=400.0, ge=100, le=500)


class VersionSettings(Settings):
    firmware: str = Field(default="00.07.00", pattern=r"^\d\d\.\d\d\.\d\d$")
    hardware: str = Field(default="01.00.00", pattern=r"^\d\d\.\d\d\.\d\d$")
    article_number: str = Field(default="13130211-001", max_length=32, description="of the drive")
    serial_number: str | None = Field(default=None, max_length=32, description="left out: made of the ring address")


def _classes(classes: dict[int, int]) -> dict[int, int]:
    for code, number in classes.items():
        if code not in list(Code):
            raise ValueError(f"the drive has no diagnosis {code}: there are {', '.join(str(int(one)) for one in Code)}")
        if not 1 <= number <= 8:
            raise ValueError(f"the class of {code} must be 1 to 8")
    return classes


class Mc4Settings(Settings):
    model_config = ConfigDict(allow_inf_nan=False)

    ring_address: int = Field(ge=1, le=254, description="RealTimeBusAdr; one of its own on the ring")
    motor: MotorSettings | None = Field(
        default=None, description="left out: what the encoder at the link `encoder` says; without that no motor at all"
    )
    simulated: bool = Field(
        default=False, description="a drive without iron: it is where it is told, and never has an error"
    )
    amplifier: AmplifierSettings = Field(default_factory=AmplifierSettings)
    load: LoadSettings = Field(default_factory=LoadSettings)
    parameters: ParameterSettings = Field(default_factory=ParameterSettings)
    versions: VersionSettings = Field(default_factory=VersionSettings)
    language: Language = Field(default="de", description="of the texts of the diagnosis")
    classes: Annotated[dict[int, int], AfterValidator(_classes)] = Field(
        default_factory=dict, description="of diagnoses, by their codes, where they are not the first digit"
    )
    initial_turns: float = Field(default=0.0, ge=-2048, lt=2048, description="where the motor stands at the start")
    inverter_enable: bool = Field(default=True, description="the input Inverter Enable, until its wire is driven")
    position_tolerance: float = Field(
        default=1e-4,
        gt=0,
        description="rad: how far what was told of shaft and load may lead astray before it is told again",
    )
    inverter_enable_wire: str | None = Field(default=None, description="NAME.inverter_enable, and so on for the others")
    load_torque_wire: str | None = None
    probe_1_wire: str | None = None
    probe_2_wire: str | None = None
    ready_wire: str | None = None
    brake_wire: str | None = None
    position_wire: str | None = None
    shaft_wire: str | None = None
    faults: list[DriveFault] = Field(default=[], description="that the drive has from the start")

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("ring", "ring address", self.ring_address, ("ring_address",))
        for what in ("ready", "brake", "position", "shaft"):
            yield Claim("wires", "wire", self.wire(device, what), (f"{what}_wire",))

    def wire(self, device: str, what: str) -> str:
        own: Any = getattr(self, f"{what}_wire")
        return own or f"{device}.{what}"
