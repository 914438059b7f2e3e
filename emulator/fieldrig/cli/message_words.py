"""Messages of buses in words: as the bus itself shows them, or by the names that a rig file has."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from fieldrig.bus import Bus
    from fieldrig.traces.names import Namer
    from fieldrig.traces.trace import TraceEntry

OfRig = Annotated[
    Path | None,
    typer.Option(
        "--rig",
        metavar="RIG",
        help="The rig file that the messages belong to: nodes, objects and registers are shown by name.",
        show_default=False,
    ),
]


def shower_of(rig: Path | None) -> "Shower":
    """Return what shows messages, by the names of a rig file if there is one.  ConfigError for a file with mistakes."""
    return Shower() if rig is None else NameShower(rig)


class Shower:
    """Shows messages in words, by a bus of their family, or in hex where there is none."""

    def __init__(self) -> None:
        self._show: dict[str, Callable[[bytes], str]] = {}

    def __call__(self, entry: "TraceEntry") -> str:
        show = self._show.get(entry.family)
        if show is None:
            show = self._show[entry.family] = _showing(entry.family)
        try:
            return show(entry.data)
        except ValueError:
            return entry.data.hex(" ")


class NameShower(Shower):
    """Shows messages by the names that a rig knows; a bus that it does not have is shown as without it."""

    def __init__(self, path: Path) -> None:
        from fieldrig.config.rig_file import load

        super().__init__()
        self._config = load(path)
        self._namers: dict[str, Namer] = {}

    def __call__(self, entry: "TraceEntry") -> str:
        from fieldrig.traces.names import in_words, namer_of

        known = self._config.buses.get(entry.bus)
        if known is None or known.bus.family != entry.family:
            return super().__call__(entry)
        namer = self._namers.get(entry.bus)
        if namer is None:
            namer = self._namers[entry.bus] = namer_of(self._config, entry.bus)
        try:
            return in_words(namer(known.bus.decode(entry.data), entry.sender))
        except ValueError:
            return entry.data.hex(" ")


def _showing(family: str) -> Callable[[bytes], str]:
    bus = bus_of(family)
    return (lambda data: data.hex(" ")) if bus is None else lambda data: bus.show(bus.decode(data))


@cache
def bus_of(family: str) -> "Bus[Any] | None":
    """Return a bus of a family, for what it knows of its messages."""
    from fieldrig.config import kinds

    for kind in kinds.bus_kinds_for("virtual", family):
        cls = kinds.find_bus(kind)
        try:
            return cls(family, kinds.settings_model(cls)())
        except ValueError:  # it has keys that must be given
            continue
    return None
