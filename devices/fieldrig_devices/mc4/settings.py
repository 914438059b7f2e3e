"""The keys of an MC-4 in a rig file."""

from collections.abc import Iterable, Iterator
from typing import Annotated

from pydantic import AfterValidator, ConfigDict, Field

from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig_devices.drives.load import LoadSettings
from fieldrig_devices.mc4.diagnosis import Code, Language
from fieldrig_devices.mc4.faults import DriveFault
from fieldrig_devices.mc4.idns import idn_table, settable
from fieldrig_devices.sercos.communication import Communication
from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import idn_of, idn_text


class MotorSettings(Settings):
    """The motor at the drive."""

    name_plate: ConfigFile = Field(description="name plate of the connected motor")
    expected_type: str | None = Field(default=None, description="motor type that the machine needs; default: any")


def _settable_idns(values: dict[str, int]) -> dict[str, int]:
    ranges = settable()
    for text, value in values.items():
        idn = idn_of(text)
        if idn not in ranges:
            names = ", ".join(map(idn_text, ranges))
            raise ValueError(f"{text} is not a parameter that can be set; expected one of {names}")
        low, high = ranges[idn]
        if not low <= value <= high:
            raise ValueError(f"{text} cannot be {value}; expected {low} to {high}")
    return {idn_text(idn_of(text)): value for text, value in values.items()}


class ParameterSettings(Settings):
    """Parameters of the drive at power-on; the controller may write other values."""

    brake_disconnection_ms: int = Field(default=100, ge=0, le=65_535, description="BrakeDisconnectionTime")
    brake_coupling_ms: int = Field(default=50, ge=0, le=65_535, description="BrakeCouplingTime")
    stop_time_limit_ms: int = Field(default=1000, ge=0, le=65_535, description="StopTimeLim")
    enable_coast: bool = Field(default=False, description="CoastOption bEnableCoast")
    error_coast: bool = Field(default=False, description="CoastOption bErrorCoast")
    brake_coast: bool = Field(default=False, description="CoastOption for the brake: it drops only at standstill")
    safe_stop_coasts: bool = Field(
        default=False,
        description="losing Inverter Enable switches the torque off at once; otherwise the drive ramps down",
    )
    idns: Annotated[dict[str, int], AfterValidator(_settable_idns)] = Field(
        default_factory=dict, description="other parameters by IDN, as raw values: S-0-0104: 400"
    )


class AmplifierSettings(Settings):
    """The amplifier of the drive."""

    model_config = ConfigDict(allow_inf_nan=False)

    type: str = "MC-4/11/22/400"
    continuous_current_a: float = Field(
        default=10.0, gt=0, le=100_000, description="continuous current; 250 % of it is available for one second"
    )
    mains_v: float = Field(default=400.0, ge=100, le=500)


class VersionSettings(Settings):
    """The versions and numbers that the drive shows."""

    firmware: str = Field(default="00.07.00", pattern=r"^\d\d\.\d\d\.\d\d$", examples=["00.07.00"])
    hardware: str = Field(default="01.00.00", pattern=r"^\d\d\.\d\d\.\d\d$", examples=["01.00.00"])
    article_number: str = Field(default="13130211-001", max_length=32, description="article number of the drive")
    serial_number: str | None = Field(
        default=None, max_length=32, description="serial number of the drive; default: made from the ring address"
    )


def _classes(classes: dict[int, int]) -> dict[int, int]:
    for code, number in classes.items():
        if code not in list(Code):
            raise ValueError(
                f"the drive has no diagnosis {code}; expected one of {', '.join(str(int(known)) for known in Code)}"
            )
        if not 1 <= number <= 8:
            raise ValueError(f"the class of {code} cannot be {number}; expected 1 to 8")
    return classes


class Mc4Settings(Settings):
    """The keys of a drive."""

    model_config = ConfigDict(allow_inf_nan=False)

    ring_address: int = Field(ge=1, le=254, description="RealTimeBusAdr; unique on the ring")
    motor: MotorSettings | None = Field(
        default=None, description="the motor; default: the one whose encoder is at the link `encoder`"
    )
    simulated: bool = Field(
        default=False, description="a simulated drive: its position is the set position, and it never has an error"
    )
    amplifier: AmplifierSettings = Field(default_factory=AmplifierSettings)
    load: LoadSettings = Field(default_factory=LoadSettings)
    parameters: ParameterSettings = Field(default_factory=ParameterSettings)
    versions: VersionSettings = Field(default_factory=VersionSettings)
    language: Language = Field(default="en", description="language of the diagnosis texts")
    classes: Annotated[dict[int, int], AfterValidator(_classes)] = Field(
        default_factory=dict, description="classes of diagnoses by code, where they differ from the first digit"
    )
    initial_turns: float = Field(default=0.0, ge=-2048, lt=2048, description="position of the motor at the start")
    inverter_enable: bool = Field(
        default=True, description="state of the input Inverter Enable until its wire is driven"
    )
    position_tolerance: float = Field(
        default=1e-4,
        gt=0,
        description="rad: largest error of the extrapolated position before a new value is published",
    )
    inverter_enable_wire: str | None = Field(
        default=None, description="default: NAME.inverter_enable, and so on for the others"
    )
    load_torque_wire: str | None = None
    probe_1_wire: str | None = None
    probe_2_wire: str | None = None
    ready_wire: str | None = None
    brake_wire: str | None = None
    position_wire: str | None = None
    shaft_wire: str | None = None
    faults: list[DriveFault] = Field(default=[], description="faults that the drive has from the start")

    def operation_data(self) -> Iterable[Datum]:
        table = idn_table()
        Communication(table, lambda: 0, lambda _phase, _command: None, lambda _is_good: None)  # it adds its own
        return table

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("ring", "ring address", self.ring_address, ("ring_address",))
        for what in ("ready", "brake", "position", "shaft"):
            yield Claim("wires", "wire", self.wire_for(device, what), (f"{what}_wire",))
