"""What the bus model keeps of each member and of each frame that waits."""

from collections import deque
from fractions import Fraction
from typing import Any, NamedTuple

from pydantic import Field

from fieldrig.bus import Delivery
from fieldrig.settings import Settings
from fieldrig_bus.can.acceptance import Filters
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import BusState, CanState


class Controller(Settings):
    """How one member's controller is set up."""

    one_shot: bool = Field(default=False, description="a frame that meets an error or loses arbitration is given up")
    listen_only: bool = Field(default=False, description="hears, but neither sends nor acknowledges")
    classical: bool = Field(default=False, description="knows no CAN FD: it answers FD frames with error frames")


class Member:
    __slots__ = (
        "asked", "attempts", "copy", "count_from", "discarded", "error_frames", "filters", "frames", "is_classical",
        "is_gone", "is_listen_only", "is_one_shot", "name", "order", "queue", "rec", "receivers", "recovering",
        "resume", "retransmissions", "skew", "state", "tec", "wants_errors", "wants_own", "wants_state",
    )  # fmt: skip

    def __init__(self, name: str, order: int, controller: Controller) -> None:
        self.name, self.order = name, order
        self.filters: Filters | None = ()
        self.wants_own = self.wants_errors = self.wants_state = False
        self.queue: deque[Request] = deque()
        self.receivers: dict[int, tuple[str, ...]] = {}
        """Who hears this member, by the priority of the frame, while all is well."""
        self.is_one_shot, self.is_listen_only = controller.one_shot, controller.listen_only
        self.is_classical = controller.classical
        self.is_gone = False
        self.skew: Fraction | None = None
        """Its bit time in those of the bus, if it has said that it has another bit rate."""

        # error handling, from here on
        self.tec = self.rec = 0
        self.state = CanState.ACTIVE
        self.resume = 0
        """Tick before which it may not start: suspend transmission."""
        self.recovering: int | None = None
        """In bus-off: so many times 11 recessive bits are missing; None until recovery is asked for."""
        self.count_from = 0
        """Tick from which they are counted."""
        self.attempts = 0
        """At the first frame of the queue, in vain."""
        self.copy = False
        """The first frame was sent and goes once more, as a fault wants it."""
        self.frames = self.error_frames = self.retransmissions = self.discarded = 0
        self.asked = 0
        """Frames, while a fault may keep them back."""

    @property
    def is_off(self) -> bool:
        return self.state is CanState.BUS_OFF

    @property
    def may_send(self) -> bool:
        """And so acknowledge, and signal errors."""
        return self.state is not CanState.BUS_OFF and not self.is_listen_only

    @property
    def is_plain(self) -> bool:
        """Nothing about it that the fast way through the model doesn't know."""
        return not (self.tec or self.rec or self.is_one_shot or self.is_listen_only or self.is_classical) and (
            self.state is CanState.ACTIVE and not self.copy and not self.is_gone and self.skew is None
        )

    def is_first(self, request: "Request") -> bool:
        return bool(self.queue) and self.queue[0] is request

    def count_errors(self, attempts: int) -> None:
        """So many attempts in vain, none of which changed a counter of fault confinement."""
        self.attempts += attempts
        self.retransmissions += attempts
        self.error_frames += attempts

    def tell_state(self, time_ns: int) -> Delivery[Any]:
        notice = BusState(self.state, self.tec, self.rec)
        return Delivery(time_ns, self.name, notice, (self.name,) if self.wants_state else ())


class Request(NamedTuple):
    """A frame that waits.  Of one member only the first takes part, so the first two fields never tie."""

    priority: int
    order: int
    asked: int  # tick
    ticks: int
    bits: int
    member: Member
    frame: CanFrame
