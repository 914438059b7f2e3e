"""A master that cannot be in virtual time fails at once, with a sentence that names the thread and the line."""

import _thread
import asyncio
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from fieldrig import Rig, S, VirtualTimeError, from_dict, virtual_time
from fieldrig.master_time import member
from fieldrig_bus.wires import Signal

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(60)]
EMPTY: dict[str, Any] = {"time": "virtual", "buses": {}, "devices": {}}


def refusal(body: Callable[[Rig], Any], **options: Any) -> str:
    """Return the message of the block."""
    with pytest.raises(VirtualTimeError) as caught, Rig(from_dict(EMPTY)) as rig, virtual_time(rig, **options):
        body(rig)
    return str(caught.value)


def in_thread(body: Callable[[], Any], name: str = "worker") -> Callable[[Rig], None]:
    def run(_: Rig) -> None:
        threading.Thread(target=body, name=name, daemon=True).start()
        time.sleep(100)

    return run


def connect(address: Any, family: int = socket.AF_INET, kind: int = socket.SOCK_STREAM) -> Callable[[Rig], None]:
    def body(_: Rig) -> None:
        with socket.socket(family, kind) as sock:
            sock.connect(address)

    return body


def send_datagram(_: Rig) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.sendto(b"x", ("10.0.0.1", 1))


# ---- addresses


@pytest.mark.parametrize(
    ("body", "what"),
    [
        (connect(("10.0.0.1", 502)), "10.0.0.1:502"),
        (connect(("127.0.0.1", 502)), "127.0.0.1:502"),
        (connect(("::1", 502), socket.AF_INET6), "::1:502"),
        (connect(("10.0.0.1", 502), kind=socket.SOCK_DGRAM), "UDP with"),
        (connect("/run/somewhere", socket.AF_UNIX), "'/run/somewhere'"),
        (lambda _: socket.create_connection(("plc.example", 502)), "plc.example"),
        (lambda _: socket.gethostbyname("plc.example"), "plc.example"),
        (send_datagram, "UDP to"),
    ],
)
def test_an_address_outside_of_the_rig_is_refused(body: Callable[[Rig], Any], what: str) -> None:
    message = refusal(body)
    assert f"{what}" in message
    assert "is outside of the rig" in message
    assert "thread MainThread at" in message
    assert "test_refusals.py:" in message


def test_a_master_that_swallows_the_error_does_not_pass() -> None:
    def body(_: Rig) -> None:
        try:
            socket.create_connection(("10.0.0.1", 502))
        except BaseException:  # noqa: BLE001
            return

    assert "10.0.0.1:502 is outside of the rig" in refusal(body)


def test_a_thread_that_dies_of_it_fails_the_block() -> None:
    def lost() -> None:
        time.sleep(1)
        connect(("10.0.0.1", 502))(None)  # type: ignore[arg-type]

    instants: list[int] = []

    def body(rig: Rig) -> None:
        try:
            in_thread(lost)(rig)
        finally:
            instants.append(rig.now_ns)

    assert "thread worker at" in refusal(body)
    assert instants == [S]  # at once


@pytest.mark.parametrize(("caught", "pause_s"), [(Exception, 1), (Exception, None), (BaseException, 1)])
def test_a_library_that_tries_again_does_not_go_on(caught: type[BaseException], pause_s: float | None) -> None:
    tries: list[float] = []

    def body(_: Rig) -> None:
        while len(tries) < 10:
            with suppress(caught):
                tries.append(time.monotonic())
                socket.create_connection(("10.0.0.1", 502))
            if pause_s is not None:
                time.sleep(pause_s)

    assert "10.0.0.1:502 is outside of the rig" in refusal(body)
    assert len(tries) == 1


def test_an_executor_that_still_waits_at_the_end_says_nothing_and_leaves_nothing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    before = threading.enumerate()

    async def main() -> None:
        await asyncio.open_connection("plc.example", 502)

    assert "plc.example is outside of the rig" in refusal(lambda _: asyncio.run(main()))
    assert caplog.records == []
    assert threading.enumerate() == before


class AdapterSocket(socket.socket):
    """A socket of a family that leads to a device of the host, which this host may not have."""

    family = property(lambda self: getattr(socket, "AF_PACKET"))  # noqa: B009  not there on Windows


@pytest.mark.skipif(not hasattr(socket, "AF_PACKET"), reason="only Linux has sockets of this family")
def test_a_can_adapter_of_the_host_is_refused() -> None:
    def body(_: Rig) -> None:
        with AdapterSocket(socket.AF_UNIX, socket.SOCK_DGRAM) as sock:
            sock.bind(("vcan0",))

    assert "('vcan0',) is outside of the rig" in refusal(body)


# ---- alarms


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="Windows has no alarms")
@pytest.mark.parametrize(
    "start",
    [lambda _: signal.alarm(2), lambda _: signal.setitimer(signal.ITIMER_REAL, 0.5, 0.5)],
)
def test_an_alarm_of_the_system_is_refused(start: Callable[[Rig], Any]) -> None:
    """It would come after two seconds of real time, when the master is over."""
    message = refusal(start)
    assert "an alarm of the system comes in real time; threading.Timer is in virtual time" in message
    assert "thread MainThread at" in message
    assert "test_refusals.py:" in message


@pytest.mark.skipif(not hasattr(signal, "sigtimedwait"), reason="Windows and macOS cannot wait for a signal")
@pytest.mark.parametrize(
    "wait",
    [
        lambda _: signal.sigtimedwait([signal.SIGUSR1], 1.5),
        lambda _: signal.sigwait([signal.SIGUSR1]),
        lambda _: signal.sigwaitinfo([signal.SIGUSR1]),
        lambda _: signal.pause(),
    ],
)
def test_a_wait_for_a_signal_is_refused(wait: Callable[[Rig], Any]) -> None:
    message = refusal(wait)
    assert "a wait for a signal is in real time" in message
    assert "test_refusals.py:" in message


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="Windows has no alarms")
def test_the_tools_around_a_test_have_their_alarms_and_anybody_may_end_one() -> None:
    tool = {"signal": signal, "__name__": "pytest_timeout"}
    with Rig(from_dict(EMPTY)) as rig, virtual_time(rig):
        exec("signal.setitimer(signal.ITIMER_REAL, 1000.0)", tool)
        left_s, _ = signal.setitimer(signal.ITIMER_REAL, 0)
        assert signal.alarm(0) == 0
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    assert 900 < left_s <= 1000


# ---- processes


@pytest.mark.parametrize(
    "start",
    [
        lambda _: subprocess.run([sys.executable, "-c", ""], check=True),
        lambda _: subprocess.Popen([sys.executable, "-c", ""], close_fds=False),
        lambda _: os.system("true"),
        lambda _: os.fork(),
        lambda _: os.posix_spawn("/bin/true", ["true"], {}),
    ],
)
def test_a_process_is_refused(start: Callable[[Rig], Any]) -> None:
    message = refusal(start)
    assert "a process of its own runs in real time" in message
    assert "thread MainThread at" in message


def _start(process: Any, _: Rig) -> None:
    process.start()


def test_a_process_of_multiprocessing_is_refused() -> None:
    for method in ("fork", "spawn"):
        process: Any = multiprocessing.get_context(method)
        made = process.Process(target=print)
        assert "a process of its own runs in real time" in refusal(partial(_start, made))


# ---- waits without an end


def test_a_wait_that_nobody_can_end_is_told() -> None:
    def body(_: Rig) -> None:
        lock = threading.Lock()
        threading.Thread(target=lambda: lock.acquire() and threading.Event().wait(), name="greedy").start()
        time.sleep(1)
        lock.acquire()

    message = refusal(body)
    assert message.startswith("all threads wait forever, and nothing is left to happen in the rig")
    assert "MainThread: " in message
    assert "greedy: " in message
    assert "lock.acquire()" in message


def test_the_limit_of_virtual_time_is_told() -> None:
    def body(_: Rig) -> None:
        while True:
            time.sleep(1000)

    assert refusal(body, limit_s=5000).startswith("the limit of 5000 s of virtual time is reached")


# ---- what does not hand the baton on


def real_wait() -> None:
    lock = member.new_lock()
    lock.acquire()
    lock.acquire()


@pytest.mark.long
def test_a_wait_in_c_is_told_in_the_main_thread() -> None:
    message = refusal(lambda _: real_wait())
    assert message.startswith("thread MainThread waits for something outside of virtual time: ")
    assert "test_refusals.py:" in message
    assert "real_wait: lock.acquire()" in message


@pytest.mark.long
def test_a_wait_in_c_is_told_in_another_thread() -> None:
    message = refusal(in_thread(real_wait))
    assert message.startswith("thread worker waits for something outside of virtual time: ")
    assert "real_wait: lock.acquire()" in message


def spin() -> None:
    flag: list[int] = []
    while not flag:
        pass


@pytest.mark.long
@pytest.mark.parametrize("has_thread_signals", [True, False])
def test_endless_computing_is_told_in_the_main_thread(
    monkeypatch: pytest.MonkeyPatch, has_thread_signals: bool
) -> None:
    if not has_thread_signals:  # as on Windows
        monkeypatch.delattr("signal.pthread_kill")
    message = refusal(lambda _: spin(), patience_s=0.5)
    assert message.startswith("thread MainThread has run for 0.5 s without waiting: ")
    assert "in spin: " in message


@pytest.mark.long
def test_endless_computing_is_told_in_another_thread_which_ends() -> None:
    before = threading.active_count()
    message = refusal(in_thread(spin), patience_s=0.5)
    assert message.startswith("thread worker has run for 0.5 s without waiting: ")
    assert threading.active_count() == before


def test_a_thread_that_swallows_the_end_is_named() -> None:
    def stubborn() -> None:
        while True:
            with suppress(BaseException):
                time.sleep(1)

    def body(_: Rig) -> None:
        threading.Thread(target=stubborn, name="stubborn", daemon=True).start()
        time.sleep(3)

    assert refusal(body) == "these threads did not end with the block: stubborn"


# ---- the block itself


def test_there_is_one_block_at_a_time() -> None:
    def body(rig: Rig) -> None:
        with virtual_time(rig):
            pass

    assert refusal(body) == "this process is in virtual time already"


def test_a_block_begins_in_the_main_thread() -> None:
    messages: list[str] = []

    def body() -> None:
        messages.append(refusal(lambda _: None))

    thread = threading.Thread(target=body)
    thread.start()
    thread.join()
    assert messages[0].startswith("virtual time begins in the main thread")


def test_an_interrupt_ends_the_block() -> None:
    def interrupt() -> None:
        time.sleep(1)
        _thread.interrupt_main()
        time.sleep(10)

    def body(_: Rig) -> None:
        threading.Thread(target=interrupt, daemon=True).start()
        time.sleep(5000)

    with pytest.raises(KeyboardInterrupt), Rig(from_dict(EMPTY)) as rig, virtual_time(rig):
        body(rig)
    assert threading.active_count() == len(threading.enumerate())


def test_an_error_of_a_device_is_the_error_of_the_test() -> None:
    wires = {"wires": "wires"}
    data = {
        "time": "virtual",
        "buses": {"wires": {"kind": "wires.virtual"}},
        "devices": {"brittle": {"kind": "rig_kinds:Brittle", "links": wires}},
    }
    with Rig(from_dict(data, Path(__file__).parents[1])) as rig:
        rig.attach("bench").link("wires").send(Signal("fuse", 1))
        with pytest.raises(RuntimeError, match="it broke"), virtual_time(rig):
            time.sleep(10)
