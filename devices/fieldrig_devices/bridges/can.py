"""Bridge between two CAN buses: carries every frame both ways, or those that filters let through.

A bus never gives a member its own frames back, so what was forwarded doesn't return.  Two bridges between the same two
buses would carry frames round for ever; one is the rule, as with bridges of iron.
"""

from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from fieldrig.device import Device, Point
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.can.frame import CanFrame

Word = Annotated[int, Field(ge=0, le=0xFFFF_FFFF)]
Filter = Annotated[list[Word], Field(min_length=2, max_length=2, description="[identifier, mask]")]


class CanBridgeSettings(Settings):
    a_to_b: list[Filter] | None = Field(
        default=None,
        description="[identifier, mask] pairs as SocketCAN has them (29 bits: 0x80000000 too); default: all",
    )
    b_to_a: list[Filter] | None = Field(default=None, description="the same for the other direction")


class CanBridge(Device):
    about: ClassVar[str] = "carries frames between two CAN buses, all or filtered"

    def __init__(self, a: Link[CanFrame], b: Link[CanFrame], settings: CanBridgeSettings) -> None:
        self._a, self._b = a, b
        self._a_to_b = self._b_to_a = 0
        a.on_receive(self._on_frame_of_a, settings.a_to_b)
        b.on_receive(self._on_frame_of_b, settings.b_to_a)

    def points(self) -> Mapping[str, Point]:
        return {
            "a_to_b": Point(lambda: self._a_to_b, unit="frames", about="carried from a to b"),
            "b_to_a": Point(lambda: self._b_to_a, unit="frames", about="carried from b to a"),
        }

    def _on_frame_of_a(self, frame: CanFrame) -> None:
        self._a_to_b += 1
        self._b.send(frame)

    def _on_frame_of_b(self, frame: CanFrame) -> None:
        self._b_to_a += 1
        self._a.send(frame)
