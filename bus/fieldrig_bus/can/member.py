"""The records of the bus model: one for each member, and one for each frame that waits."""

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
    """The setup of one member's CAN controller."""

    one_shot: bool = Field(default=False, description="a frame that meets an error or loses arbitration is given up")
    listen_only: bool = Field(default=False, description="it receives, but neither sends nor acknowledges")
    classical: bool = Field(default=False, description="it knows no CAN FD, and answers FD frames with error frames")


class Member:
    """One controller on the bus, with its queue and its error counters."""

    __slots__ = (
        "asked", "attempts", "copy", "error_frames", "filters", "frames", "is_classical",
        "is_gone", "is_listen_only", "is_one_shot", "name", "order", "queue", "rec", "receivers",
        "resume", "retransmissions", "skew", "state", "tec", "wants_errors", "wants_own", "wants_state",
    )  # fmt: skip

    def __init__(self, name: str, order: int, controller: Controller) -> None:
        self.name, self.order = name, order
        self.filters: Filters | None = ()
        self.wants_own = self.wants_errors = self.wants_state = False
        self.queue: deque[Request] = deque()
        self.receivers: dict[int, tuple[str, ...]] = {}
        """Receivers of this member's frames by priority, while nothing is wrong on the bus."""
        self.is_one_shot, self.is_listen_only = controller.one_shot, controller.listen_only
        self.is_classical = controller.classical
        self.is_gone = False
        """It has left the bus, and its frame is still on the wire."""
        self.skew: Fraction | None = None
        """The bit time of the member relative to that of the bus, if it has declared a different bit rate."""

        # error handling, from here on
        self.tec = self.rec = 0
        self.state = CanState.ACTIVE
        self.resume = 0
        """The tick before which it may not start a frame (suspend transmission)."""
        self.attempts = 0
        """Failed attempts at the first frame of the queue."""
        self.copy = False
        """The first frame was sent, and an injected fault sends it a second time."""
        self.frames = self.error_frames = self.retransmissions = 0
        self.asked = 0
        """Frames it has asked for while an injected fault may delay them."""

    @property
    def is_off(self) -> bool:
        """True in bus-off."""
        return self.state is CanState.BUS_OFF

    @property
    def may_send(self) -> bool:
        """True if it may drive the bus: send, acknowledge, and signal errors."""
        return self.state is not CanState.BUS_OFF and not self.is_listen_only

    @property
    def is_plain(self) -> bool:
        """True if nothing about this member needs the step-by-step way through the model."""
        return not (self.tec or self.rec or self.is_one_shot or self.is_listen_only or self.is_classical) and (
            self.state is CanState.ACTIVE and not self.copy and not self.is_gone and self.skew is None
        )

    def is_first(self, request: "Request") -> bool:
        """True if `request` is at the head of the queue."""
        return bool(self.queue) and self.queue[0] is request

    def give_up(self) -> None:
        """Drop the first frame of the queue without sending it."""
        self.queue.popleft()
        self.attempts = 0

    def count_failed(self, attempts: int) -> None:
        """Count failed attempts that changed no error counter."""
        self.attempts += attempts
        self.retransmissions += attempts
        self.error_frames += attempts

    def state_delivery(self, time_ns: int) -> Delivery[Any]:
        """The notice of the present state, for the trace and for the member if it wants it."""
        notice = BusState(self.state, self.tec, self.rec)
        return Delivery(time_ns, self.name, notice, (self.name,) if self.wants_state else ())


class Request(NamedTuple):
    """A frame that waits.  Only the first one of each member takes part, so the first two fields never tie."""

    priority: int
    order: int
    asked: int  # tick
    ticks: int
    bits: int
    member: Member
    frame: CanFrame
