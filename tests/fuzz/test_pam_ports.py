"""Corrupted requests to the memory of a PAM, corrupted words in it, and corrupted bytes on its RS422 line."""

import random
from collections.abc import Callable

import pytest
from pam_ports import GROUP, RS422, SIMATIC, VME, PortBench
from spoiling import spoilt
from tcp_client import ServedConnection

from fieldrig_devices.connections.connection import Serve
from fieldrig_devices.pam.ports.access.s7 import serving_s7
from fieldrig_devices.pam.ports.access.word_service import serving_words
from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.script import Script
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.memory import WORDS, Memory
from fieldrig_devices.pam.ports.rs422.codec import FramedCodec
from fieldrig_devices.pam.ports.rs422.messages import Code, Message, exchange

pytestmark = pytest.mark.system

SEED = 2026
CONNECT = bytes.fromhex("03 00 00 16 11 e0 00 00 00 01 00 c1 02 01 00 c2 02 01 02 c0 01 0a")
S7_REQUESTS = (
    "32 01 00 00 00 02 00 0e 00 00 04 01 12 0a 10 02 00 0e 00 01 84 00 01 60",
    "32 01 00 00 00 03 00 0e 00 06 05 01 12 0a 10 02 00 02 00 01 84 00 08 28 00 04 00 10 08 01",
)
S7 = [
    CONNECT + b"".join(b"\3\0" + (len(pdu) + 7).to_bytes(2, "big") + b"\2\xf0\x80" + pdu for pdu in pdus)
    for pdus in ([bytes.fromhex(request)] * 2 for request in S7_REQUESTS)
]
WORDS_OVER_TCP = [bytes.fromhex("57 000a 0002 1234 abcd 52 000a 0002 43 000b 0001 abcd 0007")]
SERVICES: dict[str, tuple[Callable[[Memory], Serve], list[bytes]]] = {
    "s7": (lambda memory: serving_s7(memory, 1, "big"), S7),
    "dualport": (serving_words, WORDS_OVER_TCP),
}
FRAMES = [
    FramedCodec().encode(message)
    for message in (
        Message(Code.REQUEST),
        Message(Code.ASK_DEF_IN),
        Message(Code.DEF_OUT, (0x2C90, 1)),
        Message(Code.END_DEF_OUT),
        Message(Code.INIT_IN),
        exchange("WORD_VAR", 4, 0, -7),
        Message(Code.END_INIT_IN),
        Message(Code.START),
        Message(Code.ALIVE),
    )
]


@pytest.mark.share(0.5)
@pytest.mark.parametrize("name", SERVICES)
def test_a_service_answers_the_next_client(name: str, inputs_a_target: int) -> None:
    make, seeds = SERVICES[name]
    chance = random.Random(f"{SEED}/{name}")
    serve = make(Memory())
    for _ in range(inputs_a_target):
        connection = ServedConnection(serve)
        connection.session.received(spoilt(chance, seeds))
        connection.end()
        assert connection.is_closed
    assert ServedConnection(serve).send(seeds[0])


def _vme(bench: PortBench) -> Script[None]:
    return VmeMaster(bench.variables).start_up()


def _simatic(bench: PortBench) -> Script[None]:
    return S5Master(bench.plans[0]).start_up()


@pytest.mark.share(0.1)
@pytest.mark.parametrize(("text", "start_up"), [(VME, _vme), (SIMATIC, _simatic)], ids=["vme", "simatic"])
def test_a_master_that_writes_anything_is_survived(
    text: str, start_up: Callable[[PortBench], Script[None]], inputs_a_target: int
) -> None:
    chance = random.Random(f"{SEED}/{text[:9]}")
    bench = PortBench(GROUP + text)
    outputs = [bench.item(variable.name) for variable in bench.variables if not variable.is_input]
    for _ in range(inputs_a_target):
        bench.begin()
        if chance.random() < 0.5:
            bench.play(start_up(bench))
        for _ in range(20):
            value = chance.choice((chance.randrange(0x10000), chance.randrange(9)))
            bench.memory.write(chance.choice((chance.randrange(WORDS), chance.randrange(30))), [value])
            chance.choice(outputs).set_value(chance.randrange(-9, 9))
            bench.cycles(chance.randrange(3))
    bench.begin()
    bench.play(start_up(bench))
    assert bench.ports.states == {"DualPort": "running"}


@pytest.mark.share(0.2)
def test_the_rs422_line_finds_its_master_again(inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/rs422")
    bench = PortBench(GROUP + RS422)
    bench.begin()
    for _ in range(inputs_a_target):
        frames = FRAMES[: chance.randrange(len(FRAMES) + 1)]
        bench.ports.receive(b"".join(frames) + spoilt(chance, FRAMES))
        bench.item("RWO_MachCurrentPressure").set_value(chance.randrange(9))
        bench.cycles(chance.randrange(30))
    bench.connect()
    bench.cycles(3000)
    assert bench.ports.states == {"RS422Port": "running"}
