"""The configuration objects of a controller for the debugging service: their parameters by name, `PacDriveM.Timer1`.

Source: PacDrive manual 3763-3765 (digest PD-223): parameters and variables are observed online.  A parameter in a drive
has the value that was read last.
"""

from typing import NamedTuple

from fieldrig.device import Value
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.types import ObjectParameter
from fieldrig_devices.iec.values import checked
from fieldrig_devices.languages.debugging.debuggee import Variable


class NamedParameter(NamedTuple):
    """A parameter of an object."""

    owner: ConfiguredObject
    parameter: ObjectParameter

    @property
    def path(self) -> str:
        return f"{self.owner.name}.{self.parameter.name}"

    @property
    def address(self) -> int:
        return self.owner.address + self.parameter.number

    @property
    def symbol(self) -> Symbol:
        """The parameter as a variable, for checks of values."""
        return Symbol(self.path, self.parameter.name, self.parameter.type)


def find(host: Host, path: str) -> NamedParameter | None:
    """Find a parameter by its path; None if there is none."""
    name, _, rest = path.strip().partition(".")
    owner = host.objects.get(name.casefold())
    parameter = None if owner is None else owner.type.parameter(rest)
    return None if owner is None or parameter is None else NamedParameter(owner, parameter)


def inside(host: Host, path: str) -> list[Variable] | None:
    """The parameters of an object; None if the path is not an object."""
    owner = host.objects.get(path.strip().casefold())
    if owner is None:
        return None
    return [shown(host, NamedParameter(owner, parameter)) for parameter in owner.type.parameters]


def group(host: Host, path: str) -> Variable | None:
    """An object as a group of values; None if the path is not an object."""
    owner = host.objects.get(path.strip().casefold())
    return None if owner is None else Variable(owner.name, owner.name, str(owner.type))


def shown(host: Host, named: NamedParameter) -> Variable:
    parameter = named.parameter
    about = "as it was read last" if parameter.is_slow else ""
    try:
        value: Value | None = host.read(named.address)
    except KeyError:  # another object of the same type has it
        value, about = None, "this object does not have it"
    return Variable(named.path, parameter.name, str(parameter.type), value, parameter.is_writable, about=about)


def write(host: Host, named: NamedParameter, value: Value) -> None:
    """Write a parameter.  ValueError if it is read-only or cannot have the value."""
    if not named.parameter.is_writable:
        raise ValueError(f"{named.path} is read-only: expected a parameter that can be written")
    fitting = checked(value, named.symbol)
    if named.parameter.is_slow:
        host.write_slowly(named.address, fitting)
    else:
        host.write(named.address, fitting)
