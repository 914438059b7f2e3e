"""The parts that all objects of an application share: its nodes on the ring, requests to them, and the run time."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any, Final

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.runtime.item import Kernel
from fieldrig_devices.pamring.ends import PamPort
from fieldrig_devices.pamring.frames import Answer, Configuration, InputChanged, NodeType, Order, Read

LAST_NUMBER: Final = 65535
"""Orders and requests are numbered from 1 to this, and again."""
MOST_GROUPS: Final = 15
"""Groups of axes in a PAM (PAML-164)."""


def number_after(number: int) -> int:
    """Return the number of the order or request that follows the one with this number."""
    return number % LAST_NUMBER + 1


@dataclass(slots=True)
class ApplicationNode:
    """A node as the application declares it, with the items that the PAM configures on it."""

    name: str
    address: int
    node_type: NodeType
    port: PamPort
    component: tuple[str, int] | None = None
    """The NODES_GROUP and the number of the component that the node belongs to."""
    items: list[Configuration] = field(default_factory=list)
    receivers: dict[tuple[type, int], Callable[[Any], None]] = field(default_factory=dict)
    """The objects that take the reports on an item, by the class of the report and the item."""
    axis_receiver: Callable[[Any], None] | None = None
    is_active: bool = True
    error_word: int = 0

    def add(
        self,
        make: Callable[[int], Configuration],
        receiver: Callable[[Any], None] | None = None,
        report: type = InputChanged,
    ) -> int:
        """Configure an item, whose number `make` gets and this returns; `receiver` takes its reports of one class."""
        item = len(self.items) + 1
        self.items.append(make(item))
        if receiver is not None:
            self.receivers[report, item] = receiver
        return item

    def send(self, order: Order) -> None:
        """Send an order, unless the node's component is missing."""
        if self.is_active:
            self.port.send(self.address, order)


@dataclass(slots=True)
class _Request:
    node: ApplicationNode
    asked_in: int
    least_cycles: int
    then: Callable[[int | None], None]
    answer: Answer | None = None


class Site:
    """The parts of the PAM that all objects use: ring, run time, groups of axes, and requests for registers."""

    def __init__(self, kernel: Kernel, port: PamPort, readings: ObjectReadings) -> None:
        self.kernel, self.port, self.readings = kernel, port, readings
        self.cycle_s = kernel.thirds / 3000
        self.cycle = kernel.cycle_number
        """The number of the present basic cycle."""
        self.nodes: dict[str, list[ApplicationNode]] = {}
        self.free_groups = list(range(1, MOST_GROUPS + 1))
        self.dependents: dict[str, list[str]] = {}
        """The objects whose answers follow from those of an axis: its sets and zero positioners."""
        self.periods_changed: Callable[[], None] = lambda: None
        """Called when a program has changed the period of a block."""
        self.changes = 0
        """Number of commands and parameters that change what pipes compute; a pipe at rest sleeps until the next."""
        self.moved: set[str] = set()
        """Axes that their pipes have moved in this cycle."""
        self.events: list[Callable[[], None]] = []
        """The consequences of reports, for the beginning of the basic cycle that they belong to."""
        self.every_cycle: dict[str, Callable[[], None]] = {}
        """Work behind the pipes of each basic cycle, by the object."""
        self._moved_before: set[str] = set()
        self._number = self._request = 0
        self._requests: dict[int, _Request] = {}

    def touched(self, name: str) -> None:
        """Tell the run time that an axis has changed, and what depends on it."""
        self.kernel.touched(name)
        for dependent in self.dependents.get(name, ()):
            self.kernel.touched(dependent)

    def next_number(self, used: Collection[int]) -> int:
        """Return the number of the next order to axes, none of those that `used` for their last ones."""
        self._number = number_after(self._number)
        while self._number in used:
            self._number = number_after(self._number)
        return self._number

    def read(
        self, node: ApplicationNode, register: int, then: Callable[[int | None], None], least_cycles: int = 0
    ) -> None:
        """Read a register; `then` gets the answer after `least_cycles` at the earliest, and None after a time-out."""
        self._request = number_after(self._request)
        self._requests[self._request] = _Request(node, self.cycle, least_cycles, then)
        node.send(Read(self._request, register))

    def on_answer(self, answer: Answer) -> None:
        request = self._requests.get(answer.request)
        if request is not None:
            request.answer = answer

    def take(self) -> None:
        """Begin a basic cycle: carry out the consequences of reports, and pass on the answers that are due."""
        self.cycle = self.kernel.cycle_number
        if self.events:
            events, self.events = self.events, []
            for event in events:
                event()
        if self._requests:
            self._take_answers()

    def joined(self, name: str) -> None:
        """Call this when an axis has another pipe, or none: for the inquiry `pipe_motionless` it has not moved yet."""
        self._moved_before.discard(name)
        self.touched(name)

    def flowed(self) -> None:
        """Call this when pipes have flowed: `pipe_motionless` changes for axes that have begun or ceased to move."""
        for work in tuple(self.every_cycle.values()):
            work()
        if self.moved != self._moved_before:
            for name in self.moved ^ self._moved_before:
                self.touched(name)
        self.moved, self._moved_before = self._moved_before, self.moved
        self.moved.clear()

    def _take_answers(self) -> None:
        now = self.cycle
        for number, request in list(self._requests.items()):
            cycles = now - request.asked_in
            if request.answer is not None and cycles >= request.least_cycles:
                del self._requests[number]
                request.then(request.answer.value)
            elif not request.node.is_active:
                del self._requests[number]
                request.then(None)
            elif cycles >= self.readings.read_timeout_cycles:
                del self._requests[number]
                self.kernel.report("07..E021", (request.node.address,))
                request.then(None)
