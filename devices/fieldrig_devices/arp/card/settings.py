"""Settings of an ARP card in a rig file."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from fieldrig.clock import MS
from fieldrig.settings import Claim, ConfigFile, Settings, WrongKey, refuse_all
from fieldrig_devices.arp.can.exchange import ExchangeSettings
from fieldrig_devices.arp.can.face import EDS
from fieldrig_devices.arp.can.objects import GROUPS, signals
from fieldrig_devices.arp.card.local_io import DIGITAL_INPUTS, INPUTS, OUTPUTS, TERMINALS, accepts, wire_names
from fieldrig_devices.arp.fixed import SCALE, to_raw, to_text
from fieldrig_devices.arp.language.files import HIGHEST_SYSTEM
from fieldrig_devices.arp.parameters import GENERAL, GENERAL_PARAMETERS, PARAMETERS, Par, Parameter
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.slices import Costs, Slices
from fieldrig_devices.arp.user_port.names import UserPortReader
from fieldrig_devices.arp.user_port.server import UserPortSettings
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.line_names.described import LineReader

Values = dict[int, int | float]
"""Parameters of one group in engineering units, by number."""
Input = Literal["I101", "I102", "I103", "I104", "I105", "I106", "I107", "I108"]

GROUP_NAMES: Final = ("@Par", "@Par1", "@Par2")


def raw_value(group: int, number: int, value: float) -> int:
    """Raw value of a parameter.  Raises ValueError, which says what was expected, if the value is not permitted."""
    parameter = PARAMETERS[group].get(number)
    name = f"{GROUP_NAMES[group]}[{number}]"
    if parameter is None:
        raise ValueError(f"there is no {name}; expected a number from 1 to {len(PARAMETERS[group])}")
    try:
        raw = to_raw(str(value))
    except ValueError as cause:
        raise ValueError(f"{name} ({parameter.name}): {cause}; expected {allowed(parameter)}") from None
    if not parameter.takes(raw):
        raise ValueError(f"{name} ({parameter.name}) cannot be {to_text(raw)}; expected {allowed(parameter)}")
    return raw


def allowed(parameter: Parameter) -> str:
    only = [to_text(raw) for raw in parameter.only]
    whole = f"{to_text(parameter.low)} to {to_text(parameter.high)}"
    span = ", ".join(only) if 0 < len(only) <= 6 else f"a whole number from {whole}" if only else whole
    return span if parameter.unit in ("", "code") else f"{span} {parameter.unit}"


def _group(group: int) -> AfterValidator:
    def check(values: Values) -> Values:
        refuse_all(wrong(values))
        return values

    def wrong(values: Values) -> Iterator[WrongKey]:
        for number, value in values.items():
            try:
                raw_value(group, number, value)
            except ValueError as cause:
                yield WrongKey((number,), str(cause))

    return AfterValidator(check)


class ParameterSettings(Settings):
    """Initial content of the flash, in engineering units; it is applied again when these values change."""

    general: Annotated[Values, _group(0)] = Field(default_factory=dict, description="@Par[1] to [16]")
    axis1: Annotated[Values, _group(1)] = Field(default_factory=dict, description="@Par1[1] to [25]")
    axis2: Annotated[Values, _group(2)] = Field(default_factory=dict, description="@Par2[1] to [25]")

    def raw(self) -> dict[tuple[int, int], int]:
        """Raw values by group and number."""
        groups = (self.general, self.axis1, self.axis2)
        return {
            (group, number): raw_value(group, number, value)
            for group, values in enumerate(groups)
            for number, value in sorted(values.items())
        }


def _known_terminals(signals: dict[str, str]) -> dict[str, str]:
    refuse_all(_wrong_signals(signals))
    return signals


def _wrong_signals(signals: dict[str, str]) -> Iterator[WrongKey]:
    yield from _unknown(signals, TERMINALS)
    outputs: dict[str, str] = {}
    for terminal, wire in signals.items():
        if not wire:
            yield WrongKey((terminal,), f"{terminal} has no wire; expected a name, or no entry for {terminal}")
        elif terminal in OUTPUTS and (other := outputs.setdefault(wire, terminal)) != terminal:
            what = f"{other} and {terminal} both drive the wire {wire!r}; expected one output for each wire"
            yield WrongKey((terminal,), what)


def _known_inputs(inputs: dict[str, bool | int | float]) -> dict[str, bool | int | float]:
    refuse_all(_wrong_inputs(inputs))
    return inputs


def _wrong_inputs(inputs: dict[str, bool | int | float]) -> Iterator[WrongKey]:
    yield from _unknown(inputs, INPUTS)
    for name, value in inputs.items():
        if name in INPUTS and not accepts(name, value):
            expected = "true or false" if name in DIGITAL_INPUTS else "a number"
            yield WrongKey((name,), f"{name} cannot be {value!r}; expected {expected}")


def _unknown(given: Mapping[str, object], known: tuple[str, ...]) -> Iterator[WrongKey]:
    for name in given:
        if name not in known:
            yield WrongKey((name,), f"the card has no terminal {name!r} here; expected one of {', '.join(known)}")


class ArpSettings(Settings):
    number: int = Field(default=1, ge=0, le=HIGHEST_SYSTEM, description="communication address, nn in NAME.Inn")
    program: ConfigFile | None = Field(default=None, description="source or object file; loaded whenever it changes")
    parameters: ParameterSettings = Field(default_factory=ParameterSettings, description="initial content of the flash")
    inputs: Annotated[dict[str, bool | int | float], AfterValidator(_known_inputs)] = Field(
        default_factory=dict, description="values of inputs until a wire drives them: I108: true, adc1: 0.005 (V)"
    )
    signals: Annotated[dict[str, str], AfterValidator(_known_terminals)] = Field(
        default_factory=dict, description="wires other than NAME.I101 and so on, by terminal"
    )
    latch1: Input = Field(default="I101", description="latch input of axis 1; which one depends on the hardware")
    latch2: Input = Field(default="I102", description="latch input of axis 2")
    io_nodes: list[Annotated[int, Field(ge=1, le=127)] | None] = Field(
        default_factory=list, max_length=2, description="CAN node-IDs of I/O node 1 and 2; null if not fitted"
    )
    terminal: bool = Field(default=False, description="whether a TR4 or TR5 is on the CAN, with node-ID @Par[8]")
    readings: Readings = Field(
        default_factory=Readings, description="interpretations of ambiguous passages in the manual"
    )
    costs: Costs = Field(default_factory=Costs, description="processor time of loops and instructions")
    exchange: ExchangeSettings = Field(default_factory=ExchangeSettings, description="data exchange with other cards")
    user_port: UserPortSettings = Field(default_factory=UserPortSettings, description="settings of the USER port")

    @model_validator(mode="after")
    def _nodes_differ(self) -> Self:
        nodes = [self.can_node_id, *(node_id for node_id in self.io_nodes if node_id is not None)]
        nodes += [self._general(Par.TERMINAL_NODE_ID)] if self.terminal else []
        for node_id in nodes:
            if nodes.count(node_id) > 1:
                raise ValueError(
                    f"CAN node-ID {node_id} is used twice; @Par[5] (the card), @Par[8] (the terminal) and io_nodes"
                    " must differ"
                )
        return self

    @model_validator(mode="after")
    def _exchange_fits_the_node(self) -> Self:
        self.exchange.check(self.can_node_id)
        return self

    @model_validator(mode="after")
    def _costs_leave_time(self) -> Self:
        control_ms, scheduler_ms = self._general(Par.CONTROL_PERIOD_MS), self._general(Par.SCHEDULER_PERIOD_MS)
        if Slices(self.costs, control_ms * MS, scheduler_ms * MS).earned_ns <= 0:
            raise ValueError(
                f"costs: control_us and scheduler_us take all of @Par[1] ({control_ms} ms), and the program would"
                " never run; expected smaller costs"
            )
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        """Claims of the card.  `master of node-ID` is one of them, because a node answers only one master."""
        yield Claim("can", "node-ID", self.can_node_id, ("parameters", "general", int(Par.CAN_NODE_ID)))
        for index, node_id in enumerate(self.io_nodes):
            if node_id is not None:
                yield Claim("can", "master of node-ID", node_id, ("io_nodes", index))
        if self.terminal:
            node_id = self._general(Par.TERMINAL_NODE_ID)
            yield Claim("can", "master of node-ID", node_id, ("parameters", "general", int(Par.TERMINAL_NODE_ID)))
        yield Claim("user", "card number", self.number, ("number",))
        names = wire_names(device, self.signals)
        for terminal in OUTPUTS:
            yield Claim("wires", "wire", names[terminal], ("signals", terminal))

    def line_reader(self, link: str, device: str) -> LineReader | None:
        """Return a reader of the frames at the link `user`."""
        return UserPortReader() if link == "user" else None

    @property
    def needs_can(self) -> bool:
        return self.terminal or any(self.io_nodes) or bool(self.exchange.send or self.exchange.receive)

    @property
    def can_node_id(self) -> int:
        """Node-ID of the card, @Par[5], as the rig file sets it."""
        return self._general(Par.CAN_NODE_ID)

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        """Yield the node that the card is on its CAN, with its parameters and the PDOs of its exchange."""
        objects = {
            f"{GROUPS[group]:04X}:{number:02X}": raw for (group, number), raw in self.parameters.raw().items()
        } | self.exchange.objects(self.can_node_id)
        yield DescribedNode(self.can_node_id, EDS, objects, signals())

    def _general(self, number: Par) -> int:
        default = GENERAL_PARAMETERS[number].default
        return self.parameters.raw().get((GENERAL, number), default) // SCALE
