"""A caller of `fieldrig dial` opposite a modem and a controller by hand, in virtual time."""

from collections import deque
from collections.abc import Callable

from dial_peer import FarEnd

from fieldrig.clock import S
from fieldrig_devices.dial.caller import Caller, Plan
from fieldrig_devices.ppp.settings import Login

LOGIN = Login.of("service", "secret")
PLAN = Plan("4711", login=LOGIN)


class Bench:
    def __init__(self, plan: Plan = PLAN, answers: dict[bytes, bytes] | None = None) -> None:
        self.now_ns = 0
        self.said: list[str] = []
        self.line: list[tuple[int, str, bytes]] = []
        """Everything on the line: instant, sender and bytes."""
        self._flying: deque[tuple[Callable[[int, bytes], None], bytes]] = deque()
        self.far = FarEnd(lambda data: self._fly("modem", self.caller.receive, data), answers)
        magic = iter(range(1, 1000))
        self.caller = Caller(
            plan, lambda: next(magic), lambda data: self._fly("caller", self.far.receive, data), self.said.append
        )
        self.caller.start(0)

    def _fly(self, sender: str, receive: Callable[[int, bytes], None], data: bytes) -> None:
        self.line.append((self.now_ns, sender, data))
        self._flying.append((receive, data))

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Let time pass, at most until the condition is true."""
        end_ns = self.now_ns + round(seconds * S)
        while not until():
            while self._flying:
                receive, data = self._flying.popleft()
                receive(self.now_ns, data)
            due = [due for part in (self.caller, self.far) if (due := part.next_ns()) is not None]
            if not due or min(due) > end_ns:
                self.now_ns = end_ns
                return
            self.now_ns = max(min(due), self.now_ns)
            self.caller.advance(self.now_ns)
            self.far.advance(self.now_ns)

    def failure(self) -> str:
        assert self.caller.failure is not None
        return self.caller.failure.what
