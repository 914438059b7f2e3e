"""The deliveries of the model of a relay."""

from fieldrig_bus.ip.message import OnRelay
from fieldrig_bus.ip.model import RelayModel


def deliveries(model: RelayModel) -> list[tuple[str, OnRelay, tuple[str, ...]]]:
    """Return sender, message and receivers of everything that is due."""
    return [(found.sender, found.message, tuple(found.receivers)) for found in model.collect(1 << 62)]
