"""The faults of a relay: their settings, and what they do to its connections and their bytes."""

from collections.abc import Hashable
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated
from fieldrig_bus.ip.message import IN_CHANNEL, IpPacket, OnRelay, Opened, Portion
from fieldrig_bus.ip.model import RelayModel


class Refuse(Repeated):
    """New connections are refused."""

    what: Literal["refuse"]
    port: int | None = Field(default=None, ge=1, le=65_535, description="port of the connection; left out: any")


class Cut(Repeated):
    """A connection is lost when the next bytes pass, which are lost too."""

    what: Literal["cut"]


class Drop(Repeated):
    """A packet of IP between a device and the kernel is lost."""

    what: Literal["drop"]


class Delay(Repeated):
    """Bytes or packets arrive later, and so do those of their connection after them."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


RelayFault = Annotated[Refuse | Cut | Drop | Delay, Field(discriminator="what")]
MODELS: Final = faults.models_of(RelayFault)
CONCERNED: Final[dict[str, tuple[type[Any], ...]]] = {
    "refuse": (Opened,),
    "cut": (Portion,),
    "drop": (IpPacket,),
    "delay": (Portion, IpPacket),
}
"""The messages that each fault concerns."""


class RelayEffects(Effects[OnRelay]):
    models = MODELS

    def stream_of(self, delivery: Delivery[OnRelay]) -> Hashable:
        message = delivery.message
        if isinstance(message, IpPacket):
            return message.device, message.is_answer
        return (message.opener, message.number, message.is_answer) if isinstance(message, IN_CHANNEL) else None

    def fits(self, settings: Any, delivery: Delivery[OnRelay]) -> bool:
        message = delivery.message
        if not delivery.receivers or not isinstance(message, CONCERNED[settings.what]):
            return False
        return not isinstance(message, Opened) or settings.port in (None, message.port)

    def strike(self, fault: Fault[Any], delivery: Delivery[OnRelay]) -> Struck[OnRelay]:
        settings, message = fault.settings, delivery.message
        if isinstance(settings, Delay):
            return Struck([delivery._replace(time_ns=delivery.time_ns + round(settings.delay_ms * MS))], "delayed")
        if isinstance(message, IpPacket):
            return Struck([], "dropped")
        assert isinstance(message, Opened | Portion)
        assert isinstance(self.medium, RelayModel)
        is_new = isinstance(message, Opened)
        why = "connection refused" if is_new else "connection cut"
        self.medium.cut(delivery.time_ns, message.opener, message.number, why, is_new=is_new)
        return Struck([], why)
