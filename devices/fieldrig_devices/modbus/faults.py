"""The faults of a Modbus device itself; those of its frames are faults of the bus."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import LONGEST_MS, Fault, Repeated, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig_bus.modbus.effects import registers_in
from fieldrig_bus.modbus.message import ModbusRequest


class OfRequest(Repeated):
    """The requests that a fault concerns."""

    unit: int | None = Field(default=None, ge=0, le=255, description="unit id; left out: any")
    function: int | None = Field(default=None, ge=1, le=127, description="function code; left out: any")
    address: int | None = Field(
        default=None, ge=0, le=0xFFFF, description="register or bit on the wire, from 0, that the request names"
    )

    def fits(self, request: ModbusRequest) -> bool:
        return (
            self.unit in (None, request.unit)
            and self.function in (None, request.pdu[0])
            and (self.address is None or self.address in registers_in(request.pdu))
        )


class Silent(OfRequest):
    """The device neither does what is asked nor answers."""

    what: Literal["silent"]


class Slow(OfRequest):
    """The device does what is asked, and answers, later."""

    what: Literal["slow"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="length of the delay")


class Refusing(OfRequest):
    """The device refuses with an exception."""

    what: Literal["exception"]
    code: int = Field(default=4, ge=1, le=255, description="exception code; 4 is server device failure")


ModbusDeviceFault = Annotated[Silent | Slow | Refusing, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(ModbusDeviceFault)


class ModbusDeviceFaults(InjectedFaults[Fault[Any]]):
    """The faults of one device."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._asked = 0

    def of(self, request: ModbusRequest) -> OfRequest | None:
        """Return the first fault that applies to a request, and count it."""
        now_ns = self._clock.now_ns()
        self._asked += 1
        for fault in self.records:
            if fault.is_on(now_ns) and fault.settings.fits(request) and fault.happens(self._asked):
                self.records.use(fault)
                settings: OfRequest = fault.settings
                return settings
        return None
