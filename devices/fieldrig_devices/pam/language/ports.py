"""The ports of a checked application as plain numbers (sections 11.8, 12.5 and 13.1 of the digest)."""

from binascii import crc_hqx
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from fieldrig_devices.pam.language.functions import VALUES, Type
from fieldrig_devices.pam.language.items import Application, Declaration, Program
from fieldrig_devices.pam.language.objects import PORTS
from fieldrig_devices.pam.language.tree import Number, Reference

Class = Literal["FLAG_VAR", "WORD_VAR", "LONG_VAR", "REAL_VAR"]

PERIODS: Final = (1, 5, 10, 20, 50)
"""Periods of ports, in basic cycles."""
ALL_ITEMS: Final = 0xFFFF
"""The item index -1, which means each item of a variable."""
_CLASSES: Final[tuple[Class, ...]] = ("FLAG_VAR", "WORD_VAR", "LONG_VAR", "REAL_VAR")
_INPUTS: Final = ("INPUT", "DUALPORT_IN")


@dataclass(frozen=True, slots=True)
class PortVariable:
    """A variable that a port exchanges with its master."""

    name: str
    kind: Class
    is_input: bool
    compiler_id: int = 0
    """Number of the variable in its class and direction, from 0, in the order of the text."""
    number: int = 1
    """Number of items."""
    is_multiple: bool = False
    group: str = ""
    """The NODES_GROUP whose components must be active; empty without one."""
    period: int = 1
    """Basic cycles from update to update."""
    period_ms: int = 1
    address: int = 0
    """Byte address in a Simatic DualPort."""
    bit: int = 0
    reserved: int = 1
    """Items that a Simatic DualPort has room for."""
    given_crc: int | None = None
    """The CRC of another compiler, if a master uses that."""

    @property
    def crc(self) -> int:
        return crc_of(self.name) if self.given_crc is None else self.given_crc

    @property
    def type(self) -> Type:
        return VALUES[self.kind]


@dataclass(frozen=True, slots=True)
class PortPlan:
    """A port with its variables."""

    declaration: Declaration
    variables: tuple[PortVariable, ...]

    @property
    def kind(self) -> str:
        """VME DUALPORT, DUAL_PORT or RS422 PORT."""
        return self.declaration.kind

    def numbers(self, name: str) -> Sequence[int]:
        """Return the values of a parameter; none for NONE."""
        return numbers_of(self.declaration, name)

    def timeout_ms(self, name: str) -> int | None:
        """Return a time-out in milliseconds, None for NONE."""
        times = self.numbers(name)
        return times[0] if times else None

    @property
    def inputs(self) -> Sequence[PortVariable]:
        return [variable for variable in self.variables if variable.is_input]

    @property
    def outputs(self) -> Sequence[PortVariable]:
        return [variable for variable in self.variables if not variable.is_input]


def crc_of(name: str) -> int:
    """Return the CRC that stands for a variable on the wire: CRC-16/CCITT-FALSE of the name in capitals.

    The manual gives no algorithm; masters take the numbers from PAM_VME.H.
    """
    return crc_hqx(name.upper().encode(), 0xFFFF)


def period_of(duration_ms: float, thirds: int) -> int:
    """Return a period in basic cycles: rounded up to 1, 5, 10, 20 or 50, which is the longest (PAMS-085)."""
    return next((period for period in PERIODS if period * thirds >= duration_ms * 3), PERIODS[-1])


def numbers_of(declaration: Declaration, name: str) -> Sequence[int]:
    """Return the whole numbers that a parameter has; none if it is missing."""
    for parameter in declaration.parameters:
        if parameter.name == name:
            return [int(value.value) for value in parameter.values if isinstance(value, Number)]
    return ()


def ports_of(program: Program) -> list[PortPlan]:
    """Return the ports of an application, in the order of its text."""
    declarations = [item for item in program.items if isinstance(item, Declaration)]
    groups = {
        item.name: number
        for item in declarations
        if item.kind == "NODES_GROUP"
        for number in numbers_of(item, "NUMBER")
    }
    thirds = next(_thirds(program), 3)
    plans = []
    for item in declarations:
        if item.kind == "DUAL_PORT":
            owned = [other for other in declarations if other.kind.startswith(("DUALPORT_IN", "DUALPORT_OUT"))]
            plans.append(PortPlan(item, tuple(_variables(owned, item, "PERIOD", groups, thirds))))
        elif item.kind in PORTS:
            default = "DEFAULT_PERIOD" if item.kind == "VME DUALPORT" else "PERIOD"
            plans.append(PortPlan(item, tuple(_variables(item.parts, item, default, groups, thirds))))
    return plans


def _thirds(program: Program) -> Iterator[int]:
    for item in program.items:
        if isinstance(item, Application):
            for parameter in item.parameters:
                if parameter.name == "BASIC_PAM_CYCLE" and isinstance(number := parameter.values[0], Number):
                    yield int(number.value)


def _variables(
    declarations: Sequence[Declaration], port: Declaration, default: str, groups: Mapping[str, int], thirds: int
) -> Iterator[PortVariable]:
    default_period = next(iter(numbers_of(port, default)), 1)
    counts: dict[str, int] = {}
    for item in declarations:
        direction, _, word = item.kind.removeprefix("VME ").removeprefix("RS422 ").partition(" ")
        group = _group(item)
        number = groups.get(group, 1) if group else next(iter(numbers_of(item, "NUMBER")), 1)
        own_ms = next(iter(numbers_of(item, "PERIOD")), None)
        period = default_period if own_ms is None else period_of(own_ms, thirds)
        address, bit = (*numbers_of(item, "ADDRESS"), 0, 0)[:2]
        counts[item.kind] = counts.get(item.kind, -1) + 1
        yield PortVariable(
            item.name,
            next(known for known in _CLASSES if known == word),
            direction in _INPUTS,
            counts[item.kind],
            number,
            bool(group) or number > 1,  # manual line 10680
            group,
            period,
            max(1, period * thirds // 3),
            address,
            bit,
            next(iter(numbers_of(item, "RESERVED")), number),
        )


def _group(item: Declaration) -> str:
    for parameter in item.parameters:
        if parameter.name == "NODES_GROUP" and isinstance(group := parameter.values[0], Reference):
            return group.name
    return ""
