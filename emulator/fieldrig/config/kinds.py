"""Find the kinds of buses and devices by name, with their settings and links.

A kind is a name that an installed package has under the entry points "fieldrig.buses" or "fieldrig.devices", or
`package.module:Class`, a class of the user's own.  Only the kinds that a rig file names are imported.
"""

import importlib
import inspect
import types
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, NamedTuple, Union, get_args, get_origin

from fieldrig.bus import Bus, Time
from fieldrig.device import Device
from fieldrig.errors import RigError
from fieldrig.link import Link

if TYPE_CHECKING:
    from fieldrig.settings import Settings

BUSES = "fieldrig.buses"
DEVICES = "fieldrig.devices"

INJECTED = frozenset({"clock", "name", "settings", "store", "random", "background"})
"""The parameters of a device that are not links."""


class Kind(NamedTuple):
    name: str
    about: str


@dataclass(frozen=True, slots=True)
class LinkParameter:
    """A parameter of a device's constructor that takes a link, or several."""

    name: str
    required: bool
    many: bool
    messages: tuple[type, ...]
    """The types of message that the device sends and understands; empty for any."""

    def fits(self, carried: tuple[type, ...]) -> bool:
        """Return whether a bus with these types carries everything that the device may send."""
        return all(issubclass(message, carried) for message in self.messages)


def find_bus(kind: str) -> type[Bus[Any]]:
    """Return the class of a bus.  RigError, with the closest names, for an unknown kind."""
    bus_class: type[Bus[Any]] = _find(kind, BUSES, Bus)
    return bus_class


def find_device(kind: str) -> type[Device]:
    """Return the class of a device.  RigError, with the closest names, for an unknown kind."""
    device_class: type[Device] = _find(kind, DEVICES, Device)
    return device_class


def list_buses() -> list[Kind]:
    return list(_listed(BUSES, Bus))


def list_devices() -> list[Kind]:
    return list(_listed(DEVICES, Device))


def bus_kinds_for(time: Time, family: str) -> list[str]:
    """Return the installed kinds of a family of buses that run with this time."""
    return [name for name in installed(BUSES) if _is_for(name, time, family)]


@cache
def installed(group: str) -> dict[str, EntryPoint]:
    """Return the kinds of one group by name, without importing them."""
    return {point.name: point for point in sorted(entry_points(group=group), key=lambda point: point.name)}


def bus_kinds_of(parameter: LinkParameter) -> str:
    """Return the installed kinds of buses that a link may go to, in words.

    A link for messages of a user's own names their classes, as no installed bus carries them.
    """
    if not parameter.messages:
        return "any"
    fitting = [name for name in installed(BUSES) if _carries(name, parameter)]
    return " or ".join(fitting or [f"your own for {message.__name__}" for message in parameter.messages])


def _carries(kind: str, parameter: LinkParameter) -> bool:
    try:
        return parameter.fits(find_bus(kind).messages)
    except RigError:  # its package is damaged
        return False


def settings_model(cls: type) -> "type[Settings]":
    """Return the model in the annotation of the parameter `settings`, or an empty model without that parameter."""
    from fieldrig.settings import Settings  # pydantic is a third of the time of a command that needs no kind

    parameter = constructor_parameters(cls).get("settings")
    model = parameter.annotation if parameter is not None else None
    return model if isinstance(model, type) and issubclass(model, Settings) else Settings


def link_parameters(cls: type[Device]) -> dict[str, LinkParameter]:
    """Return the links of a device, in the order of its constructor."""
    return {
        name: _link_parameter(cls, parameter)
        for name, parameter in constructor_parameters(cls).items()
        if name not in INJECTED
    }


def constructor_parameters(cls: type) -> dict[str, inspect.Parameter]:
    """Return the named parameters of the constructor, with their annotations evaluated."""
    try:
        parameters = inspect.signature(cls, eval_str=True).parameters
    except NameError as cause:
        raise RigError(f"the constructor of {_path(cls)} cannot be read: {cause}", "import what it names") from cause
    variadic = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return {name: parameter for name, parameter in parameters.items() if parameter.kind not in variadic}


def _find(kind: str, group: str, base: type[Any]) -> Any:
    if ":" in kind:
        return _of_class(kind, _import(kind, "the module must lie beside the rig file or be installed"), base)
    point = installed(group).get(kind)
    if point is None:
        raise RigError(f'there is no kind "{kind}"', _closest(kind, list(installed(group))))
    return _of_class(kind, _import(point.value, "its package is damaged, or needs one that is not there"), base)


def _closest(kind: str, names: list[str]) -> str:
    close = get_close_matches(kind, names, n=3, cutoff=0.5)
    own = 'or "module:Class" for one of your own'
    return f"did you mean {' or '.join(close)}?" if close else f"there are: {', '.join(names)}; {own}"


def _import(reference: str, remedy: str) -> object:
    """Import the class that `package.module:Class` names."""
    module_name, _, class_name = reference.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), class_name)):
        raise RigError(f'"{reference}" is not a class', 'expected "package.module:Class"')
    try:
        module = importlib.import_module(module_name)
    except (ImportError, SyntaxError) as cause:
        raise RigError(f"{module_name} cannot be imported: {cause}", remedy) from cause
    if not hasattr(module, class_name):
        classes = [name for name, value in vars(module).items() if isinstance(value, type)]
        close = get_close_matches(class_name, classes, n=1)
        raise RigError(f"{module_name} has no {class_name}", f"did you mean {close[0]}?" if close else "")
    return getattr(module, class_name)


def _of_class(kind: str, candidate: object, base: type[Any]) -> Any:
    if not isinstance(candidate, type) or not issubclass(candidate, base):
        raise RigError(f'"{kind}" is not a {base.__name__.lower()}', f"it must be a subclass of {_path(base)}")
    if missing := sorted(getattr(candidate, "__abstractmethods__", ())):
        raise RigError(f"{candidate.__name__} lacks {', '.join(missing)}", f"implement them as {_path(base)} describes")
    return candidate


def _is_for(name: str, time: Time, family: str) -> bool:
    try:
        cls = find_bus(name)
    except RigError:  # an optional library is missing
        return False
    return cls.family == family and time in cls.times


def _path(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"


def _listed(group: str, base: type[Any]) -> Iterator[Kind]:
    for name in installed(group):
        try:
            yield Kind(name, _find(name, group, base).about)
        except RigError as broken:
            yield Kind(name, f"({broken.what})")


def _link_parameter(cls: type, parameter: inspect.Parameter) -> LinkParameter:
    hint = parameter.annotation
    choices = [choice for choice in _union(hint) if choice is not type(None)]
    is_optional = parameter.default is not inspect.Parameter.empty or len(choices) < len(_union(hint))
    hint = choices[0] if len(choices) == 1 else None
    is_many = get_origin(hint) is list
    if is_many:
        (hint,) = get_args(hint)
    if hint is not Link and get_origin(hint) is not Link:
        known = ", ".join(sorted(INJECTED))
        raise RigError(
            f"the parameter {parameter.name} of {_path(cls)} is not a link",
            f"expected a Link[...] or one of {known}",
        )
    return LinkParameter(parameter.name, not is_optional, is_many, _messages(get_args(hint)))


def _messages(arguments: tuple[Any, ...]) -> tuple[type, ...]:
    """Return the classes in `Link[A | B]`; none for `Link[Any]` and a bare `Link`."""
    choices = [get_origin(choice) or choice for argument in arguments for choice in _union(argument)]
    return tuple(choices) if all(isinstance(choice, type) and choice is not Any for choice in choices) else ()


def _union(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
