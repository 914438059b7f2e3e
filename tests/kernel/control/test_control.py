"""Control messages over Zenoh: questions, announcements, life signs, streams, and who may listen where."""

import asyncio
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest
from in_loop import in_loop
from patience import PATIENCE_S

from fieldrig.control import endpoint as endpoints
from fieldrig.control.messages import Client, Control, NoAnswerError
from fieldrig.errors import ControlError, RigError
from fieldrig.outside.shared_token import TOKEN_VARIABLE

pytestmark = pytest.mark.system


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{taken.getsockname()[1]}"


@asynccontextmanager
async def rig_and_process(endpoint: str) -> AsyncIterator[tuple[Control, Control]]:
    rig = Control(endpoints.listen(endpoint), "lab")
    try:
        process = Control(endpoints.connect(endpoint), "lab")
        try:
            yield rig, process
        finally:
            await process.close()
    finally:
        await rig.close()


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.005)


async def until_served(asker: Control, path: str) -> None:
    """Wait until what one session declares has reached another."""
    while True:
        try:
            await asker.ask(path, None, 5)
        except NoAnswerError:
            await asyncio.sleep(0.005)
        except ControlError:
            return
        else:
            return


async def echo(verb: str, message: Any) -> Any:
    return {"verb": verb, "message": message}


async def refuse(_verb: str, _message: Any) -> Any:
    raise ControlError("there is no such point", "write one of: level")


@in_loop
async def test_who_looks_around_the_questions_of_a_verb_sees_the_state_before_and_after_each(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        faults: list[Any] = []
        seen: list[int] = []

        async def add(_verb: str, message: Any) -> Any:
            faults.append(message)
            return len(faults)

        rig.serve("device/belt/*", add)
        rig.around(("add_fault", "clear_fault"), lambda: seen.append(len(faults)))
        assert await process.ask("device/belt/add_fault", {}, 5) == 1
        await until(lambda: seen == [0, 1])
        assert await process.ask("device/belt/faults", {}, 5) == 2
        assert seen == [0, 1]


@in_loop
async def test_a_query_is_answered_with_its_verb_and_message(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        rig.serve("rig/*", echo)
        assert await process.ask("rig/step", {"ns": 5}, 5) == {"verb": "step", "message": {"ns": 5}}


@in_loop
async def test_a_process_that_does_not_answer_is_named_with_what_to_do(endpoint: str) -> None:
    async def hang(_verb: str, _message: Any) -> Any:
        await asyncio.Event().wait()

    async with rig_and_process(endpoint) as (rig, process):
        rig.serve("device/oven/*", hang)
        rig.serve("device/stove/*", echo)
        await until_served(process, "device/stove/get")
        for path in ("device/oven/get", "device/oven/keys", "process/io/record", "bus/can0/keys", "help/oven"):
            with pytest.raises(NoAnswerError) as silence:
                await process.ask(path, None, 0.2)
            assert silence.value.what.startswith(f"{path.split('/')[1]} does not answer: ")
            assert "fieldrig status" in silence.value.remedy


@in_loop
async def test_a_refusal_arrives_with_its_remedy(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        process.serve("device/tank/*", refuse)
        await until_served(rig, "device/tank/get")
        with pytest.raises(ControlError) as refused:
            await rig.ask("device/tank/get", None, 5)
        assert refused.value.what == "there is no such point"
        assert refused.value.remedy == "write one of: level"


@in_loop
async def test_a_question_to_nobody_is_an_error_and_no_wait(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, _process):
        with pytest.raises(ControlError, match="pump does not answer"):
            await rig.ask("device/pump/get", None, 60)


@in_loop
async def test_an_answer_may_take_its_time_while_others_are_given(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        go = asyncio.Event()

        async def answer(verb: str, _message: Any) -> Any:
            if verb == "join":
                await go.wait()
            return verb

        rig.serve("rig/*", answer)
        joining = asyncio.create_task(process.ask("rig/join", None, 30))
        assert await process.ask("rig/status", None, 5) == "status"
        assert not joining.done()
        go.set()
        assert await joining == "join"


@in_loop
async def test_announcements_reach_who_listens(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        heard: list[tuple[str, Any]] = []
        rig.listen_to("ready/*", lambda name, message: heard.append((name, message)))
        process.publish("ready/tank", {"pid": 4})
        await until(lambda: heard == [("tank", {"pid": 4})])


@in_loop
async def test_life_is_seen_when_it_comes_when_it_was_there_and_when_it_goes(endpoint: str) -> None:
    rig = Control(endpoints.listen(endpoint), "lab")
    first = Control(endpoints.connect(endpoint), "lab")
    first.show_life("alive/first")
    seen: list[tuple[str, bool]] = []
    rig.watch_life("alive/*", lambda name, is_alive: seen.append((name, is_alive)))
    await until(lambda: ("first", True) in seen)
    second = Control(endpoints.connect(endpoint), "lab")
    second.show_life("alive/second")
    await until(lambda: ("second", True) in seen)
    await first.close()
    await until(lambda: ("first", False) in seen)
    await second.close()
    await rig.close()


@in_loop
async def test_a_stream_knows_whether_anybody_listens(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        listeners: list[bool] = []
        stream = process.stream("trace/can0", listeners.append)
        assert listeners == [False]
        heard: list[Any] = []
        rig.listen_to("trace/*", lambda bus, batch: heard.append((bus, batch)))
        await until(lambda: listeners[-1])
        stream.put("[1]")
        await until(lambda: heard == [("can0", [1])])


@in_loop
async def test_after_an_answer_a_stream_knows_who_listened_before_it_was_given(endpoint: str) -> None:
    rig = Control(endpoints.listen(endpoint), "lab")
    rig.listen_to("trace/*", lambda _bus, _batch: None)
    rig.serve("rig/*", echo)
    for _ in range(10):
        process = Control(endpoints.connect(endpoint), "lab")
        listeners: list[bool] = []
        stream = process.stream("trace/can0", listeners.append)
        await process.ask("rig/join", {}, 5.0)
        stream.look()
        assert listeners[-1]
        await process.close()
    await rig.close()


@in_loop
async def test_a_tool_asks_one_or_all(endpoint: str) -> None:
    async with rig_and_process(endpoint) as (rig, process):
        rig.serve("process/one/*", echo)
        process.serve("process/two/*", echo)
        await until_served(rig, "process/two/status")

        def use_tool() -> None:
            with Client(endpoint) as client:
                assert client.ask("process/two/status")["verb"] == "status"
                assert sorted(client.ask_all("process/*/status")) == ["one", "two"]
                with pytest.raises(ControlError, match="three does not answer"):
                    client.ask("process/three/status")

        await asyncio.to_thread(use_tool)


def test_no_rig_is_said_at_once_with_what_to_do(endpoint: str) -> None:
    with pytest.raises(ControlError, match="no rig answers") as refused:
        Client(endpoint)
    assert "fieldrig up" in refused.value.remedy


def test_a_taken_endpoint_is_refused(endpoint: str) -> None:
    with (
        socket.create_server(("127.0.0.1", int(endpoint.rpartition(":")[2]))),
        pytest.raises(RigError, match="another program"),
    ):
        endpoints.listen(endpoint)


@pytest.mark.parametrize("endpoint", ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "tcp/bench-3:7447", "udp/10.0.0.1:1"])
def test_without_a_token_nobody_listens_beyond_this_machine(endpoint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    with pytest.raises(RigError, match="can be reached from other machines") as refused:
        endpoints.listen(endpoint)
    assert TOKEN_VARIABLE in refused.value.remedy


@pytest.mark.parametrize(
    "endpoint",
    ["tcp/127.0.0.1:7447", "tcp/localhost:1", "tcp/[::1]:7447", "unixsock-stream//tmp/rig.sock", "tcp/127.8.9.1:5"],
)
def test_loopback_is_local(endpoint: str) -> None:
    assert endpoints.is_local(endpoint)


def test_only_the_right_token_opens(endpoint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_VARIABLE, "open sesame")
    session = endpoints.listen(endpoint)
    try:
        endpoints.close(endpoints.connect(endpoint))
        monkeypatch.setenv(TOKEN_VARIABLE, "guess")
        with pytest.raises(ControlError, match="refuses the connection"):
            endpoints.connect(endpoint)
        monkeypatch.delenv(TOKEN_VARIABLE)
        with pytest.raises(ControlError, match=r"refuses the connection[^$]*FIELDRIG_TOKEN"):
            endpoints.connect(endpoint)
    finally:
        endpoints.close(session)


@in_loop
async def test_connections_that_say_nothing_keep_no_tool_out(endpoint: str) -> None:
    rig = Control(endpoints.listen(endpoint), "lab")
    host, _, port = endpoint.removeprefix("tcp/").rpartition(":")
    silent = [socket.create_connection((host, int(port))) for _ in range(200)]
    try:
        rig.serve("rig/*", echo)

        def ask() -> Any:
            with Client(endpoint) as tool:
                return tool.ask("rig/status")

        assert await asyncio.to_thread(ask) == {"verb": "status", "message": None}
    finally:
        for connection in silent:
            connection.close()
        await rig.close()


@in_loop
async def test_questions_beyond_the_limit_are_refused_and_counted(
    endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fieldrig.control.questions.MOST_QUESTIONS", 10)
    async with rig_and_process(endpoint) as (rig, process):
        rig.serve("rig/*", echo)
        await until_served(process, "rig/x")
        monkeypatch.setattr(rig._questions, "_work", lambda: None)
        asked = [asyncio.ensure_future(process.ask("rig/x", number, 5)) for number in range(30)]
        await until(lambda: rig.limits().get("questions over the limit") == 20.0)
        monkeypatch.undo()
        rig._questions._work()
        answers = await asyncio.gather(*asked, return_exceptions=True)
        assert sum(isinstance(answer, dict) for answer in answers) == 10
        assert all(isinstance(answer, dict) or "ask again later" in str(answer) for answer in answers)
