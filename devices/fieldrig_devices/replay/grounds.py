"""The common ground of all comparisons of a replay: names, tolerances, the clock of the log, and the result."""

from typing import Final

from fieldrig.clock import S
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.runs import Runs
from fieldrig_devices.replay.tolerances import Tolerances

MOST_SUBJECTS: Final = 8_192
"""Objects, registers and PDOs whose comparisons are counted one by one."""


class Grounds:
    """The grounds on which messages of a rig and of a log are compared."""

    def __init__(self, names: tuple[LogNames, LogNames], tolerances: Tolerances, result: ReplayResult) -> None:
        """`names` are those of the log and of the rig: each follows the mappings of its own side."""
        self.names, self.tolerances, self.result = names, tolerances, result
        self.runs = Runs(result, tolerances)
        self.timeout_ns = S
        """How long an answer is awaited."""
        self.was_on = False
        """True if the rig ran before the log begins."""
        self.begin_ns = 0
        """The instant of the rig at which the log begins."""
        self.log_ns = 0
        """The instant of the log that `begin_ns` is."""
        self.first_ns = 0
        """The instant of the rig of the first message of the log."""
        self.buses: set[str] = set()
        """The buses that the log has; the others are not compared."""

    def since(self, time_ns: int) -> int:
        """Return an instant from the beginning of the log."""
        return time_ns - self.begin_ns

    def node(self, bus: str, node_id: int) -> str:
        """Return `node 5` with its name in the rig."""
        name = self.names[1].node(bus, node_id)
        return name if name == f"node {node_id}" else f"node {node_id} ({name})"

    def compared(self, bus: str, node: str, subject: str) -> None:
        """Count a comparison."""
        self.result.compared += 1
        counts, key = self.result.by_subject, (bus, node, subject)
        if key in counts or len(counts) < MOST_SUBJECTS:
            counts[key] = counts.get(key, 0) + 1
