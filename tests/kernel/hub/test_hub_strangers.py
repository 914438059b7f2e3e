"""Malformed records of one member never disturb another member, on every kind of bus that has a hub."""

import asyncio
import logging
from pathlib import Path

import pytest
from patience import PATIENCE_S
from strangers import Stranger, bus_of, hello, hub_kinds, hub_of

from fieldrig.errors import BusError
from fieldrig.hub.attach import attach
from fieldrig.hub.wire import HEADER, LONGEST_HELLO, Kind, pack
from fieldrig.loop.real_clock import RealClock
from fieldrig.outside.limits import Limits
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, proof
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

DEEP = b"[" * 2000
BOMB = b"[" * 500_000


@pytest.fixture(autouse=True)
def no_token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    monkeypatch.delenv(FILE_VARIABLE, raising=False)


BAD_HELLOS = [
    DEEP,
    b'{"bus":"bus0","member":[[1,2]]}',
    b'{"bus":"bus0","member":{"a":1}}',
    b'{"bus":["bus0"],"member":"x"}',
    b'{"bus":"bus0"}',
    b'{"bus":"bus0","member":"x","member":"y"}',
    b'{"bus":"bus0","member":""}',
    b'{"bus":"bus0","member":"a\\nb"}',
    b'{"bus":"bus0","member":"\\ud800"}',
    b'{"bus":"bus0","member":"' + b"x" * 1000 + b'"}',
    b'{"bus":"bus1","member":"x"}',
    b"[]",
    b"null",
    b"\xff\xfe",
    b"",
]
BAD_INTERESTS = [
    DEEP,
    BOMB,
    b"[[1,2,3]]",
    b'[{"a":1}]',
    b"[[[]]]",
    b"[null]",
    b"[1.5]",
    b"[true]",
    b"[-1]",
    b"[99999999999]",
    b"[18446744073709551616]",
    b'[["drive"]]',
    b'[["drive","x"]]',
    b'{"a":1}',
    b'"all"',
    b"5",
    b"NaN",
    b"[" + b"1," * 20_000 + b"1]",
    b"",
    b"\xff",
]


@pytest.mark.parametrize("kind", hub_kinds())
def test_every_bad_record_disconnects_its_sender_only(
    kind: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def scene() -> None:
        async with hub_of(kind, tmp_path) as hub:
            path = tmp_path / "bus0.sock"
            witness = await Stranger.at(path)
            witness.say(hello("witness"), pack(Kind.LISTEN, 0, b"[]"))
            openings: list[tuple[bytes, ...]] = [(pack(Kind.HELLO, 0, body),) for body in BAD_HELLOS]
            openings += [(hello("x"), pack(Kind.LISTEN, 0, body)) for body in BAD_INTERESTS]
            openings += [(hello("x"), pack(Kind.MESSAGE, 0, body)) for body in (b"", DEEP, b"\xff" * 40, b"[" * 90_000)]
            openings += [
                (pack(Kind.MESSAGE, 0, b""),),
                (pack(Kind.LISTEN, 0, b"null"),),
                (hello("x"), hello("y")),
                (hello("witness"),),
                (hello("x"), pack(Kind.REFUSED, 0, b'{"why":"no"}')),
                (HEADER.pack(77, 0, 0),),
                (HEADER.pack(Kind.HELLO, 0, LONGEST_HELLO + 1),),
                (hello("x"), HEADER.pack(Kind.MESSAGE, 0, 0xFFFF_FFFF)),
                (b"GET / HTTP/1.1\r\nHost: bench\r\n\r\n",),
            ]
            for opening in openings:
                stranger = await Stranger.at(path)
                caplog.clear()
                stranger.say(*opening)
                why = await stranger.until_put_off()
                assert why, opening
                said = [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]
                assert len(said) == 1, (opening, said)
                assert said[0].startswith("bus0: ")
                assert len(said[0]) < 500
            # No other member noticed, and the name is free again.
            again = await Stranger.at(path)
            again.say(hello("x"), pack(Kind.LISTEN, 0, b"null"))
            assert (await again.heard())[0] == Kind.CHALLENGE
            assert (await again.heard())[0] == Kind.HELLO
            assert (await witness.heard())[0] == Kind.CHALLENGE
            assert (await witness.heard())[0] == Kind.HELLO
            assert hub.statistics() is not None
            again.close()
            witness.close()

    asyncio.run(scene())


def test_who_says_no_hello_is_not_waited_for(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldrig.hub.server.PATIENCE_S", 0.01)

    async def scene() -> None:
        async with hub_of("wires.hub", tmp_path):
            stranger = await Stranger.at(tmp_path / "bus0.sock")
            assert await stranger.until_put_off() == "no hello came"

    asyncio.run(scene())


def test_of_too_many_connections_without_a_hello_the_oldest_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldrig.hub.server.LIMITS", Limits(first_message_s=10.0, silent=3))

    async def scene() -> None:
        async with hub_of("wires.hub", tmp_path):
            path = tmp_path / "bus0.sock"
            waiting = [await Stranger.at(path) for _ in range(3)]
            for stranger in waiting:
                await stranger.heard()
            member = await Stranger.at(path)
            assert await waiting[0].until_put_off() == "too many connections without a hello"
            assert (await member.heard())[0] == Kind.CHALLENGE
            member.say(hello("x"))
            assert (await member.heard())[0] == Kind.HELLO
            for stranger in (*waiting, member):
                stranger.close()

    asyncio.run(scene())


# Attach ports beyond loopback.


@pytest.mark.parametrize("host", ["0.0.0.0", "[::]"])
def test_without_a_token_no_hub_listens_beyond_this_machine(host: str, tmp_path: Path) -> None:
    async def scene() -> None:
        with pytest.raises(BusError, match="can be reached from other machines") as refused:
            async with hub_of("wires.hub", tmp_path, attach=f"tcp://{host}:{free_port()}"):
                pass
        assert TOKEN_VARIABLE in refused.value.remedy

    asyncio.run(scene())


@pytest.mark.parametrize("host", ["0.0.0.0", "127.0.0.1"])
def test_a_hub_with_a_token_asks_for_its_proof(host: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_VARIABLE, "open sesame")
    port = free_port()

    async def scene() -> None:
        async with hub_of("wires.hub", tmp_path, attach=f"tcp://{host}:{port}"):
            first = await Stranger.at_tcp(port)
            kind, challenge = await first.heard()
            assert kind == Kind.CHALLENGE
            good = proof("open sesame", challenge["nonce"], "bus0", "lamp")
            first.say(hello("lamp", proof=good))
            assert (await first.heard())[0] == Kind.HELLO

            # A missing proof, a guess, and a proof of another connection or for another member are all refused.
            guess = proof("guess", challenge["nonce"], "bus0", "lamp")
            for words in ({}, {"proof": ""}, {"proof": guess}, {"proof": good}):
                other = await Stranger.at_tcp(port)
                other.say(hello("switch", **words))
                assert "token" in await other.until_put_off()
            first.close()

    asyncio.run(scene())


def test_a_device_process_attaches_with_the_rigs_token_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_VARIABLE, "open sesame")
    port = free_port()

    async def scene() -> None:
        async with hub_of("wires.hub", tmp_path, attach=f"tcp://0.0.0.0:{port}", connect=f"127.0.0.1:{port}") as hub:
            clock = RealClock(asyncio.get_running_loop())
            link = await attach(hub.bus, "lamp", clock, tmp_path, pytest.fail)
            await link.close()
            monkeypatch.setenv(TOKEN_VARIABLE, "guess")
            with pytest.raises(BusError, match="FIELDRIG_TOKEN"):
                await attach(hub.bus, "switch", clock, tmp_path, pytest.fail)
            clock.close()

    asyncio.run(scene())


# The other way round: what a hub says that is none.


@pytest.mark.parametrize(
    "words",
    [
        pack(Kind.CHALLENGE, 0, DEEP),
        pack(Kind.CHALLENGE, 0, b"{}"),
        pack(Kind.CHALLENGE, 0, b'{"nonce":5}'),
        pack(Kind.CHALLENGE, 0, b'{"nonce":"n"}') + pack(Kind.HELLO, 0, b'{"now_ns":"soon"}'),
        pack(Kind.CHALLENGE, 0, b'{"nonce":"n"}') + pack(Kind.HELLO, 0, b"[]"),
        pack(Kind.CHALLENGE, 0, b'{"nonce":"n"}') + pack(Kind.REFUSED, 0, b'{"why":1}'),
        pack(Kind.REFUSED, 0, b'{"why":"you again"}'),
        HEADER.pack(Kind.CHALLENGE, 0, 0xFFFF_FFFF),
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        b"",
    ],
)
def test_an_answer_that_is_none_is_an_error_with_the_buss_name(words: bytes, tmp_path: Path) -> None:
    async def scene() -> None:
        async def on_client(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            writer.write(words)
            writer.close()

        port = free_port()
        server = await asyncio.start_server(on_client, "127.0.0.1", port)
        clock = RealClock(asyncio.get_running_loop())
        bus = bus_of("wires.hub", connect=f"127.0.0.1:{port}")
        async with asyncio.timeout(PATIENCE_S):
            with pytest.raises(BusError, match=r"^bus0: "):
                await attach(bus, "lamp", clock, tmp_path, pytest.fail)  # type: ignore[arg-type]
        clock.close()
        server.close()

    asyncio.run(scene())
