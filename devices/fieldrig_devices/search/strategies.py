"""The strategies of a search, by their names."""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.search.archive import Archive
from fieldrig_devices.search.strategy import Strategy, Task
from fieldrig_devices.search.swarm import Swarm
from fieldrig_devices.search.sweep import Sweep

STRATEGIES: Final[Mapping[str, Callable[[Task], Strategy]]] = {"sweep": Sweep, "archive": Archive, "swarm": Swarm}
