"""The faults of an OPC UA bus: their settings, and what they do between the server and the devices."""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.bus import Delivery
from fieldrig.clock import MS
from fieldrig.faults import faults
from fieldrig.faults.disturbed import Effects, Struck
from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated, Timed
from fieldrig.settings import MEMBER
from fieldrig.text.nearest import closest
from fieldrig_bus.opcua.message import (
    ANSWERS,
    LONGEST_PATH,
    REQUESTS,
    Hangup,
    OnOpcUa,
    Outcome,
    Outcomes,
    Read,
    Request,
    Status,
)
from fieldrig_bus.opcua.model import SERVER

MOST_ASKED: Final = 4096
"""Requests without an answer that are remembered."""


class OfNodes(Repeated):
    """The answers of devices that a fault concerns."""

    names: ClassVar = {"device": MEMBER}

    device: str | None = Field(default=None, description="the device that answers; left out: any")
    path: str | None = Field(default=None, max_length=LONGEST_PATH, description="path of a node; left out: any")


class BadQuality(OfNodes):
    """Values have a bad status instead of a value."""

    what: Literal["bad_quality"]
    status: Literal["bad", "sensor_failure", "device_failure", "no_communication"] = Field(
        default="sensor_failure", description="status code, such as BadSensorFailure"
    )


class Drop(OfNodes):
    """A device does not answer, so the server answers in its place after two seconds."""

    what: Literal["drop"]


class Delay(OfNodes):
    """A device answers late."""

    what: Literal["delay"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


class LostSession(Timed):
    """All connections of clients are closed when it begins."""

    what: Literal["lost_session"]


OpcUaFault = Annotated[BadQuality | Drop | Delay | LostSession, Field(discriminator="what")]
MODELS: Final = faults.models_of(OpcUaFault)
STATUS: Final = {
    "bad": Status.BAD,
    "sensor_failure": Status.SENSOR_FAILURE,
    "device_failure": Status.DEVICE_FAILURE,
    "no_communication": Status.NO_ANSWER,
}


class OpcUaEffects(Effects[OnOpcUa]):
    models = MODELS
    turns_are_struck = False

    def __init__(self, given: Iterable[Timed] = ()) -> None:
        super().__init__(given)
        self._asked: dict[int, Request] = {}

    def check(self, settings: Any, members: Iterable[str]) -> None:
        device = getattr(settings, "device", None)
        if device is not None and device not in members:
            raise ValueError(f"the bus has no device {device!r}\n{closest(device, list(members))}")

    def asked(self, member: str, message: OnOpcUa) -> None:
        if isinstance(message, REQUESTS):
            self._asked[message.exchange] = message
            if len(self._asked) > MOST_ASKED:
                del self._asked[next(iter(self._asked))]

    def fits(self, settings: Any, delivery: Delivery[OnOpcUa]) -> bool:
        message = delivery.message
        if not isinstance(message, ANSWERS) or isinstance(settings, LostSession):
            return False
        asked = self._asked.get(message.exchange)
        if asked is None or settings.device not in (None, asked.device):
            return False
        if isinstance(settings, BadQuality) and not isinstance(asked, Read):
            return False
        return settings.path is None or settings.path in (asked.paths if isinstance(asked, Read) else (asked.path,))

    def strike(self, fault: Fault[Any], delivery: Delivery[OnOpcUa]) -> Struck[OnOpcUa]:
        settings, message = fault.settings, delivery.message
        match settings:
            case Drop():
                return Struck([delivery._replace(receivers=())], "answer dropped")
            case Delay(delay_ms=delay_ms):
                return Struck([delivery._replace(time_ns=delivery.time_ns + round(delay_ms * MS))], "delayed")
        assert isinstance(message, Outcomes)
        asked = self._asked[message.exchange]
        assert isinstance(asked, Read)
        bad = Outcome(STATUS[settings.status])
        pairs = zip(asked.paths, message.outcomes, strict=False)
        outcomes = tuple(bad if settings.path in (None, path) else outcome for path, outcome in pairs)
        return Struck([delivery._replace(message=Outcomes(message.exchange, outcomes))], f"quality {settings.status}")

    def turn(self, fault: Fault[Any], now_ns: int, is_on: bool) -> list[Delivery[OnOpcUa]]:
        if not is_on or not isinstance(fault.settings, LostSession):
            return []
        fault.applied += 1
        return [Delivery(now_ns, SERVER, Hangup(), (SERVER,))]
