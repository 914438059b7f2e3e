"""Whole transfers in virtual time: nothing is lost, doubled or out of order, whatever the line does to packets."""

from dataclasses import replace
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ip_line import CALLER, Line, Quality

from fieldrig.clock import MS, S
from fieldrig_devices.ip.tcp.connection import Ending
from fieldrig_devices.ip.tcp.states import TcpState

QUALITIES = st.builds(
    Quality,
    lost=st.floats(0, 0.15),
    doubled=st.floats(0, 0.3),
    damaged=st.floats(0, 0.05),
    delay_ns=st.integers(0, 400 * MS),
    jitter_ns=st.integers(0, 200 * MS),
)


def pattern(size: int, step: int) -> bytes:
    """Bytes that differ in most places, so that data at the wrong place are found."""
    return bytes((place * step + place // 251) & 0xFF for place in range(size))


@pytest.mark.long
@settings(deadline=None, max_examples=60)
@given(QUALITIES, st.integers(0, 2**32), st.integers(0, 6_000), st.integers(0, 6_000), st.sampled_from([68, 576, 1500]))
def test_both_directions_arrive_and_the_connection_ends(
    quality: Quality, seed: int, there: int, back: int, mtu: int
) -> None:
    line = Line(quality, seed=seed, mtu=mtu)
    caller, controller = line.connected()
    caller.connection.send(pattern(there, 7))
    controller.connection.send(pattern(back, 11))
    caller.connection.end()
    controller.connection.end()
    line.run()
    assert bytes(controller.received) == pattern(there, 7)
    assert bytes(caller.received) == pattern(back, 11)
    assert caller.endings == controller.endings == [Ending.COMPLETE]
    assert line.caller.connections == line.controller.connections == []


def test_a_clean_line_repeats_nothing() -> None:
    line = Line(mtu=1500, window=32_768)
    caller, controller = line.connected()
    caller.connection.send(bytes(100_000))
    line.run_for(10)
    data = [packet for _, sender, packet in line.packets if sender == CALLER and len(packet) > 40]
    assert len(controller.received) == 100_000
    assert sum(len(packet) - 40 for packet in data[0:]) == 100_000 + 4  # the SYN has an option of 4 bytes


@pytest.mark.long
@settings(deadline=None, max_examples=150)
@given(
    QUALITIES,
    st.integers(0, 2**32),
    st.sampled_from([68, 576, 1500]),
    st.sampled_from([100, 1000, 8192]),
    st.sampled_from([0, 1000, 10_000]),
)
def test_users_that_send_pause_and_resume_at_random_get_everything(
    quality: Quality, seed: int, mtu: int, window: int, bytes_per_s: int
) -> None:
    random = Random(seed)
    line = Line(replace(quality, bytes_per_s=bytes_per_s), seed=seed, mtu=mtu, window=window)
    users, sent = line.connected(), (bytearray(), bytearray())
    for _ in range(random.randint(1, 40)):
        end = random.randrange(2)
        connection = users[end].connection
        match random.choice(["send", "pause", "resume"]):
            case "send":
                data = random.randbytes(random.randint(1, 3000))
                connection.send(data)
                sent[end].extend(data)
            case "pause":
                connection.pause()
            case "resume":
                connection.resume()
        line.run_for(random.choice([0, 0.01, 1, 30]))
    for user in users:
        user.connection.resume()
        user.connection.end()
    line.run()
    assert (bytes(users[1].received), bytes(users[0].received)) == (bytes(sent[0]), bytes(sent[1]))
    assert users[0].endings == users[1].endings == [Ending.COMPLETE]


@pytest.mark.long
@pytest.mark.parametrize(("bytes_per_s", "repeated"), [(240, 10), (960, 10), (3840, 0), (11_520, 0)])
def test_a_slow_line_is_full_and_repeats_little(bytes_per_s: int, repeated: int) -> None:
    """2400 to 115,200 bit/s: the queue before the line grows, and the time-out with it.

    Where a segment takes longer than the first time-out, which is 1 s, some are repeated before the first measurement.
    """
    line = Line(Quality(bytes_per_s=bytes_per_s, delay_ns=50 * MS), mtu=1500, window=32_768)
    caller, controller = line.connected()
    begin_ns = line.now_ns
    size = bytes_per_s * 200
    caller.connection.send(bytes(size))
    while len(controller.received) < size:
        line.run_for(0.1)
    segments = [len(packet) for _, sender, packet in line.packets if sender == CALLER and len(packet) > 44]
    assert sum(segments) - 40 * len(segments) <= size + repeated * 1460
    ideal_ns = sum(segments) * S // bytes_per_s
    assert line.now_ns - begin_ns <= ideal_ns * 1.02 + 1 * S


def test_a_line_that_is_dead_ends_the_connection() -> None:
    line = Line()
    caller, _ = line.connected()
    line.lose = lambda packet: True
    caller.connection.send(b"x")
    line.run()
    assert caller.endings == [Ending.TIMED_OUT]
    assert caller.connection.state is TcpState.CLOSED


@pytest.mark.parametrize("seed", range(5))
def test_a_receiver_that_pauses_gets_everything(seed: int) -> None:
    line = Line(Quality(lost=0.1), seed=seed, window=2000)
    caller, controller = line.connected()
    controller.connection.pause()
    caller.connection.send(pattern(30_000, 3))
    caller.connection.end()
    line.run_for(400)
    assert len(controller.received) == 0
    assert caller.endings == []  # the peer answers the probes, so it is waited for
    for _ in range(200):
        controller.connection.resume()
        line.run_for(5)
        controller.connection.pause()
        line.run_for(5)
    assert bytes(controller.received) == pattern(30_000, 3)
