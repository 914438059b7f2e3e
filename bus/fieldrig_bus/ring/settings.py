"""Settings that every ring has, whatever its telegrams are."""

from collections.abc import Collection, Hashable, Iterator, Sequence
from typing import Any

from pydantic import Field

from fieldrig.settings import Settings, WrongKey
from fieldrig.text.nearest import closest
from fieldrig_bus.ring.faults import MASTER, place_of


class OrderSettings(Settings):
    """The order of the stations, and the faults from the start; each kind of ring has faults of its own."""

    order: list[str] = Field(
        default=[], description="stations in the order of the fibre; those left out follow in the order of the file"
    )
    bypassed: list[str] = Field(
        default=[], description="stations with an optical bypass: without power they don't open the ring"
    )
    faults: list[Any] = Field(default=[], description="faults that the ring has from the start")

    def leads_to(self, what: str, value: Hashable) -> bool:
        """Return False: a fibre has no end outside the rig."""
        return False

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        stations = [name for name in members if name not in masters]
        for index, name in enumerate(self.order):
            yield from _wrong_name(("order", index), name, stations)
            if name in self.order[:index]:
                yield WrongKey(
                    ("order", index), f"{name} is in the order already", "a station has one place in the ring"
                )
        for index, name in enumerate(self.bypassed):
            yield from _wrong_name(("bypassed", index), name, stations)
        for index, fault in enumerate(self.faults):
            key, name = place_of(fault)
            known = [*stations, MASTER, *masters] if key == "after" else stations
            yield from _wrong_name(("faults", index, key), name, known)


def _wrong_name(path: tuple[str | int, ...], name: str, known: Sequence[str]) -> Iterator[WrongKey]:
    if name not in known:
        yield WrongKey(path, f'this ring has no station "{name}"', closest(name, list(known)))
