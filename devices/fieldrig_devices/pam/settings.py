"""Settings of a PAM in a rig file."""

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Final, Literal

from pydantic import Field

from fieldrig.clock import MS
from fieldrig.settings import MASTER, Claim, ConfigFile, Settings
from fieldrig.text.source_text import LONGEST, decoded
from fieldrig_devices.line_names.described import LineReader
from fieldrig_devices.pam.application_files import reader_beside
from fieldrig_devices.pam.declared_nodes import described_nodes
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.items import Program
from fieldrig_devices.pam.language.ports import PortPlan, ports_of
from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.ports.access.faces import AccessSettings
from fieldrig_devices.pam.ports.names import map_of
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.ports.rs422.names import Rs422Reader
from fieldrig_devices.pam.ports.words import MapRegisters, WordMap
from fieldrig_devices.pam.runtime.compiler import DEFAULT_CYCLE
from fieldrig_devices.pam.runtime.processor import Limits
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pamring.described import DescribedNode
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.registers.described import NamedUnit

_RING: Final = RingLimits()
_RING_TIMES: Final = ("boot", "identify", "acknowledge", "first_value")
_LIMITS: Final = Limits()
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


class ProgramReadings(Readings):
    """Passages about programs that can be read in two ways, and the speed of the processor, which the manual omits."""

    statements_per_ms: int = Field(
        default=_LIMITS.statements_per_ms, ge=1, description="statements of all programs in a millisecond of the cycle"
    )
    is_overrun_fatal: bool = Field(
        default=_LIMITS.is_overrun_fatal,
        description="true: programs that need more stop the PAM with 02..F060; false: they go on in the next cycle",
    )
    ignores_case: bool = Field(
        default=False, description="whether names of objects are the same in any case, as keywords always are"
    )


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
        match = _BASIC_CYCLE.search(decoded(self.application.read_bytes()[:LONGEST]))
        return (int(match[1]) if match else DEFAULT_CYCLE) * MS // 3

    def serves(self) -> Iterator[Claim]:
        for service in ("dualport", "s7"):
            yield Claim("tcp", "service", service, ())

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

    def program(self) -> Program | None:
        """Return the application as far as tools need it; None for one with mistakes."""
        path = self.application
        read = reader_beside(path)
        program, mistakes = checked(
            decoded(path.read_bytes()), path.name, read, ignores_case=self.programs.ignores_case
        )
        return None if any(not mistake.is_note for mistake in mistakes) else program

    def ring_objects(self) -> Mapping[int, DescribedNode]:
        program = self.program()
        return {} if program is None else described_nodes(program)

    def line_reader(self, link: str, device: str) -> LineReader | None:
        """Return a reader of the telegrams at the link `rs422`."""
        if link != "rs422":
            return None
        plans = [plan for plan in self.port_plans() if plan.kind == "RS422 PORT"]
        return Rs422Reader(device, [variable for plan in plans for variable in plan.variables])

    def port_plans(self) -> Sequence[PortPlan]:
        """Return the ports of the application; none if it has mistakes."""
        program = self.program()
        return [] if program is None else ports_of(program)

    def dual_port(self) -> WordMap | None:
        return map_of(self.port_plans(), self.ports)

    def register_names(self) -> Iterator[NamedUnit]:
        """Yield the DualPort memory, whose words are registers."""
        words = self.dual_port()
        if words is not None:
            yield NamedUnit(self.access.unit_id, MapRegisters(words))

    def limits(self) -> Limits:
        return Limits(self.programs.statements_per_ms, self.programs.is_overrun_fatal)
