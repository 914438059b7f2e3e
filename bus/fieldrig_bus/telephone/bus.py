"""`telephone.virtual`: the telephone network in virtual time; with the base of both kinds, and their settings."""

from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

from pydantic import Field, model_validator

from fieldrig.bus import ModelBus, Time
from fieldrig.clock import MS
from fieldrig.settings import Settings, WrongKey
from fieldrig.text.nearest import closest
from fieldrig_bus.telephone import codec
from fieldrig_bus.telephone.faults import MODELS, TelephoneFault
from fieldrig_bus.telephone.lines import Network
from fieldrig_bus.telephone.message import (
    Carrier,
    Dial,
    Heard,
    Hook,
    Offer,
    Ready,
    Ring,
    TelephoneMessage,
    check_interest,
    check_sent,
)
from fieldrig_bus.telephone.model import TelephoneModel
from fieldrig_bus.telephone.modulation import FASTEST_BPS, SLOWEST_BPS

Number = Annotated[str, Field(pattern=r"^[0-9*#]{1,32}$", description="digits, * and #")]


class TelephoneSettings(Settings):
    """Settings that every telephone network has."""

    numbers: dict[str, Number] = Field(
        default={}, description="numbers by member; a member without one can call but not be called"
    )
    highest_bps: int = Field(
        default=FASTEST_BPS, ge=SLOWEST_BPS, le=FASTEST_BPS, description="highest rate that the lines carry, in bit/s"
    )
    delay_ms: float = Field(default=10, ge=0, le=5000, description="delay from end to end, in each direction")
    ring_on_ms: float = Field(default=1000, ge=100, le=60_000, description="duration of one ring")
    ring_off_ms: float = Field(default=4000, ge=100, le=60_000, description="pause between two rings")
    outside_prefix: str = Field(
        default="", pattern=r"^[0-9*#]{0,4}$", description="digits after which a second dial tone is heard"
    )
    paced: bool = Field(default=True, description="true: data take the time of their rate; false: they arrive at once")
    faults: list[TelephoneFault] = Field(default=[], description="faults that the network has from the start")

    @model_validator(mode="after")
    def _check_numbers(self) -> "TelephoneSettings":
        check_apart([*self.numbers.items()])
        return self

    def outside_lines(self) -> Sequence[str]:
        """Return the names of the lines that lead to programs outside."""
        return ()

    def leads_to(self, what: str, value: Hashable) -> bool:
        """Return False: no device needs anything of another one on a telephone network."""
        return False

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        for name in self.numbers:
            if name not in members:
                yield WrongKey(("numbers", name), f'this network has no member "{name}"', closest(name, list(members)))
        for index, fault in enumerate(self.faults):
            if fault.line is not None and fault.line not in (*members, *self.outside_lines()):
                yield WrongKey(
                    ("faults", index, "line"),
                    f'this network has no member "{fault.line}"',
                    closest(fault.line, list(members)),
                )


def check_apart(numbers: Sequence[tuple[str, str]]) -> None:
    """Raise ValueError for a number that another one begins with: it would be complete before its last digit."""
    for index, (name, number) in enumerate(numbers):
        for other_place, (other, longer) in enumerate(numbers):
            if index != other_place and longer.startswith(number):
                raise ValueError(f"number {longer} of {other} begins with {number} of {name}: expected other digits")


class TelephoneBus(ModelBus[TelephoneMessage]):
    """A telephone network; all of its kinds are subclasses."""

    family: ClassVar[str] = "telephone"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (bytes, Hook, Dial, Ring, Heard, Offer, Carrier, Ready)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS
    settings: Any

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)

    @staticmethod
    def standing_of(message: TelephoneMessage) -> str | None:
        return "hook" if type(message) is Hook else None

    def numbers(self) -> dict[str, str]:
        """Return the numbers of all lines, by member."""
        return dict(self.settings.numbers)

    def model(self) -> TelephoneModel:
        settings: TelephoneSettings = self.settings
        return TelephoneModel(
            Network(
                self.numbers(),
                settings.highest_bps,
                round(settings.delay_ms * MS),
                round(settings.ring_on_ms * MS),
                round(settings.ring_off_ms * MS),
                settings.outside_prefix,
                settings.paced,
                settings.faults,
            )
        )


class TelephoneVirtual(TelephoneBus):
    about: ClassVar[str] = "a telephone network for modems, in virtual time"
    times: ClassVar[frozenset[Time]] = frozenset({"virtual"})

    def __init__(self, name: str, settings: TelephoneSettings) -> None:
        super().__init__(name, settings)
