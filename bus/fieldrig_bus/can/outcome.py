"""The outcome of one frame on the wire, or of an error without a frame, as facts.

Source: ISO 11898-1:2015, 12.1.4 (fault confinement).  An outcome changes nothing: `settlement` carries it over to the
members and counters of the bus once its end has come.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

from fieldrig_bus.can.acceptance import received
from fieldrig_bus.can.bits import Place, Stream, stream
from fieldrig_bus.can.confinement import SUSPEND_BITS, Node, Role
from fieldrig_bus.can.error_counters import PASSIVE, REC_AFTER_PASSIVE
from fieldrig_bus.can.injection import Injection
from fieldrig_bus.can.length import INTERMISSION_BITS
from fieldrig_bus.can.member import Member, Request
from fieldrig_bus.can.notices import CanError, ErrorKind

Nodes = list[tuple[Member | None, Node]]
"""Controllers that take part; without a member it is the one that always acknowledges."""


@dataclass(slots=True)
class Outcome:
    """The events between the ticks `start` and `end`; the bus is free at tick `free`."""

    start: int
    senders: tuple[Request, ...]
    losers: tuple[Request, ...]
    """Requests that lose arbitration."""
    nodes: Nodes
    wire: Stream
    """The bits on the bus while nothing is wrong."""
    injection: Injection
    is_smooth: bool = False
    """Nothing is wrong.  Then there are no nodes and no wire, but `touched`: the sender and the receivers."""
    touched: list[Member] = field(default_factory=list)
    end: int = 0
    free: int = 0

    @property
    def length(self) -> int:
        """Bits of the frame."""
        return self.senders[0].bits - INTERMISSION_BITS if self.is_smooth else len(self.wire.bits)

    @property
    def is_troubled(self) -> bool:
        """True if the frame has to be played bit by bit."""
        receivers = [node for _, node in self.nodes if not node.is_transmitter]
        return (
            not receivers
            or self.injection.disturbance.first() is not None
            or any(node.fails is not None for node in receivers)
            or any(node.stream is not None and node.stream.bits != self.wire.bits for _, node in self.nodes)
        )

    def mark_all_done(self) -> None:
        """Every node has sent or received the whole frame."""
        for _, node in self.nodes:
            node.role, node.done, node.is_sent = Role.DONE, self.length, node.is_transmitter

    @property
    def is_sent(self) -> bool:
        """True if a transmitter has sent its whole frame."""
        return not self.nodes or any(node.is_sent for _, node in self.nodes)

    def ticks(self, last: int, nominal: int, switched: int) -> int:
        """The duration, if the nodes are done with bit `last`."""
        wire = self.wire
        if self.is_smooth:
            return self.senders[0].ticks - INTERMISSION_BITS * nominal
        if self.senders and self.is_sent:
            return wire.ticks(len(wire.bits), nominal, switched)
        seen = min((node.at for _, node in self.nodes if node.kind is not None), default=last) + 1
        seen = min(seen, last)
        return wire.ticks(seen, nominal, switched) + (last - seen) * nominal

    @property
    def lone_sender(self) -> Member | None:
        """The error passive transmitter that was alone on the bus and got no acknowledgement."""
        is_lone = len(self.nodes) == 1 == len(self.senders) and not self.is_sent
        return self.senders[0].member if is_lone and self.senders[0].member.tec >= PASSIVE else None

    def members(self) -> Iterator[tuple[Member, Node]]:
        """The nodes that belong to members."""
        return ((member, node) for member, node in self.nodes if member is not None)

    def is_sender(self, member: Member) -> bool:
        """True if a frame of this member was on the wire."""
        return any(request.member is member for request in self.senders)

    def is_accepted(self, node: Node) -> bool:
        """True if it received the whole frame.  From the last but one bit of the end of frame on that is final."""
        return node.kind is None and not node.is_transmitter and node.done == self.length

    def hears(self, member: Member, node: Node | None) -> bool:
        """True if the member gets the frame; `node` is its part in it, if it took one."""
        if node is not None:
            return self.is_accepted(node)
        is_listening = not self.nodes or (member.is_listen_only and member.skew is None)
        return self.is_sent and is_listening and not member.is_off

    def counters(self, node: Node) -> tuple[int, int]:
        """TEC and REC after it."""
        if node.is_sent:
            return max(0, node.tec - 1), node.rec
        if self.senders and self.is_accepted(node):
            return node.tec, max(0, min(node.rec - 1, REC_AFTER_PASSIVE))
        return node.tec, node.rec

    def bits_to_wait(self, node: Node, counters: tuple[int, int]) -> int:
        """Bits for which a sender has to wait after the intermission."""
        behind = max(0, node.done - self.length) if self.is_sent else 0
        return behind + suspension(*counters)

    def lost_at(self, loser: Request) -> int:
        """The first bit at which this request sent a recessive bit and saw a dominant one."""
        pairs = zip(stream(loser.frame).bits, stream(self.senders[0].frame).bits, strict=False)
        return next((bit for bit, (ours, theirs) in enumerate(pairs) if ours > theirs), 0)

    def error(
        self, member: Member, error_kind: ErrorKind, bit: int, *, is_transmitter: bool, is_given_up: bool
    ) -> CanError:
        """An error as this member's controller reports it."""
        place = Place(self.wire.places[bit]) if bit < len(self.wire.places) else Place.INTERMISSION
        identifier = received(self.senders[0].frame) if self.senders else 0
        return CanError(error_kind, place, bit, identifier, is_transmitter, is_given_up, member.tec, member.rec)


def suspension(tec: int, rec: int) -> int:
    """Bits of suspend transmission after a frame, which only error passive nodes observe."""
    return SUSPEND_BITS if max(tec, rec) >= PASSIVE else 0
