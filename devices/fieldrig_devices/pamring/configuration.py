"""The items of a PAM's nodes on their way: sent, acknowledged or refused, and with the first values of their inputs."""

from collections import deque
from collections.abc import Callable, Collection, Mapping, Sequence

from fieldrig.clock import MS
from fieldrig_devices.pamring import messages
from fieldrig_devices.pamring.frames import (
    Accepted,
    AxisItem,
    Configuration,
    InputChanged,
    InputItem,
    NodeType,
    Refused,
)
from fieldrig_devices.pamring.outbox import Outbox

Say = Callable[[str, Sequence[int], str], None]
"""Shows a message: its code, D1 to D3, and its text if it has one."""


class Items:
    """The items of all nodes during one start of the ring."""

    def __init__(self, outbox: Outbox, frames_per_cycle: int, say: Say) -> None:
        self._outbox, self._frames_per_cycle, self._say = outbox, frames_per_cycle, say
        self.of: dict[int, list[Configuration]] = {}
        """The items of each address, in the order in which they are configured."""
        self._types: Mapping[int, NodeType] = {}
        self._unsent: deque[tuple[int, Configuration]] = deque()
        self._pending: dict[tuple[int, int], Configuration] = {}
        """The items that are not acknowledged yet, by address and number."""
        self.unread: dict[tuple[int, int], InputItem] = {}
        """The inputs of Smart-IO nodes whose first value is missing, by address and number."""
        self.refusals: set[messages.Message] = set()
        """The errors that end the configuration."""

    def begin(self, active: Collection[int], types: Mapping[int, NodeType]) -> None:
        """Begin to configure these nodes."""
        self._types = types
        self.refusals.clear()
        self._unsent.extend((address, item) for address in sorted(active) for item in self.of.get(address, ()))
        self._pending = {(address, item.item): item for address, item in self._unsent}
        self.unread = {
            key: item
            for key, item in self._pending.items()
            if isinstance(item, InputItem) and types[key[0]] is NodeType.SMART_IO
        }

    def are_acknowledged(self) -> bool:
        """Send as many items as a cycle has frames for.  True if no acknowledge is missing."""
        while self._unsent and len(self._outbox) < self._frames_per_cycle:
            self._outbox.put(*self._unsent.popleft())
        return not self._pending

    def on_acknowledge(self, address: int, report: Accepted | Refused) -> None:
        """Take the acknowledge of an item."""
        item = self._pending.pop((address, report.item), None)
        if item is None:
            self._say(messages.BAD_ACKNOWLEDGE, (address, report.item, 0), "")
        elif isinstance(report, Refused):
            self._on_refusal(address, item)

    def _on_refusal(self, address: int, item: Configuration) -> None:
        if self._types[address] is NodeType.SMART_IO:
            self._say(messages.ITEM_REFUSED, (address, item.item, 0), "")
            self.refusals.add(messages.plain(messages.CONFIGURATION_ERROR))
        elif isinstance(item, AxisItem):
            self.refusals.add(messages.plain(messages.AXIS_REFUSED))
        else:
            self.refusals.add((messages.BAD_ST1_ITEM, (item.item, 0, 0)))

    def on_input(self, address: int, report: InputChanged) -> bool:
        """Take the value of an input.  True if it is the first one of an input that is waited for."""
        return self.unread.pop((address, report.item), None) is not None

    def longest_first_value_ns(self) -> int:
        """The time that an input takes to its first value: DEBOUNCE samples, one in each PERIOD."""
        return max((item.period_ms * item.debounce for item in self.unread.values()), default=0) * MS
