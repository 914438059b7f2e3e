"""Frames of any kind in any order: nothing raises, and nothing gets past the login."""

from hypothesis import example, given
from hypothesis import strategies as st
from ppp_bench import CALLER_END, CONTROLLER_END, PAP_LOGIN, PppBench, framed

from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import PppSettings

PROTOCOLS = ["c021", "c023", "8021", "0021", "c223", "80fd", "8057", "002d", "ffff", "0000"]
OPTIONS = ["", "0506aabbccdd", "0304c023", "0305c22305", "0104ffff", "0306bec86465", "030600000000", "07020802", "0105"]
Step = str | tuple[int, int] | int
PAST_LOGIN = frozenset({Phase.NETWORK, Phase.RUNNING})


@st.composite
def packets(draw: st.DrawFn) -> str:
    """A packet of one of the protocols in hex, mostly well formed."""
    code, identifier = draw(st.integers(0, 15)), draw(st.integers(0, 6))
    data = draw(st.sampled_from(OPTIONS).map(bytes.fromhex) | st.binary(max_size=20))
    length = draw(st.just(4 + len(data)) | st.integers(0, 0xFFFF))
    return draw(st.sampled_from(PROTOCOLS)) + f"{code:02x}{identifier:02x}{length:04x}" + data.hex()


@st.composite
def answers(draw: st.DrawFn) -> tuple[int, int]:
    """An answer to one of the last frames sent, by its place, with a code of its own."""
    return draw(st.integers(1, 3)), draw(st.integers(1, 11))


STEPS = st.lists(packets() | answers() | st.integers(0, 20) | st.sampled_from(["up", "down", "close"]), max_size=40)


def play(bench: PppBench, steps: list[Step]) -> None:
    """Play the peer: packets in hex, answers with the data of a sent frame, seconds to wait, and the user's calls."""
    sent: list[str] = []
    for step in steps:
        if isinstance(step, int):
            sent += bench.wait_s(step)
        elif isinstance(step, tuple):
            place, code = step
            if len(sent) >= place and len(sent[-place]) >= 12:
                frame = sent[-place]
                sent += bench.hear(frame[:4] + f"{code:02x}" + frame[6:])
        elif step in ("up", "down", "close"):
            getattr(bench.link, step)(bench.now_ns)
            sent += bench.take()
        else:
            sent += bench.hear(step)
        check(bench)


def check(bench: PppBench) -> None:
    due_ns = bench.link.next_ns()
    assert due_ns is None or due_ns >= bench.now_ns
    assert (bench.phase() is Phase.RUNNING) == (bench.link.local_address.packed != bytes(4))


@given(STEPS)
@example(["up", (1, 2), "c02101010004", "c02302010005" + "00", "80210101000a0306bec86465", "0021" + "45" * 20])
@example(["up", "80210101000a0306bec86465", "c02302010005" + "00", (1, 2), "802102010004"])
@example(["up", (1, 2), "c02101010004", "c0210104000a0506aabbccdd", (1, 2), "0021" + "45" * 20])
def test_no_order_of_frames_gets_past_the_login(steps: list[Step]) -> None:
    """The peer does not know the password, so no packet reaches IP, and none is sent."""
    bench = PppBench()
    play(bench, steps)
    assert bench.packets == []
    assert PAST_LOGIN.isdisjoint(bench.phases)
    assert not any(attempt.is_accepted for attempt in bench.attempts)
    assert not bench.link.send_ip(bench.now_ns, b"\x45")


@given(STEPS, st.sampled_from([CONTROLLER_END, CALLER_END, PppSettings(), PppSettings(mru=128)]))
def test_any_order_of_frames_does_no_harm(steps: list[Step], settings: PppSettings) -> None:
    bench = PppBench(settings)
    play(bench, ["up", (1, 2), "c02101010004", PAP_LOGIN, *steps])
    bench.wait_s(1)
    assert bench.phases == [] or bench.phases[-1] is bench.phase()


@given(st.lists(st.binary(max_size=100), max_size=20))
def test_any_bytes_do_no_harm(chunks: list[bytes]) -> None:
    bench = PppBench().up()
    for chunk in chunks:
        bench.link.receive(bench.now_ns, chunk)
        bench.wait_s(1)
    bench.link.down(bench.now_ns)
    assert bench.up().phase() is Phase.ESTABLISH


@given(st.binary(min_size=2, max_size=60), st.sampled_from(PROTOCOLS))
def test_any_payload_of_a_known_protocol_does_no_harm_to_a_running_link(payload: bytes, protocol: str) -> None:
    bench = PppBench().run()
    bench.link.receive(bench.now_ns, framed(protocol + payload.hex()))
    bench.wait_s(10)
    assert bench.phase() in Phase
