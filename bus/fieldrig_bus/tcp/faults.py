"""The faults of a bus of TCP services: their settings, and what they do to connections and bytes."""

from collections.abc import Hashable
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated
from fieldrig.faults.note import FaultNote
from fieldrig_bus.tcp.message import Close, Connected, Data, OnTcp
from fieldrig_bus.tcp.model import TcpModel


class Refuse(Repeated):
    """New connections are refused; with `nth`, `count` or `probability` they are closed at once."""

    what: Literal["refuse"]
    service: str | None = Field(default=None, description="name of the service; left out: any")


class Cut(Repeated):
    """A connection is closed when the next bytes pass, which are lost."""

    what: Literal["cut"]


class Delay(Repeated):
    """Bytes arrive later, and so do those of their connection after them."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


TcpServiceFault = Annotated[Refuse | Cut | Delay, Field(discriminator="what")]
MODELS: Final = faults.models_of(TcpServiceFault)


class TcpEffects(Effects[OnTcp]):
    models = MODELS

    def stream_of(self, delivery: Delivery[OnTcp]) -> Hashable:
        message = delivery.message
        return None if isinstance(message, FaultNote) else (delivery.sender, message.connection)

    def fits(self, settings: Any, delivery: Delivery[OnTcp]) -> bool:
        message = delivery.message
        if isinstance(settings, Refuse):
            return isinstance(message, Connected) and settings.service in (None, message.service)
        return isinstance(message, Data) and bool(delivery.receivers)

    def strike(self, fault: Fault[Any], delivery: Delivery[OnTcp]) -> Struck[OnTcp]:
        settings, message = fault.settings, delivery.message
        assert isinstance(message, Connected | Data)
        if isinstance(settings, Delay):
            return Struck([delivery._replace(time_ns=delivery.time_ns + round(settings.delay_ms * MS))], "delayed")
        assert isinstance(self.medium, TcpModel)
        owner = self.medium.owner_of(message.connection)
        if owner is not None:
            self.medium.submit(delivery.time_ns, owner, Close(message.connection))
        return Struck([], "refused" if isinstance(settings, Refuse) else "connection cut")

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[OnTcp]]:
        if isinstance(fault.settings, Refuse) and fault.settings.is_for_each:
            self.refuse(fault, is_on, fault.settings.service)
        return []
