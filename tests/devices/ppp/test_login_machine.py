"""Authentication cannot be passed by any order of frames: callers as a state machine, with and without the password."""

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from ppp_bench import PAP_LOGIN, PppBench

from fieldrig_devices.ppp.phases import Phase

PAST_LOGIN = frozenset({Phase.NETWORK, Phase.RUNNING})
WRONG_LOGINS = (
    "c023 01 02 000e 03 6c6162 05 66616c7363",
    "c023 01 02 0006 00 00",
    "c023 02 01 0005 00",  # an answer, as if we had asked to log in
    "c223 01 01 0009 04 01020304 6c6162",  # CHAP
    "c223 03 01 0004",
)
BEYOND = (
    "8021 01 01 000a 0306 bec86465",
    "8021 02 01 000a 0306 bec86464",
    "8021 03 01 000a 0306 bec86464",
    "0021" + "45" * 20,
    "80fd 01 01 0004",
    "8057 01 01 0004",
)
LCP = (
    "c021 01 07 0004",
    "c021 01 08 0008 0304 c023",
    "c021 04 01 0008 0304 c023",
    "c021 03 01 0009 0305 c22305",
    "c021 05 09 0004",
    "c021 06 09 0004",
    "c021 08 01 000a c023 0101 0004",
    "c021 09 01 0008 00000000",
)


class Callers(RuleBasedStateMachine):
    """The peer of one controller, call after call."""

    def __init__(self) -> None:
        super().__init__()
        self.bench = PppBench()
        self.sent: list[str] = []
        self.has_password = False
        """True if the right login was sent in this call, so that the way beyond may be open."""
        self.seen = 0

    @rule()
    def call(self) -> None:
        if self.bench.phase() is Phase.DEAD:
            self.has_password = False
            self.sent.clear()
        self.bench.link.up(self.bench.now_ns)
        self.sent += self.bench.take()

    @rule()
    def hang_up(self) -> None:
        self.bench.link.down(self.bench.now_ns)
        self.bench.take()

    @rule(place=st.integers(1, 4), code=st.sampled_from([2, 3, 4]))
    def answer(self, place: int, code: int) -> None:
        """Answer one of the last frames, with what it contains."""
        if len(self.sent) >= place and len(self.sent[-place]) >= 12:
            frame = self.sent[-place]
            self.hear(frame[:4] + f"{code:02x}" + frame[6:])

    @rule(frame=st.sampled_from([*WRONG_LOGINS, *BEYOND, *LCP]))
    def hear(self, frame: str) -> None:
        self.sent += self.bench.hear(frame)

    @rule(seconds=st.sampled_from([1, 3, 10, 60]))
    def wait(self, seconds: int) -> None:
        self.sent += self.bench.wait_s(seconds)

    @rule()
    def log_in(self) -> None:
        """Send the right login, which opens the way for this call only."""
        self.has_password |= self.bench.phase() is not Phase.DEAD
        self.hear(PAP_LOGIN)

    @invariant()
    def no_phase_beyond_the_login_without_the_password(self) -> None:
        assert self.has_password or self.bench.phase() not in PAST_LOGIN

    @invariant()
    def no_packet_passes_without_the_password(self) -> None:
        assert self.has_password or len(self.bench.packets) == self.seen
        self.seen = len(self.bench.packets)


TestCallers = Callers.TestCase
TestCallers.settings = settings(deadline=None, stateful_step_count=40)
