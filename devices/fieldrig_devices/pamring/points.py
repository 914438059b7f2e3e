"""The points that every node of a PAM's ring has."""

from collections.abc import Mapping

from fieldrig.device import Point, Value
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.node import RingNode


def ring_troubles(end: RingNode) -> Mapping[str, Value]:
    """Return the fault of the ring, by the key of its point."""
    return {} if end.fault is RingFault.NONE else {"ring": end.fault.value}


def ring_points(end: RingNode) -> Mapping[str, Point]:
    return {
        "ring": Point(lambda: end.fault.value, about="fault of the ring as the node sees it"),
        "node": Point(lambda: end.state.name.lower(), about="unknown, identified or running"),
    }
