"""Corrupted frames on a PPP line: nothing raises, the link goes on, and no caller gets past the login.

The seeds were recorded between two pppd 2.4.9 and start with the protocol; they are corrupted and then framed again, so
that most have a correct check sequence.
"""

import logging
import random
from dataclasses import replace

import pytest
from ppp_bench import CALLER_END, CONTROLLER_END, PAP_LOGIN, PppBench, framed
from spoiling import spoilt

from fieldrig_devices.ppp.phases import Phase
from fieldrig_devices.ppp.settings import Login, PppSettings

SEED = 2026
RECORDED = [
    bytes.fromhex(text)
    for text in (
        "c021 01010018020600000000 0304c023 050601713f74 0702 0802",
        "c021 02010018020600000000 0304c023 050622222222 0702 0802",
        "c021 03010009 0305c22305",
        "c021 04010008 0304c023",
        "c021 05020010 557365722072657175657374",
        "c021 06020004",
        "c021 07030008 01010004",
        "c021 08020014 8057 0101000e010a7c10679724314506",
        "c021 09000008 d8992489",
        "c021 0a000008 d8992489",
        "c023 0101000f 036c6162 0667656865696d",
        "c023 0201000d 08 4c6f67696e206f6b",
        "8021 0101001c 0206002d0f01 030600000000 810600000000 830600000000",
        "8021 0201000a 0306bec86464",
        "8021 0301000a 0306bec86465",
        "8021 0401000a 0306bec86464",
        "80fd 0101000f 1a047800 18047800 15032f",
        "0021 4500001c00000000400100000a0000010a0000020800000000000000",
    )
]
A_CALL = 40
"""Inputs in one call."""


def next_bytes(chance: random.Random) -> bytes:
    if chance.random() < 0.1:
        return spoilt(chance, [framed(seed.hex()) for seed in RECORDED])
    content = chance.choice(RECORDED) if chance.random() < 0.4 else spoilt(chance, RECORDED)
    return framed(content[:600].hex())


def next_call(bench: PppBench, chance: random.Random) -> None:
    """Begin a call, in which the peer has often acknowledged the first request already."""
    bench.link.down(bench.now_ns)
    bench.take()
    (request,) = bench.up().take()
    if chance.random() < 0.7:
        bench.hear("c02102" + request[6:], "c02101070004")


def play(bench: PppBench, chance: random.Random, count: int, login: str) -> None:
    for number in range(count):
        if number % A_CALL == 0:
            next_call(bench, chance)
            bench.hear(*([login] if login else []))
        bench.link.receive(bench.now_ns, next_bytes(chance))
        if chance.random() < 0.1:
            bench.wait_s(chance.choice((0.1, 3, 10)))
        bench.line.clear()


@pytest.mark.long
def test_no_caller_gets_past_the_login(inputs_a_target: int, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    bench = PppBench(replace(CONTROLLER_END, demanded=Login.of("lab", "another")))
    play(bench, random.Random(f"{SEED}/called"), inputs_a_target, "")
    assert {Phase.NETWORK, Phase.RUNNING}.isdisjoint(bench.phases)
    assert bench.packets == []
    assert caplog.records == []


@pytest.mark.long
@pytest.mark.parametrize("name", ["controller", "caller", "plain"])
def test_corrupted_frames_do_no_harm(name: str, inputs_a_target: int, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    settings = {"controller": CONTROLLER_END, "caller": CALLER_END, "plain": PppSettings(mru=128)}[name]
    bench = PppBench(settings)
    play(bench, random.Random(f"{SEED}/{name}"), inputs_a_target, PAP_LOGIN)
    assert caplog.records == []
    bench.link.down(bench.now_ns)
    assert bench.up().phase() is Phase.ESTABLISH
