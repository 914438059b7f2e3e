"""`can.socketcan`: a CAN bus of the Linux kernel, vcan or a real adapter.

Source: Linux, Documentation/networking/can.rst, 4.1 (raw sockets), and include/uapi/linux/can.h.  The kernel filters
what a member is not interested in, so it costs the member nothing.  The bit rate is that of the network device.  Its
error frames become notices for members that ask for "errors" or "state".
Left out: setting devices up, which needs root (the error messages say how).
"""

import shlex
import sys
from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fieldrig.bus import Attachment
from fieldrig.device import Tool, WayIn
from fieldrig.errors import BusError
from fieldrig_bus.can.direct import CanDirectBus, CanDirectSettings, DirectEnd
from fieldrig_bus.can.socketcan_wire import NO_CAN, NO_SOCKETCAN


class CanSocketcanSettings(CanDirectSettings):
    channel: str = Field(pattern=r"^[^\s/]{1,15}$", description="network device, such as vcan0 or can0")
    fd: bool = Field(default=False, description="carry CAN FD frames as well; the device must be set up for them")


class CanSocketcan(CanDirectBus):
    about: ClassVar[str] = "CAN bus of the Linux kernel: vcan, or a real adapter"
    settings: CanSocketcanSettings

    def __init__(self, name: str, settings: CanSocketcanSettings) -> None:
        super().__init__(name, settings)

    def end(self, at: Attachment) -> DirectEnd:
        if sys.platform == "linux":
            from fieldrig_bus.can.socketcan_end import SocketcanEnd, open_socket

            return SocketcanEnd(at, open_socket(self.settings.channel, self.settings.fd))
        raise BusError(NO_SOCKETCAN, NO_CAN)

    def python_can(self) -> dict[str, object]:
        return {"interface": "socketcan", "channel": self.settings.channel, "fd": self.settings.fd}

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("SocketCAN", self.settings.channel)]

    def tools(self, run: Path) -> list[Tool]:
        channel = shlex.quote(self.settings.channel)
        return [
            Tool("log", f"candump {channel}"),
            Tool("send", f"cansend {channel} 123#1122"),
            Tool("watch", f"python -m can.viewer -i socketcan -c {channel}"),
        ]
