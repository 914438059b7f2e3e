"""A PAM's end of its ring.

The PAM calls `take` at the beginning of each basic cycle and `give` at its end.  `start_up` brings the ring to work;
from then on this end tells which errors stop it (section 14.4 of the digest of the system).  A node that comes back is
not taken up again; the PAM has to be reset (G-41).
"""

import logging
from collections import deque
from collections.abc import Iterable, Sequence

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.ring.pam.message import GROUP, Frames, Reception, Reports, RingMessage
from fieldrig_devices.pamring import codec, messages
from fieldrig_devices.pamring.configuration import Say
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.ends import ReportHandler
from fieldrig_devices.pamring.frames import Accepted, Configuration, Identity, Order, Refused, Running, Trouble
from fieldrig_devices.pamring.outbox import Outbox
from fieldrig_devices.pamring.settings import RingLimits
from fieldrig_devices.pamring.start_up import Phase, StartUp

log = logging.getLogger(__name__)

OF_THE_START = frozenset({Identity, Accepted, Refused, Running})
"""Reports that the objects of the PAM don't see."""


class RingMaster:
    """The ring, as the PAM sees it; it is the `PamPort` of the PAM's objects."""

    def __init__(
        self,
        clock: Clock,
        link: Link[RingMessage],
        settings: RingLimits,
        nodes: Sequence[DeclaredNode],
        handler: ReportHandler,
        say: Say,
    ) -> None:
        """`handler` takes the reports of active nodes; `say` shows messages."""
        self.settings = settings
        self._send, self._handler, self._say = link.send, handler, say
        self._outbox = Outbox(settings.frames_per_cycle, settings.sending_fifo, self._on_full)
        self._start = StartUp(clock, settings, nodes, self._outbox, say)
        self._number = 0
        self._heard: list[Reports] = []
        self._fifo: deque[tuple[int, bytes]] = deque()
        """The reception FIFO: reports that are not handled yet."""
        link.on_receive(self._on_message, ["master"])

    @property
    def phase(self) -> Phase:
        return self._start.phase

    @property
    def active(self) -> frozenset[int]:
        """The addresses of the nodes that the application works with.  It is empty until they are identified."""
        return self._start.active

    def configure(self, address: int, items: Iterable[Configuration]) -> None:
        """Add items of a node, before `start`.  They are configured in this order, if the node is active."""
        self._start.items.of.setdefault(address, []).extend(items)

    def start(self) -> None:
        """Power on."""
        self._start.begin()

    # ---- sending

    def send(self, address: int, order: Order) -> None:
        self._outbox.put(address, order)

    def send_to_group(self, group: int, order: Order) -> None:
        self._outbox.put(GROUP + group, order)

    def _on_full(self) -> None:
        self._say(messages.RING_FIFO_FULL, (0, 0, 0), "")

    def give(self) -> None:
        """End a basic cycle: the frames that are due leave.  On a ring that has stopped they are lost."""
        if self._start.phase in _SILENT:
            self._outbox.clear()
        else:
            number, self._number = self._number, self._number + 1
            self._send(Frames(number, self._outbox.take()))

    # ---- receiving

    def _on_message(self, message: RingMessage) -> None:
        if isinstance(message, Reports):
            self._heard.append(message)

    def take(self) -> None:
        """Begin a basic cycle: handle what the ring has brought."""
        heard, self._heard = self._heard, []
        for reports in heard:
            if self._start.phase in _SILENT:
                return
            self._on_ring(reports)
        if self._fifo:
            self._handle()
        if self._start.phase is not Phase.RUNNING:
            self._start.advance()

    def _on_ring(self, reports: Reports) -> None:
        if self._start.phase is not Phase.RUNNING:
            self._start.on_ring(reports)
        elif reports.reception or reports.addresses != self._start.addresses:
            self._on_change(reports)
        for address, buffer in reports.reports:
            self._receive(address, buffer)

    def _on_change(self, reports: Reports) -> None:
        """The ring that runs is not as before."""
        if reports.reception is Reception.NO_CARRIER:
            is_asic = self.settings.interface == "asic"
            interrupted = (messages.LINK_INTERRUPTED, (reports.place, 0, 0))
            self._fail(interrupted if is_asic else messages.plain(messages.NOTHING_RECEIVED))
        elif reports.reception is Reception.CRC_ERROR:
            self._fail((messages.CRC_ERROR, (reports.place, 0, 0)))
        else:
            lost = set(self._start.addresses) - set(reports.addresses)
            if lost & self._start.active:
                self._fail((messages.CRC_ERROR, (self._behind(lost), 0, 0)))
            self._start.addresses = reports.addresses

    def _behind(self, lost: set[int]) -> int:
        """The address behind a node that was switched off on a closed ring: its frame there was damaged (B.7)."""
        before = self._start.addresses
        first = min(before.index(address) for address in lost)
        return next((address for address in before[first:] if address not in lost), 0)

    def _receive(self, address: int, buffer: bytes) -> None:
        try:
            reports = codec.split(buffer)
        except ValueError as fault:
            log.debug("from node %d: %s", address, fault)
            return
        for contents in reports:
            if len(self._fifo) >= self.settings.reception_fifo:
                self._fail((messages.OVERLOADED, (messages.FIFO_ADDRESS, address, 0)))
                return
            self._fifo.append((address, contents))

    def _fail(self, message: messages.Message) -> None:
        if self._start.phase is not Phase.FAILED:
            log.info("the ring has failed: %s", message[0])
            self._start.fail_ring(message)
        self._fifo.clear()

    def _handle(self) -> None:
        """Handle as many reports as a basic cycle has time for."""
        fifo = self._fifo
        for _ in range(min(len(fifo), self.settings.reports_per_cycle)):
            address, contents = fifo.popleft()
            self._on_report(address, contents)

    def _on_report(self, address: int, contents: bytes) -> None:
        try:
            report = codec.decode_report(contents)
        except ValueError as fault:
            log.debug("from node %d: %s", address, fault)
            return
        start = self._start
        if start.phase is not Phase.RUNNING:
            start.on_report(address, report)
        if address not in start.active or report.__class__ in OF_THE_START:
            return
        if isinstance(report, Trouble):
            code, details = messages.of_trouble(address, report)
            self._say(code, details, "")
        self._handler.on_report(address, report)


_SILENT = (Phase.OFF, Phase.FAILED)
