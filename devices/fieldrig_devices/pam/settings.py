"""Settings of a PAM in a rig file."""

import re
from collections.abc import Iterator
from dataclasses import fields
from datetime import datetime
from typing import Final, Literal

from pydantic import Field

from fieldrig.clock import MS
from fieldrig.settings import MASTER, Claim, ConfigFile, Settings
from fieldrig_devices.languages.source_file import LONGEST, decoded
from fieldrig_devices.pam.objects.options import Options
from fieldrig_devices.pam.ports.access.faces import AccessSettings
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.runtime.compiler import DEFAULT_CYCLE
from fieldrig_devices.pam.runtime.processor import Limits
from fieldrig_devices.pam.runtime.readings import Events, Readings, StartEvents
from fieldrig_devices.pamring.settings import RingLimits

_RING: Final = RingLimits()
_RING_TIMES: Final = ("boot", "identify", "acknowledge", "first_value")
_OBJECTS: Final = Options()
_LIMITS: Final = Limits()
_PROGRAMS: Final = Readings()
_BASIC_CYCLE: Final = re.compile(r"\bBASIC_PAM_CYCLE\s*=\s*([1-9][0-9]{0,4})", re.IGNORECASE)


class RingReadings(Settings):
    """The PAM's end of its ring; the manual gives only the free frames."""

    interface: Literal["asic", "fpga"] = Field(
        default=_RING.interface, description="optical interface: an interruption is 06..F010 (asic) or 06..F00C (fpga)"
    )
    frames_per_ms: int = Field(
        default=_RING.frames_per_ms, ge=1, le=1_000, description="free frames for set-points and orders"
    )
    nodes_per_ms: int = Field(
        default=_RING.nodes_per_ms,
        ge=1,
        le=255,
        description="peripherals for which a millisecond of the cycle has time",
    )
    reports_per_ms: int = Field(
        default=_RING.reports_per_ms, ge=1, description="reports of nodes that the PAM handles in a millisecond"
    )
    reception_fifo: int = Field(default=_RING.reception_fifo, ge=1, description="reports that may wait")
    sending_fifo: int = Field(default=_RING.sending_fifo, ge=1, description="orders that may wait for a free frame")
    boot_ms: int = Field(
        default=_RING.boot_ns // 1_000_000,
        ge=1,
        description="time after power-on until all declared nodes must be on the ring",
    )
    identify_ms: int = Field(
        default=_RING.identify_ns // 1_000_000, ge=1, description="time of a node for its ready token (06..F005)"
    )
    acknowledge_ms: int = Field(
        default=_RING.acknowledge_ns // 1_000_000,
        ge=1,
        description="time of the nodes for the next acknowledge of the start (07..F016, 07..F017)",
    )
    first_value_ms: int = Field(
        default=_RING.first_value_ns // 1_000_000,
        ge=1,
        description="time for the next first value of an input, besides its own delays (07..E021)",
    )


class ObjectReadings(Settings):
    """Passages of the manual about objects that can be read in two ways, and facts of a machine that it leaves out."""

    takes_shorter_way: bool = Field(
        default=_OBJECTS.takes_shorter_way,
        description="whether an absolute move of a periodic axis or generator takes the shorter way round",
    )
    amplifier_unwraps: bool = Field(
        default=_OBJECTS.amplifier_unwraps,
        description="whether an amplifier counts the periods of its input, so that its output has no step there",
    )
    corrector_input_sign_reversed: bool = Field(
        default=_OBJECTS.corrector_input_sign_reversed,
        description='whether CORRECTION_REFERENCE = INPUT corrects by "must be" minus "is", as OUTPUT does',
    )
    corrector_takes_both_edges: bool = Field(
        default=_OBJECTS.corrector_takes_both_edges,
        description="whether both edges of TRIGGER_INPUT are events of a corrector, or only that to true",
    )
    trigger_off_ends_correction: bool = Field(
        default=_OBJECTS.trigger_off_ends_correction,
        description="whether trigger_off brakes a running correction, or lets it complete",
    )
    run_is_ready_at_speed: bool = Field(
        default=_OBJECTS.run_is_ready_at_speed,
        description="whether axes and generators are ready when a run has reached its speed, or only when it has ended",
    )
    pmp_supersedes: bool = Field(
        default=_OBJECTS.pmp_supersedes,
        description="whether a command to a moving PMP generator replaces the motion, which stops first, or is ignored",
    )
    power_on_sets_initial_position: bool = Field(
        default=_OBJECTS.power_on_sets_initial_position,
        description="whether power_on sets the position to INITIAL_POSITION, or to 0",
    )
    st1_nodes_have_errors: bool = Field(
        default=_OBJECTS.st1_nodes_have_errors,
        description="whether error and error_code of an ST1 node are those of its axis, or always false and 0",
    )
    profiles_act_at_once: bool = Field(
        default=_OBJECTS.profiles_act_at_once,
        description="whether a written parameter of a PROFILE acts at once, or when PROFILE of the cam is written",
    )
    lowest_address_is_highest_bit: bool = Field(
        default=_OBJECTS.lowest_address_is_highest_bit,
        description="whether the lowest address of a digital input or output is its highest bit, or its lowest",
    )
    set_point_delay_periods: float = Field(
        default=_OBJECTS.set_point_delay_periods,
        ge=0,
        description="periods of a pipe until a node is at a set-point, which ANTI_DELAY makes up for",
    )
    report_delay_cycles: float = Field(
        default=_OBJECTS.report_delay_cycles, ge=0, description="cycles until the PAM has the report of an input"
    )
    blocks_per_ms: int = Field(
        default=_OBJECTS.blocks_per_ms,
        ge=1,
        description="blocks of pipes for which a millisecond of the cycle has time; more stop the PAM with 02..F060",
    )
    read_cycles: int = Field(
        default=_OBJECTS.read_cycles, ge=1, description="cycles that a read over the ring takes at least"
    )
    read_timeout_cycles: int = Field(
        default=_OBJECTS.read_timeout_cycles, ge=1, description="cycles after which a read is given up with 07..E021"
    )
    largest_torque_nm: float = Field(
        default=_OBJECTS.largest_torque_nm, gt=0, description="torque of a motor at the largest torque limit, in Nm"
    )


class ProgramReadings(Settings):
    """Passages about programs that can be read in two ways, and the speed of the processor, which the manual omits."""

    statements_per_ms: int = Field(
        default=_LIMITS.statements_per_ms, ge=1, description="statements of all programs in a millisecond of the cycle"
    )
    is_overrun_fatal: bool = Field(
        default=_LIMITS.is_overrun_fatal,
        description="true: programs that need more stop the PAM with 02..F060; false: they go on in the next cycle",
    )
    events: Events = Field(
        default=_PROGRAMS.events,
        description="what ON_EVENT sees of events between two of its cycles: one (remembered), each of them (counted), "
        "or none (sampled)",
    )
    events_at_start: StartEvents = Field(
        default=_PROGRAMS.events_at_start,
        description="events of ON_EVENT before the POWERON parts have finished: those that occur then count (changes), "
        "all that are true then (all), or none (none)",
    )
    common_variables_cause_events: bool = Field(
        default=_PROGRAMS.common_variables_cause_events,
        description="whether ON_EVENT and EXCEPTION see a change of a COMMON variable",
    )
    exceptions_wake: bool = Field(
        default=_PROGRAMS.exceptions_wake,
        description="whether an exception ends the wait of a suspended sequence, or comes when the wait is over",
    )
    math_error_is_fatal: bool = Field(
        default=_PROGRAMS.math_error_is_fatal,
        description="true: an error of a function or of ^ is 02..FFF3; false: its result is 0.0 outside the domain, "
        "and the largest real beyond the range",
    )
    checks_workspaces: bool = Field(
        default=_PROGRAMS.checks_workspaces,
        description="whether stack control is enabled, so that a workspace that is too small stops the PAM",
    )
    ignores_case: bool = Field(
        default=False, description="whether names of objects are the same in any case, as keywords always are"
    )


def _names(options: type[Limits | Readings]) -> set[str]:
    return {field.name for field in fields(options)}


class PamSettings(Settings):
    """Settings of a PAM."""

    application: ConfigFile = Field(description="source of the application; its includes and cams are beside it")
    date: datetime = Field(
        default=datetime(1995, 10, 15),  # noqa: DTZ001 - the PAM knows no time zone
        strict=False,
        description="date and time of the PAM's clock when the rig starts, such as 1995-10-15 14:30:45",
    )
    analog_wires: list[str] = Field(
        default=[],
        max_length=2,
        description='wires of the analog outputs 0 and 1 on the front, 0 to 2.5 V; "" is an output without a wire',
    )
    ring: RingReadings = Field(default_factory=RingReadings, description="the PAM's end of its ring")
    objects: ObjectReadings = Field(default_factory=ObjectReadings, description="readings of the manual about objects")
    programs: ProgramReadings = Field(
        default_factory=ProgramReadings, description="readings of the manual about programs, and the processor's speed"
    )
    ports: PortOptions = Field(default_factory=PortOptions, description="readings of the manual about ports to a PLC")
    access: AccessSettings = Field(
        default_factory=AccessSettings, description="Modbus, S7 and TCP servers for the memory of the DualPort"
    )

    def cycle_ns(self) -> int:
        """Return the basic cycle in the text of the application, without its includes."""
        found = _BASIC_CYCLE.search(decoded(self.application.read_bytes()[:LONGEST]))
        return (int(found[1]) if found else DEFAULT_CYCLE) * MS // 3

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("ring", MASTER, "of the ring", ())
        yield Claim("modbus", "unit", self.access.unit_id, ("access", "unit_id"))
        for address, wire in enumerate(self.analog_wires):
            if wire:
                yield Claim("wires", "wire", wire, ("analog_wires", address))

    def ring_settings(self, thirds: int) -> RingLimits:
        """Return the settings of the ring for a basic cycle of this many thirds of a millisecond."""
        ring = self.ring.model_dump()
        times = {f"{name}_ns": ring.pop(f"{name}_ms") * 1_000_000 for name in _RING_TIMES}
        return RingLimits(thirds=thirds, **ring, **times)

    def options(self) -> Options:
        return Options(**self.objects.model_dump())

    def limits(self) -> Limits:
        return Limits(**self.programs.model_dump(include=_names(Limits)))

    def readings(self) -> Readings:
        return Readings(**self.programs.model_dump(include=_names(Readings)))
