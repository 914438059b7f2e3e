"""How long a message is on its medium before it arrives: a log has the instant of arrival, a player that of sending."""

from collections.abc import Mapping
from typing import Any, Final

from fieldrig.bus import Bus, BusModel, ModelBus
from fieldrig.clock import S
from fieldrig.config.build import random_of

BETWEEN_NS: Final = 3_600 * S
"""Time between two tries, so that the medium is idle again."""
LONGEST_NS: Final = S
"""A message that takes longer, such as one to a bus without an acknowledgement, is sent when it arrived in the log."""
SENDER, OTHER = "sender", "other"


class Leads:
    """The media of a rig without traffic, on which one message after the other is tried."""

    def __init__(self, buses: Mapping[str, Bus[Any]]) -> None:
        self._buses = buses
        self._models: dict[str, tuple[BusModel[Any], int] | None] = {}

    def lead_ns(self, bus: str, message: Any) -> int:
        """Return how long before its arrival a message has to be sent on an idle bus."""
        if bus not in self._models:
            self._models[bus] = self._begun(self._buses[bus])
        found = self._models[bus]
        if found is None:
            return 0
        model, at_ns = found
        model.submit(at_ns, SENDER, message)
        arrival_ns = at_ns
        while (next_ns := model.next_ns()) is not None and next_ns <= at_ns + LONGEST_NS:
            arrival_ns = max(arrival_ns, *(delivery.time_ns for delivery in model.collect(next_ns)), at_ns)
        self._models[bus] = model, at_ns + BETWEEN_NS
        return arrival_ns - at_ns

    def _begun(self, bus: Bus[Any]) -> tuple[BusModel[Any], int] | None:
        if not isinstance(bus, ModelBus):
            return None
        model = bus.model()
        model.begin(0, random_of(bus.name, 0))
        for member in (SENDER, OTHER):
            model.join(member)
            model.listen(0, member, ())
        return model, S
