"""CAN masters of foreign libraries, unchanged, in virtual time."""

import asyncio
import time
from typing import Any

import can
import pytest
from can_homing import AXES, FIELDRIG, SOCKETCAND, homed
from doc_pages import blocks, page_named

from fieldrig import Rig, S
from fieldrig.pytest_plugin import MasterRigMaker
from fieldrig.testing import free_port

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]
PAGE = page_named("cia402.md")


@pytest.mark.long
def test_the_program_of_the_page_moves_an_axis_verbatim(
    fieldrig_master: MasterRigMaker, capsys: pytest.CaptureFixture[str]
) -> None:
    program = next(block.text for block in blocks(PAGE) if "can_belt.py" in block.info)
    rig = fieldrig_master(AXES)
    exec(compile(program, "can_belt.py", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out == "belt has moved by 1000000\n"
    assert isinstance(rig, Rig)
    assert 1 * S < rig.now_ns < 3 * S


@pytest.mark.long
@pytest.mark.parametrize("where", [FIELDRIG, SOCKETCAND], ids=["fieldrig", "socketcand"])
def test_a_homing_of_a_minute_gives_the_same_bytes_each_time(where: dict[str, Any]) -> None:
    first = homed(where)
    assert first[0]
    assert 60 * S < first[1] < 64 * S
    assert homed(where) == first


@pytest.mark.long
def test_jitter_makes_other_runs_and_the_same_for_the_same_seed() -> None:
    runs = [homed(FIELDRIG, jitter=0.01, seed=seed)[3] for seed in (1, 2, 1)]
    assert runs[0] == runs[2] != runs[1]


def test_a_master_without_a_socket_hears_and_sends(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG) as bus:
        bus.send(can.Message(arbitration_id=0x60A, data=bytes.fromhex("40 00 10 00 00 00 00 00"), is_extended_id=False))
        heard = [bus.recv(1), bus.recv(1)]  # the boot-up message, and the answer
        answer = heard[1]
        assert answer is not None
        assert (answer.arbitration_id, bytes(answer.data)) == (0x58A, bytes.fromhex("43 00 10 00 92 01 ff ff"))
        before_s = time.monotonic()
        assert bus.recv(0.5) is None
        assert time.monotonic() - before_s == 0.5


def test_filters_of_python_can_apply(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG, can_filters=[{"can_id": 0x123, "can_mask": 0x7FF}]) as bus, can.Bus(**FIELDRIG) as other:
        for identifier in (0x122, 0x123):
            other.send(can.Message(arbitration_id=identifier, is_extended_id=False))
        heard = bus.recv(1)
        assert heard is not None
        assert heard.arbitration_id == 0x123


def test_a_notifier_a_cyclic_task_and_asyncio_work(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)

    async def main() -> list[float]:
        with can.Bus(**FIELDRIG) as bus, can.Bus(**FIELDRIG) as sender:
            reader = can.AsyncBufferedReader()
            with can.Notifier(bus, [reader], loop=asyncio.get_running_loop()):
                task = sender.send_periodic(can.Message(arbitration_id=0x123, is_extended_id=False), 0.1)
                instants: list[float] = []
                while len(instants) < 20:
                    message = await reader.get_message()
                    if message.arbitration_id == 0x123:
                        instants.append(message.timestamp)
                task.stop()
                return instants

    instants = asyncio.run(main())
    assert instants[-1] - instants[0] == pytest.approx(1.9, abs=0.001)


def test_an_unknown_bus_is_named(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with pytest.raises(can.CanInitializationError, match="no bus 'can1'"):
        can.Bus(interface="fieldrig", channel="can1")
    with pytest.raises(can.CanInitializationError, match="needs the channel of a bus: can0"):
        can.Bus(interface="fieldrig")
    assert can.detect_available_configs("fieldrig") == [FIELDRIG]


def test_a_program_in_real_time_without_a_rig_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDRIG_CONTROL", f"tcp/127.0.0.1:{free_port()}")
    with pytest.raises(can.CanInitializationError, match="no rig"):
        can.Bus(**FIELDRIG)
    assert can.detect_available_configs("fieldrig") == []


def test_a_frame_that_no_bus_carries_is_refused(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG) as bus, pytest.raises(can.CanOperationError):
        bus.send(can.Message(arbitration_id=0x800, is_extended_id=False, check=False))
