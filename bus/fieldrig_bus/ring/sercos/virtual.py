"""`ring.virtual`: the SERCOS ring in virtual time.  `model` is the medium."""

from collections.abc import Collection, Hashable, Iterator, Sequence
from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig.settings import Settings, WrongKey
from fieldrig.wording import closest
from fieldrig_bus.ring.breaks import MASTER
from fieldrig_bus.ring.sercos.family import SercosFamily
from fieldrig_bus.ring.sercos.faults import RingFault, place_of
from fieldrig_bus.ring.sercos.message import RingMessage
from fieldrig_bus.ring.sercos.model import RingModel


class RingSettings(Settings):
    """Settings that every SERCOS ring has."""

    mbaud: Literal[2, 4, 8, 16] = Field(default=4, description="bit rate on the fibre, in Mbit/s")
    order: list[str] = Field(
        default=[], description="drives in the order of the fibre; drives left out follow in the order of the file"
    )
    bypassed: list[str] = Field(
        default=[], description="stations with an optical bypass: without power they don't open the ring"
    )
    faults: list[RingFault] = Field(default=[], description="faults that the ring has from the start")

    def leads_to(self, what: str, value: Hashable) -> bool:
        """Return False: a fibre has no end outside the rig."""
        return False

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        stations = [name for name in members if name not in masters]
        for place, name in enumerate(self.order):
            yield from _wrong_name(("order", place), name, stations)
            if name in self.order[:place]:
                yield WrongKey(
                    ("order", place), f"{name} is in the order already", "a station has one place in the ring"
                )
        for place, name in enumerate(self.bypassed):
            yield from _wrong_name(("bypassed", place), name, stations)
        for place, fault in enumerate(self.faults):
            key, name = place_of(fault)
            known = [*stations, MASTER, *masters] if key == "after" else stations
            yield from _wrong_name(("faults", place, key), name, known)


def _wrong_name(path: tuple[str | int, ...], name: str, known: Sequence[str]) -> Iterator[WrongKey]:
    if name not in known:
        yield WrongKey(path, f'this ring has no station "{name}"', closest(name, list(known)))


class RingVirtual(SercosFamily, ModelBus[RingMessage]):
    about: ClassVar[str] = "SERCOS fibre ring, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    settings: RingSettings

    def __init__(self, name: str, settings: RingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> RingModel:
        settings = self.settings
        return RingModel(settings.order, settings.mbaud, settings.bypassed, settings.faults)
