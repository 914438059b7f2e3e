"""A service engineer with pppd, chat, curl and pymodbus calls the wrapper of configs/teleservice.yaml."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from pppd import is_in_guest
from pppd_call import pppd_call, write_peer
from running_rig import AskedRig, until
from service_engineer import CONTROLLER, OFFLINE, PASSWORD, TERMINATED, USER, curl, put, reach_every_service

pytestmark = [
    pytest.mark.real,
    pytest.mark.ppp,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not is_in_guest(), reason="runs inside user-mode Linux: `python -m tests.driver ppp`"),
]

RIG = Path(__file__).parents[2] / "configs" / "teleservice.yaml"
DIALLING_FAILED, NO_ECHO_REPLIES, HUNG_UP, WRONG_PASSWORD = 8, 15, 16, 19  # pppd(8), EXIT STATUS
LARGE = b"0123456789abcdef" * 6_144  # some 25 s at 33600 bit/s


@pytest.fixture(scope="module")
def rig() -> Iterator[AskedRig]:
    with AskedRig(RIG, None) as rig:
        rig.until_ready()
        yield rig


@contextmanager
def mended_at_the_end(rig: AskedRig) -> Iterator[None]:
    """Clear the faults of the telephone network at the end of the block, also for the tests after one that fails."""
    try:
        yield
    finally:
        rig.control.ask("bus/telephone/clear_fault", {"number": None})


@pytest.fixture
def free(rig: AskedRig) -> AskedRig:
    """The rig without a call, whose modem is set to answer."""
    until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
    write_peer(rig.folder / "run/teleservice/modem", USER, PASSWORD)
    return rig


def test_pppd_calls_and_reaches_every_service(free: AskedRig, tmp_path: Path) -> None:
    reach_every_service(free, tmp_path)


def test_a_call_whose_line_drops_in_a_transfer_can_be_dialled_again(free: AskedRig, tmp_path: Path) -> None:
    large, arrived = tmp_path / "LARGE.TXT", tmp_path / "arrived"
    large.write_bytes(LARGE)
    put(large, "127.0.0.1:2121")  # over Ethernet
    with mended_at_the_end(free):
        with pppd_call(tmp_path) as call:
            call.until_up()
            fetching = ["curl", "-sS", "-N", "-o", str(arrived), f"http://{CONTROLLER}/LARGE.TXT"]
            with subprocess.Popen(fetching) as fetch:
                try:
                    until(lambda: arrived.exists() and arrived.stat().st_size > 0)
                    # By the open session: on a busy host, the start of a tool takes longer than the transfer.
                    free.control.ask("bus/telephone/add_fault", {"fault": {"what": "cut", "line": "caller_modem"}})
                    assert call.ended() in (NO_ECHO_REPLIES, HUNG_UP), call.output()
                finally:
                    fetch.kill()
            assert "No response to 3 echo-requests" in call.output()
            assert 0 < arrived.stat().st_size < len(LARGE)
        with pppd_call(tmp_path) as call:
            assert call.ended() == DIALLING_FAILED, call.output()
            assert "NO DIALTONE" in call.output()
    until(lambda: free.get("max4/Com1UserState") == OFFLINE)
    with pppd_call(tmp_path) as call:
        call.until_up()
        assert "bytes free" in curl(f"http://{CONTROLLER}/")
        assert call.hang_up() == TERMINATED, call.output()


def test_a_caller_that_is_killed_hangs_up_and_can_call_again(free: AskedRig, tmp_path: Path) -> None:
    with pppd_call(tmp_path) as call:
        call.until_up()
        assert free.get("caller_modem/dtr") is True
        call.process.kill()
        assert call.ended() == -signal.SIGKILL
    until(lambda: free.get("caller_modem/call") == "idle")
    until(lambda: free.get("max4/Com1UserState") == OFFLINE)
    with pppd_call(tmp_path) as call:
        call.until_up()
        assert "bytes free" in curl(f"http://{CONTROLLER}/")
        assert call.hang_up() == TERMINATED, call.output()


def test_a_wrong_password_ends_pppd_with_its_exit_code(free: AskedRig, tmp_path: Path) -> None:
    write_peer(free.folder / "run/teleservice/modem", USER, "wrong")
    with pppd_call(tmp_path) as call:
        assert call.ended() == WRONG_PASSWORD, call.output()
        assert not call.is_up()
