"""Bridge between two CAN buses: forwards all frames in both directions, or those that pass its filters.

A bus never delivers a member's own frames to it, so a forwarded frame doesn't return.  Two bridges between the same two
buses would forward each frame in circles; as with physical bridges, use only one.
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
        description="filters as [identifier, mask], as in SocketCAN (0x80000000: 29 bits); null forwards all frames",
    )
    b_to_a: list[Filter] | None = Field(default=None, description="the same for the other direction")


class CanBridge(Device):
    about: ClassVar[str] = "forwards frames between two CAN buses, all or filtered"
    no_faults: ClassVar[str] = "it only forwards frames, and the faults of frames are those of its two buses"

    def __init__(self, a: Link[CanFrame], b: Link[CanFrame], settings: CanBridgeSettings) -> None:
        self._a, self._b = a, b
        self._a_to_b = self._b_to_a = 0
        a.on_receive(self._on_frame_of_a, settings.a_to_b)
        b.on_receive(self._on_frame_of_b, settings.b_to_a)

    def points(self) -> Mapping[str, Point]:
        return {
            "a_to_b": Point(lambda: self._a_to_b, unit="frames", about="forwarded from a to b"),
            "b_to_a": Point(lambda: self._b_to_a, unit="frames", about="forwarded from b to a"),
        }

    def _on_frame_of_a(self, frame: CanFrame) -> None:
        self._a_to_b += 1
        self._b.send(frame)

    def _on_frame_of_b(self, frame: CanFrame) -> None:
        self._b_to_a += 1
        self._a.send(frame)
