"""How a PAM starts its ring: nodes are found, identified and compared, then configured, and then they run.

Source: the messages of section 14.6 and the errors of 14.4 and 14.5 of the digest of the system; their order is that of
section 3.1 of the digest of the language.  All nodes are configured before the one `Run` that all of them hear, so the
message for the ST1 nodes, which comes after those for the Smart-IO nodes, is held back until then.
"""

import logging
from collections.abc import Callable, Sequence
from enum import Enum, auto
from typing import Final, NamedTuple

from fieldrig.clock import Clock
from fieldrig_bus.ring.pam.message import BROADCAST, Reception, Reports
from fieldrig_devices.pamring import messages
from fieldrig_devices.pamring.configuration import Items, Say
from fieldrig_devices.pamring.declared import (
    DeclaredNode,
    active_addresses,
    nodes_without_items,
    ring_mistakes,
    types_of,
)
from fieldrig_devices.pamring.frames import (
    Accepted,
    Identify,
    Identity,
    InputChanged,
    NodeType,
    Refused,
    Report,
    Run,
    Running,
    Trouble,
)
from fieldrig_devices.pamring.outbox import Outbox
from fieldrig_devices.pamring.settings import RingLimits

log = logging.getLogger(__name__)


class Phase(Enum):
    """The phases of a ring, from power-on until it runs or has failed."""

    OFF = auto()
    WAITING = auto()
    """The nodes power on."""
    IDENTIFYING = auto()
    CONFIGURING = auto()
    STARTING = auto()
    READING = auto()
    """The inputs report their first values."""
    RUNNING = auto()
    FAILED = auto()
    """The ring has stopped, until the PAM is reset."""


class StartUp:
    """The ring from power-on until it runs or has failed."""

    def __init__(
        self, clock: Clock, settings: RingLimits, nodes: Sequence[DeclaredNode], outbox: Outbox, say: Say
    ) -> None:
        self._clock, self._settings, self._nodes = clock, settings, tuple(nodes)
        self._outbox, self._say = outbox, say
        self.phase = Phase.OFF
        self.items = Items(outbox, settings.frames_per_cycle, say)
        self.addresses: tuple[int, ...] = ()
        """The addresses on the ring, as they came round last."""
        self.types: dict[int, NodeType] = {}
        """The types of the nodes that answered."""
        self.active: frozenset[int] = frozenset()
        """The nodes that the application works with."""
        self._deadline_ns = 0
        self._is_closed = False
        self._not_running: set[int] = set()

    def begin(self) -> None:
        """Power on."""
        self._enter(Phase.WAITING)

    def advance(self) -> None:
        """Go on as far as possible.  Called in every basic cycle."""
        while (step := STEPS.get(self.phase)) is not None:
            is_done = step.is_done(self)
            if not is_done and self._clock.now_ns() < self._deadline_ns:
                return
            step.finish(self, is_done)
            if self.phase is not Phase.FAILED:
                self._enter(step.following)

    def fail(self, *why: messages.Message) -> None:
        """Show errors, and stop the ring."""
        for code, details in why:
            self._say(code, details, "")
        self.phase = Phase.FAILED

    def fail_ring(self, *why: messages.Message) -> None:
        """Show errors of the ring, as they are followed by others during the start (06..F001), and stop the ring."""
        following = [] if self.phase is Phase.RUNNING else [messages.plain(messages.NOT_INITIALISED)]
        self.fail(*why, *following, messages.plain(messages.RING_IN_ERROR))

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        step = STEPS.get(phase)
        if step is not None:
            step.begin(self)
            self._go_on_waiting()

    def _go_on_waiting(self) -> None:
        """Something has arrived, so the time-out of this phase begins again."""
        self._deadline_ns = self._clock.now_ns() + STEPS[self.phase].timeout_ns(self)

    # ---- what comes from the ring

    def on_ring(self, reports: Reports) -> None:
        """A cycle has come round.  An opening is tolerated only while the nodes power on."""
        self._is_closed = reports.reception is not Reception.NO_CARRIER
        self.addresses = reports.addresses
        if reports.reception is Reception.CRC_ERROR:
            self.fail_ring((messages.CRC_ERROR, (reports.place, 0, 0)))
        elif not self._is_closed and self.phase is not Phase.WAITING:
            self.fail_ring(messages.plain(messages.NOTHING_RECEIVED))

    def on_report(self, address: int, report: Report) -> None:
        """Take a report of a node.  Those that are not of the start don't matter here."""
        match report:
            case Identity():
                if self.phase is Phase.IDENTIFYING:
                    self.types[address] = report.node_type
            case Accepted() | Refused() if self.phase not in _BEFORE_ITEMS:
                self.items.on_acknowledge(address, report)
                self._go_on_if(Phase.CONFIGURING)
            case Running():
                self._not_running.discard(address)
            case InputChanged() if self.items.on_input(address, report):
                self._go_on_if(Phase.READING)
            case Trouble() if self.phase is Phase.CONFIGURING and report.details[0] == messages.UNALLOWED_COMMAND:
                self.items.refusals.add(messages.plain(messages.INITIALISATION_REFUSED))

    def _go_on_if(self, phase: Phase) -> None:
        if self.phase is phase:
            self._go_on_waiting()

    # ---- the phases

    def _begin_waiting(self) -> None:
        self._is_closed = False

    def _are_all_there(self) -> bool:
        return self._is_closed and types_of(self._nodes).keys() <= set(self.addresses)

    def _finish_waiting(self, is_done: bool) -> None:
        if not self._is_closed:
            self.fail_ring(messages.plain(messages.NOTHING_RECEIVED))

    def _begin_identifying(self) -> None:
        self.types.clear()
        self._outbox.put(BROADCAST, Identify())

    def _are_identified(self) -> bool:
        return all(address in self.types for address in self.addresses)

    def _finish_identifying(self, is_done: bool) -> None:
        mistakes = list(ring_mistakes(self._nodes, self.addresses, self.types, self._settings.most_nodes))
        if mistakes:
            self.fail_ring(*mistakes)
        lacking = nodes_without_items(self._nodes, self.addresses)
        if lacking:
            self._fail_nodes(lacking)
        if self.phase is not Phase.FAILED:
            self.active = active_addresses(self._nodes, self.addresses)
            self._say_all(messages.EMPTY_RING_CHECKED)
            if self.active:
                self._say_all(messages.RING_CHECKED, messages.NODES_READY)
            else:
                self._say_all(messages.READY_WITHOUT_NODES)

    def _fail_nodes(self, lacking: Sequence[messages.Message]) -> None:
        """Show each NODE of which nothing is on the ring; where the ring is not empty, a last error follows."""
        text = "" if self.addresses else messages.ALL_NODES_INACTIVE
        for code, details in lacking:
            self._say(code, details, text)
        if self.addresses:
            self._say(messages.NODE_WITHOUT_ITEMS, (), messages.NODE_INIT_ERROR)
        self.phase = Phase.FAILED

    def _begin_configuring(self) -> None:
        self.items.begin(self.active, self.types)

    def _are_configured(self) -> bool:
        return self.items.are_acknowledged()

    def _finish_configuring(self, is_done: bool) -> None:
        refusals = self.items.refusals
        if not is_done:
            refusals.add(messages.plain(messages.CONFIGURATION_UNANSWERED))
        if refusals:
            self.fail(*sorted(refusals))
        elif self._has(NodeType.SMART_IO):
            self._say_all(messages.SMART_IO_CONFIGURED)

    def _begin_starting(self) -> None:
        self._not_running = set(self.active)
        if self.active:
            self._outbox.put(BROADCAST, Run())

    def _are_running(self) -> bool:
        return not self._not_running

    def _finish_starting(self, is_done: bool) -> None:
        if not is_done:
            self.fail(messages.plain(messages.RUN_UNANSWERED))
        elif self._has(NodeType.SMART_IO):
            self._say_all(messages.SMART_IO_RUNNING)

    def _begin_reading(self) -> None:
        """The inputs of nodes that run are under way already."""

    def _are_read(self) -> bool:
        return not self.items.unread

    def _finish_reading(self, is_done: bool) -> None:
        """An input without a value is an error, but none that stops the PAM (07..E021)."""
        if not is_done:
            address, item = next(iter(self.items.unread))
            self._say(messages.READ_TIMEOUT, (address, item, 0), "")
        elif self._has(NodeType.SMART_IO):
            self._say_all(messages.INPUTS_RECEIVED)
        if self._has(NodeType.ST1):
            self._say_all(messages.ST1_IO_CONFIGURED)

    def _has(self, node_type: NodeType) -> bool:
        return any(self.types[address] is node_type for address in self.active)

    def _say_all(self, *codes: str) -> None:
        for code in codes:
            self._say(code, (), "")


_BEFORE_ITEMS: Final = (Phase.WAITING, Phase.IDENTIFYING)


class Step(NamedTuple):
    """One phase: how it begins, when it is done, how long it may take, how it ends, and what follows."""

    begin: Callable[[StartUp], None]
    is_done: Callable[[StartUp], bool]
    timeout_ns: Callable[[StartUp], int]
    finish: Callable[[StartUp, bool], None]
    """Called with False after a time-out.  It may fail."""
    following: Phase


_S = StartUp
STEPS: Final = {
    Phase.WAITING: Step(
        _S._begin_waiting, _S._are_all_there, lambda s: s._settings.boot_ns, _S._finish_waiting, Phase.IDENTIFYING
    ),
    Phase.IDENTIFYING: Step(
        _S._begin_identifying,
        _S._are_identified,
        lambda s: s._settings.identify_ns,
        _S._finish_identifying,
        Phase.CONFIGURING,
    ),
    Phase.CONFIGURING: Step(
        _S._begin_configuring,
        _S._are_configured,
        lambda s: s._settings.acknowledge_ns,
        _S._finish_configuring,
        Phase.STARTING,
    ),
    Phase.STARTING: Step(
        _S._begin_starting, _S._are_running, lambda s: s._settings.acknowledge_ns, _S._finish_starting, Phase.READING
    ),
    Phase.READING: Step(
        _S._begin_reading,
        _S._are_read,
        lambda s: s._settings.first_value_ns + s.items.longest_first_value_ns(),
        _S._finish_reading,
        Phase.RUNNING,
    ),
}
