"""The option negotiation automaton (RFC 1661 chapter 4) with its restart timer and counter; LCP and IPCP have one each.

It knows nothing of packets: it calls its layer for every action, and the layer reports what came as events.
"""

from collections import deque
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.ppp.packets import Packet
from fieldrig_devices.ppp.transitions import TRANSITIONS, Action, Event, PppState

MOST_TERMINATES: Final = 2
"""Terminate-Requests without an answer before a layer is finished (RFC 1661 4.6, Max-Terminate)."""
TIMED: Final = frozenset({PppState.CLOSING, PppState.STOPPING, PppState.REQ_SENT, PppState.ACK_RCVD, PppState.ACK_SENT})
"""The states in which the restart timer runs (RFC 1661 4.2)."""


class Layer(Protocol):
    """The layer that carries out the actions of RFC 1661 4.4."""

    def layer_up(self, event: Event) -> None: ...
    def layer_down(self, event: Event) -> None: ...
    def layer_finished(self, event: Event) -> None: ...
    def send_request(self) -> None: ...
    def send_terminate_request(self) -> None: ...

    def send_answer(self, answer: Packet) -> None:
        """Send a Configure-Ack, -Nak or -Reject or an Echo-Reply that came with the event."""

    def send_terminate_ack(self, cause: Packet) -> None: ...
    def send_code_reject(self, cause: Packet) -> None: ...


class Automaton:
    def __init__(self, clock: Clock, layer: Layer, restart_ns: int, most_requests: int) -> None:
        self.state = PppState.INITIAL
        self._clock, self._layer = clock, layer
        self._restart_ns, self._most_requests = restart_ns, most_requests
        self._count = 0
        self._timer = Alarm(self._clock)
        self._waiting: deque[tuple[Event, Packet | None, Packet | None]] = deque()
        self._is_busy = False

    def handle(self, event: Event, cause: Packet | None = None, answer: Packet | None = None) -> None:
        """Take one step of the table; `cause` is the packet that came, `answer` the reply to it.

        An event that an action causes in its turn is handled after the step.  KeyError for a pair that cannot be.
        """
        self._waiting.append((event, cause, answer))
        if self._is_busy:
            return
        self._is_busy = True
        try:
            while self._waiting:
                self._step(*self._waiting.popleft())
        finally:
            self._is_busy = False

    def _step(self, event: Event, cause: Packet | None, answer: Packet | None) -> None:
        actions, state = TRANSITIONS[self.state, event]
        for action in actions:
            self._act(action, event, actions, cause, answer)
        self.state = state
        if state not in TIMED:
            self._timer.stop()

    def _act(
        self,
        action: Action,
        event: Event,
        actions: tuple[Action, ...],
        cause: Packet | None,
        answer: Packet | None,
    ) -> None:
        if action in REPORTS:
            REPORTS[action](self._layer, event)
        elif action is Action.INIT_COUNT:
            ends = Action.SEND_TERMINATE_REQUEST in actions
            self._count = MOST_TERMINATES if ends else self._most_requests
        elif action is Action.ZERO_COUNT:
            self._count = 0
            self._start_timer()
        elif action in REQUESTS:
            self._count -= 1
            self._start_timer()
            REQUESTS[action](self._layer)
        elif action in REPLIES:
            assert cause is not None, event
            REPLIES[action](self._layer, cause)
        elif answer is not None:  # an Echo-Reply or a Discard-Request has none
            self._layer.send_answer(answer)

    def _start_timer(self) -> None:
        self._timer.after(self._restart_ns, self._on_time)

    def _on_time(self) -> None:
        self.handle(Event.TIMEOUT if self._count > 0 else Event.LAST_TIMEOUT)


REPORTS: Final[Mapping[Action, Callable[[Layer, Event], None]]] = {
    Action.LAYER_UP: lambda layer, event: layer.layer_up(event),
    Action.LAYER_DOWN: lambda layer, event: layer.layer_down(event),
    Action.LAYER_STARTED: lambda layer, event: None,  # the line belongs to the modem, which PPP does not dial
    Action.LAYER_FINISHED: lambda layer, event: layer.layer_finished(event),
}
REQUESTS: Final[Mapping[Action, Callable[[Layer], None]]] = {
    Action.SEND_REQUEST: lambda layer: layer.send_request(),
    Action.SEND_TERMINATE_REQUEST: lambda layer: layer.send_terminate_request(),
}
REPLIES: Final[Mapping[Action, Callable[[Layer, Packet], None]]] = {
    Action.SEND_TERMINATE_ACK: lambda layer, cause: layer.send_terminate_ack(cause),
    Action.SEND_CODE_REJECT: lambda layer, cause: layer.send_code_reject(cause),
}
