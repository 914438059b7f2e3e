"""Check that each link of a device goes to a bus that carries its messages."""

from collections.abc import Iterator, Mapping

from fieldrig.config.entries import BusEntry
from fieldrig.config.keys import Names, as_tuple
from fieldrig.config.kinds import LinkParameter, bus_kinds_of
from fieldrig.settings import WrongKey
from fieldrig.text.nearest import closest

Buses = Mapping[str, BusEntry | None]
"""The buses by name; None for a bus that is wrong itself, so that its messages are unknown."""


def wrong_links(
    given: Mapping[str, Names], parameters: Mapping[str, LinkParameter], buses: Buses
) -> Iterator[WrongKey]:
    """Yield the mistakes; their paths are relative to the device's `links`."""
    for name, parameter in parameters.items():
        if parameter.required and not given.get(name):
            yield WrongKey((name,), "this link is missing", _fitting(parameter, buses))
    for name, linked in given.items():
        if name not in parameters:
            yield WrongKey((name,), "the device has no such link", closest(name, list(parameters)))
        elif isinstance(linked, list) and not parameters[name].many:
            yield WrongKey((name,), "this link takes one bus, not a list", f"expected {name}: BUS")
        else:
            for bus in as_tuple(linked):
                yield from _wrong_link(parameters[name], bus, buses)
    every = [bus for linked in given.values() for bus in as_tuple(linked)]
    for bus in sorted({bus for bus in every if every.count(bus) > 1}):
        yield WrongKey((), f"{bus} is linked twice", "a device has one end of a bus")


def _wrong_link(parameter: LinkParameter, bus: str, buses: Buses) -> Iterator[WrongKey]:
    path = (parameter.name,)
    if bus not in buses:
        yield WrongKey(path, f'there is no bus "{bus}"', closest(bus, [str(name) for name in buses]))
    elif (entry := buses[bus]) is not None and not parameter.fits(entry.bus.messages):
        what = f"{bus} is a {entry.kind}, which does not carry what the device sends there"
        yield WrongKey(path, what, _fitting(parameter, buses))


def _fitting(parameter: LinkParameter, buses: Buses) -> str:
    fitting = [name for name, entry in buses.items() if entry is not None and parameter.fits(entry.bus.messages)]
    return f"buses that fit: {', '.join(fitting)}" if fitting else f"it needs a bus of kind {bus_kinds_of(parameter)}"
