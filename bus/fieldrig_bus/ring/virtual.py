"""`ring.virtual`: the fibre ring in virtual time.  What the medium does is in `model`."""

from collections.abc import Iterator, Sequence
from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import ModelBus, Time
from fieldrig.settings import Settings, WrongKey
from fieldrig.wording import closest
from fieldrig_bus.ring import message
from fieldrig_bus.ring.faults import MASTER, RingFault, place_of
from fieldrig_bus.ring.message import Answers, Cycle, Mdt, Mst, RingMessage
from fieldrig_bus.ring.model import RingModel


class RingSettings(Settings):
    mbaud: Literal[2, 4, 8, 16] = Field(default=4, description="MBaud on the fibre")
    order: list[str] = Field(
        default=[], description="drives as the fibre passes them; those left out follow in the order of the file"
    )
    bypassed: list[str] = Field(
        default=[], description="stations with an optical bypass: without power they don't open the ring"
    )
    faults: list[RingFault] = Field(default=[], description="that the ring has from the start")

    def wrong_for(self, members: Sequence[str]) -> Iterator[WrongKey]:
        for place, name in enumerate(self.order):
            yield from _wrong_name(("order", place), name, members)
            if name in self.order[:place]:
                yield WrongKey(
                    ("order", place), f"{name} is in the order already", "a station has one place in the ring"
                )
        for place, name in enumerate(self.bypassed):
            yield from _wrong_name(("bypassed", place), name, members)
        for place, fault in enumerate(self.faults):
            key, name = place_of(fault)
            yield from _wrong_name(("faults", place, key), name, [*members, MASTER] if key == "after" else members)


def _wrong_name(path: tuple[str | int, ...], name: str, known: Sequence[str]) -> Iterator[WrongKey]:
    if name not in known:
        yield WrongKey(path, f'no device "{name}" is linked to this ring', closest(name, list(known)))


class RingVirtual(ModelBus[RingMessage]):
    about: ClassVar[str] = "SERCOS fibre ring, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})
    family: ClassVar[str] = "ring"
    messages: ClassVar[tuple[type, ...]] = (Mst, Mdt, Cycle, Answers, bytes)
    settings: RingSettings

    encode = staticmethod(message.encode)
    decode = staticmethod(message.decode)
    show = staticmethod(message.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)

    def __init__(self, name: str, settings: RingSettings) -> None:
        super().__init__(name, settings)

    def model(self) -> RingModel:
        settings = self.settings
        return RingModel(settings.order, settings.mbaud, settings.bypassed, settings.faults)
