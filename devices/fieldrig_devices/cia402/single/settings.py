"""The keys of a single CiA 402 drive in a rig file."""

from collections.abc import Iterator
from math import inf
from typing import Annotated, Final, Self

from pydantic import ConfigDict, Field, model_validator

from fieldrig.clock import MS
from fieldrig.errors import Mistake
from fieldrig.settings import Claim, ConfigFile, Settings, WrongKey, refuse_all
from fieldrig.text.nearest import closest
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.node_settings import CanopenSettings
from fieldrig_devices.cia402 import objects as profile
from fieldrig_devices.cia402.axis_drive import MODES
from fieldrig_devices.cia402.behaviour import Behaviour
from fieldrig_devices.cia402.permitted import start_rules
from fieldrig_devices.cia402.single import foreign
from fieldrig_devices.cia402.single.faults import AnyDriveFault
from fieldrig_devices.cia402.single.oddities import oddities
from fieldrig_devices.cia402.single.own_objects import EDS
from fieldrig_devices.cia402.single.personality import Name, PersonalitySettings, personality, scale_speeds, starts_of
from fieldrig_devices.drives.load import LoadSettings
from fieldrig_devices.drives.loops import INNER_NS
from fieldrig_devices.drives.motor import MotorData

ENCODER: Final = "608F:01"
INPUTS: Final = {"negative_limit": 0, "positive_limit": 1, "home": 2, "probe_1": 16, "probe_2": 17}
"""Inputs with a name, and their bits in 60FDh."""
FIRST_FREE: Final = 18
"""Bit in 60FDh of the first of `input_wires`."""


class MotorSettings(Settings):
    """The motor, by default one of 400 W."""

    model_config = ConfigDict(allow_inf_nan=False)

    rated_torque_nm: float = Field(default=1.27, gt=0, description="what 100 % of 6071h, 6072h and 6077h are")
    peak_torque_nm: float = Field(default=3.81, gt=0, description="the most torque that motor and drive give")
    rated_speed_rpm: float = Field(default=3000.0, gt=0)
    max_speed_rpm: float = Field(default=6000.0, gt=0, description="limit for the speed of the loops")
    torque_constant_nm_per_a: float = Field(default=0.5, gt=0)
    inertia_kgcm2: float = Field(default=0.3, gt=0, description="inertia of the rotor")
    brake_torque_nm: float = Field(default=0.0, ge=0, description="torque of the holding brake; 0: it has none")
    brake_lift_ms: float = Field(default=40.0, ge=0, description="time from the command until the brake is open")
    overload_s: float = Field(
        default=3.0, gt=0, description="how long it bears the peak torque, before error 2350h (I2t)"
    )

    def data(self) -> MotorData:
        """Return what the model of the axis needs."""
        return MotorData(
            rated_speed_rpm=self.rated_speed_rpm,
            max_speed_rpm=self.max_speed_rpm,
            rated_torque_nm=self.rated_torque_nm,
            peak_torque_nm=self.peak_torque_nm,
            torque_constant_nm_per_a=self.torque_constant_nm_per_a,
            inertia_kgcm2=self.inertia_kgcm2,
            brake_torque_nm=self.brake_torque_nm,
            brake_lift_ms=self.brake_lift_ms,
        )


class LoopSettings(Settings):
    """The regulators of the drive."""

    model_config = ConfigDict(allow_inf_nan=False)

    position_gain_per_s: float = Field(default=80.0, gt=0, le=1_000)
    integral_time_ms: float = Field(default=20.0, ge=0, description="of the speed regulator; 0: no integral part")
    speed_feed_forward: float = Field(
        default=1.0, ge=0, le=1, description="1 leaves no following error at constant speed"
    )


class CamSettings(Settings):
    """The range in which a switch of the machine is closed, in rad of the load."""

    model_config = ConfigDict(allow_inf_nan=False)

    low: float = Field(description="position from which it is closed")
    high: float = Field(description="position at which it opens")
    every: float | None = Field(default=None, gt=0, description="period, such as a turn; default: none")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        most = self.low + (self.every or inf)
        if not self.low < self.high < most:
            remedy = f"expected more than low, {self.low:g}" + (f", and less than {most:g}" if self.every else "")
            refuse_all([WrongKey(("high",), f"{self.high:g} doesn't fit", remedy)])
        return self


class Cia402DriveSettings(CanopenSettings):
    model_config = ConfigDict(allow_inf_nan=False)

    eds: Annotated[
        ConfigFile,
        Field(
            default_factory=lambda: EDS,
            description="EDS or DCF file of a drive, whose objects it then has; default: all of CiA 402",
        ),
    ]
    cycle_us: int = Field(
        default=1_000, ge=250, le=10_000, multiple_of=INNER_NS // 1_000, description="cycle of the drive's set values"
    )
    encoder_increments: int | None = Field(
        default=None, ge=16, le=1 << 24, description="per turn of the motor; default: what 608Fh says, else 4096"
    )
    supply_v: float = Field(default=325.0, gt=0, le=1_000, description="voltage of the DC link (6079h)")
    motor: MotorSettings = Field(default_factory=MotorSettings)
    load: LoadSettings = Field(default_factory=lambda: LoadSettings(inertia_kg_m2=5e-5, coulomb_nm=0.02))
    loops: LoopSettings = Field(default_factory=LoopSettings)
    low_stop_rad: float | None = Field(default=None, description="lower mechanical stop of the load")
    high_stop_rad: float | None = Field(default=None, description="upper mechanical stop of the load")
    initial_position_rad: float = Field(default=0.0, description="position of the load at power-on")
    switches: dict[str, CamSettings] = Field(
        default_factory=dict,
        description="switches at the load by input: home, negative_limit, positive_limit, probe_1, probe_2",
    )
    sto: bool = Field(default=True, description="state of the STO input until its wire is driven; true permits torque")
    input_wires: list[str] = Field(default_factory=list, max_length=14, description="inputs of 60FDh from bit 18 up")
    output_wires: list[str] = Field(default_factory=list, max_length=16, description="outputs of 60FEh from bit 16 up")
    position_tolerance: float = Field(
        default=1e-4,
        gt=0,
        description="rad: largest error of the extrapolated position before a new value is published",
    )
    home_wire: str | None = Field(default=None, description="input; default: NAME.home, and so on for the others")
    negative_limit_wire: str | None = None
    positive_limit_wire: str | None = None
    probe_1_wire: str | None = None
    probe_2_wire: str | None = None
    sto_wire: str | None = None
    load_torque_wire: str | None = Field(
        default=None, description="input: torque at the load, N m; positive acts backwards"
    )
    blocked_wire: str | None = Field(default=None, description="input: true blocks the shaft")
    brake_wire: str | None = Field(default=None, description="output: true lifts the brake")
    position_wire: str | None = Field(default=None, description="output: position of the load, rad")
    personality: Name | None = Field(
        default=None, description="how the drive behaves where the standard leaves room; default: by the book"
    )
    behaviour: PersonalitySettings = Field(
        default_factory=PersonalitySettings, description="single differences beside those of the personality"
    )
    faults: list[AnyDriveFault] = Field(default=[], description="faults that the drive has from the start")

    def _wrong_machine(self) -> Iterator[WrongKey]:
        if self.boot_up_ms:
            remedy = f"write behaviour: {{boot_up_ms: {self.boot_up_ms:g}}}"
            yield WrongKey(("boot_up_ms",), "for a drive this is part of its behaviour", remedy)
        for name in self.switches:
            if name not in INPUTS:
                yield WrongKey(("switches", name), "there is no such input", closest(name, list(INPUTS)))
            elif getattr(self, f"{name}_wire") is not None:
                what = f"the input {name} has a switch, switches.{name}"
                yield WrongKey((f"{name}_wire",), what, "remove the wire or the switch")
        low, high = self.stops
        if not low < high:
            yield WrongKey(("low_stop_rad",), f"{low:g} is not below high_stop_rad", f"expected less than {high:g}")
        elif self.initial_position_rad < low:
            what = f"{self.initial_position_rad:g} is below low_stop_rad"
            yield WrongKey(("initial_position_rad",), what, f"expected at least {low:g}")
        elif self.initial_position_rad > high:
            what = f"{self.initial_position_rad:g} is above high_stop_rad"
            yield WrongKey(("initial_position_rad",), what, f"expected at most {high:g}")
        rated, peak = self.motor.rated_torque_nm, self.motor.peak_torque_nm
        if peak < rated:
            what = f"{peak:g} is less than rated_torque_nm"
            yield WrongKey(("motor", "peak_torque_nm"), what, f"expected at least {rated:g}")

    @property
    def stops(self) -> tuple[float, float]:
        """Positions of the mechanical stops, in rad of the load."""
        return (
            -inf if self.low_stop_rad is None else self.low_stop_rad,
            inf if self.high_stop_rad is None else self.high_stop_rad,
        )

    @property
    def increments(self) -> int:
        """Increments of the encoder per turn of the motor."""
        return self.declared.increments

    @property
    def declared(self) -> foreign.Declared:
        """The description of the drive by its EDS."""
        return foreign.declared(self.eds, self.encoder_increments)

    @property
    def manner(self) -> PersonalitySettings:
        """The personality, with the keys of `behaviour`."""
        return personality(self.personality, self.behaviour)

    @property
    def boot_up_ns(self) -> int:
        return round(self.manner.boot_up_ms * MS)

    def chosen_behaviour(self) -> Behaviour:
        """Return how the drive behaves where the standard leaves a choice."""
        return self.manner.behaviour(self.declared.behaviour, self.increments)

    def dictionary(self, node_id: int | None = None) -> Dictionary:
        dictionary = super().dictionary(node_id)
        self.manner.trim(dictionary)
        foreign.name_parameters(dictionary)
        if self.eds == EDS:
            scale_speeds(dictionary, self.chosen_behaviour().velocity_unit, self.objects)
        return dictionary

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        """Yield the drive with what it has at power-on.  Values that no master can write remain those of the EDS."""
        node_id = self.node_id or reader.CHECKED_AS
        described = {variable.key: variable.start for variable in reader.describe(self.eds, node_id).variables}
        changed = {
            variable.key: variable.value
            for variable in self.dictionary(node_id)
            if variable.access.is_writable and variable.start != described[variable.key]
        }
        yield DescribedNode(self.node_id, self.eds, {**changed, **self.objects}, self.signals)

    def claims(self, device: str) -> Iterator[Claim]:
        yield from super().claims(device)
        for what in ("brake", "position"):
            yield Claim("wires", "wire", self.wire_for(device, what), (f"{what}_wire",))
        for wire in self.output_wires:
            yield Claim("wires", "wire", wire, ("output_wires",))

    def _wrong(self) -> Iterator[WrongKey]:
        mistakes = list(super()._wrong())
        yield from mistakes
        if not mistakes:
            yield from self._wrong_starts()
        yield from self._wrong_machine()

    def _wrong_starts(self) -> Iterator[WrongKey]:
        """Yield the power-on values that the drive would refuse to a master."""
        behaviour, dictionary = self.chosen_behaviour(), self.dictionary()
        modes = behaviour.modes or {mode.number for mode in MODES}
        rules = start_rules(behaviour, modes)
        for key in self._start_values():
            variable = dictionary.by_key(key)
            rule = rules.get((variable.index, variable.subindex))
            if rule is not None and not rule.takes(int(variable.value)):
                yield WrongKey(
                    self._place_of(key), f"the drive has no {variable.value} here", f"expected {rule.wanted}"
                )

    def _reversed_limits(self) -> Iterator[WrongKey]:
        """Yield a software limit in `objects` that is above the other one; a drive that has both takes neither."""
        ends = [f"{profile.POSITION_LIMIT:04X}:{subindex:02X}" for subindex in (1, 2)]
        given = [key for key in self._start_values() if key.upper() in ends]
        dictionary = self.dictionary() if given else None
        if dictionary is not None and all(dictionary.get(profile.POSITION_LIMIT, subindex) for subindex in (1, 2)):
            low, high = (float(dictionary.by_key(end).value) for end in ends)
            if low > high:
                what = f"the lower software limit, {low:.0f}, is above the upper one, {high:.0f}: it has none"
                yield WrongKey(self._place_of(given[0]), what, "expected 607D:01 below 607D:02")

    def doubts(self) -> Iterator[Mistake | WrongKey]:
        yield from self._reversed_limits()
        if self.eds != EDS:
            yield from super().doubts()
            for finding in oddities(self.eds):
                yield Mistake(str(self.eds), finding.line, finding.place, finding.what, finding.remedy)

    def _start_values(self) -> dict[str, bool | int | float | str]:
        own: dict[str, bool | int | float | str] = {}
        if self.eds == EDS and self.encoder_increments is not None:
            own[ENCODER] = self.encoder_increments
        return {**own, **self._objects_of_personality(), **self.behaviour.objects, **super()._start_values()}

    def _objects_of_personality(self) -> dict[str, bool | int | float | str]:
        """Return the power-on values of the personality, as far as the file of the drive has such objects."""
        objects = {} if self.personality is None else starts_of(self.personality, self.behaviour)
        known = {variable.key for variable in reader.describe(self.eds, reader.CHECKED_AS).variables}
        return {key: value for key, value in objects.items() if key in known}

    def _place_of(self, key: str) -> tuple[str, ...]:
        if key in self.objects or key not in self.behaviour.objects:
            return super()._place_of(key)
        return "behaviour", "objects", key
