"""`can.hub`: a CAN bus in real time; the hub's process wakes up at `next_ns` of `model`, which paces at the bit rate.

It needs no kernel module and no root.  Outside clients join by the socketcand protocol (python-can has a client) and by
the Lawicel ASCII protocol, on a pty (`slcand` makes a network device of it) or over TCP.  In virtual time the same bus
runs in the process of the rig.
"""

from typing import ClassVar, Literal

from pydantic import Field

from fieldrig.bus import Time
from fieldrig_bus.can.outsiders import OutsidersBus, OutsidersSettings
from fieldrig_bus.net import HubSettings

AWAKE_NS = 100_000  # longer than a node needs to answer


class CanHubSettings(HubSettings, OutsidersSettings):
    acknowledge: Literal["members", "always"] = Field(
        default="always",
        description="which members acknowledge frames; `always` includes the hub, so that a lone client can transmit",
    )


class CanHub(OutsidersBus):
    about: ClassVar[str] = "CAN bus with arbitration and exact bit times, in real time; socketcand and slcan join"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    settings: CanHubSettings

    def __init__(self, name: str, settings: CanHubSettings) -> None:
        super().__init__(name, settings)

    @property
    def awake_ns(self) -> int:
        """The hub stays awake on an unpaced bus, where waking up a core would take most of a round trip."""
        return AWAKE_NS if self.settings.bitrate is None else 0
