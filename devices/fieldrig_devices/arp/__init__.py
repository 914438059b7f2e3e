"""Model of the ASA-RT ARP two-axis card."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = ["EDS", "ArpPort"]

if TYPE_CHECKING:
    from fieldrig_devices.arp.can.face import EDS
    from fieldrig_devices.arp.user_port.client import ArpPort
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.arp.can.face": "EDS",
            "fieldrig_devices.arp.user_port.client": "ArpPort",
        },
    )
