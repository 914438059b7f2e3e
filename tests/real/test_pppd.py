"""Our PPP against pppd of Linux at the other end, as the called and as the calling side."""

from ipaddress import IPv4Address
from pathlib import Path

import pytest
from ppp_bench import CALLER, CALLER_END, CONTROLLER, CONTROLLER_END
from pppd import ECHO_REQUEST, SECRETS, echo_message, is_in_guest, ping_socket, pppd_on_pty, reply_in

from fieldrig_devices.ppp.phases import End, Phase

pytestmark = [
    pytest.mark.real,
    pytest.mark.ppp,
    pytest.mark.skipif(not is_in_guest(), reason="runs inside user-mode Linux: `python -m tests.driver ppp`"),
]

AS_CLIENT = ("noauth", "user", "lab", "usepeerdns")
AS_SERVER = ("require-pap", f"{CONTROLLER}:{CALLER}")
PING = bytes.fromhex("1234 0001") + bytes(range(256)) * 5
WRONG_PASSWORD = 19  # pppd(8), EXIT STATUS
REFUSED_TO_AUTHENTICATE = 11


@pytest.fixture(autouse=True)
def password() -> None:
    SECRETS.write_text("lab * geheim *\n")


@pytest.mark.manual("PD-250", "PD-258", "PD-260")
def test_pppd_dials_in_and_pings_the_controller(tmp_path: Path) -> None:
    with pppd_on_pty(CONTROLLER_END, tmp_path, *AS_CLIENT) as line:
        line.run_until(lambda: line.link.phase is Phase.RUNNING and "local  IP address" in line.output())
        assert f"local  IP address {CALLER}" in line.output()
        assert f"remote IP address {CONTROLLER}" in line.output()
        with ping_socket(str(CONTROLLER)) as raw:
            raw.send(echo_message(ECHO_REQUEST, PING))
            line.run_until(lambda: reply_in(raw) == PING)
        assert line.attempts[-1].is_accepted
        refused = ("CCP", "IPV6CP", "compress VJ")
        assert [name for name in refused if name not in line.output()] == []  # pppd has asked for all of them
        line.link.close(0)
        line.run_until_end()
        assert "LCP terminated by peer" in line.output()
    assert line.link.ended_by is End.CLOSED


@pytest.mark.manual("PD-273")
def test_wrong_password_ends_pppd_with_its_exit_code(tmp_path: Path) -> None:
    SECRETS.write_text("lab * falsch *\n")
    with pppd_on_pty(CONTROLLER_END, tmp_path, *AS_CLIENT) as line:
        assert line.run_until_end() == WRONG_PASSWORD
        line.run_until(lambda: line.link.phase is Phase.DEAD)
    assert line.link.ended_by is End.LOGIN_FAILED
    assert Phase.RUNNING not in line.phases


@pytest.mark.manual("PD-259", "PD-273")
def test_pppd_that_sends_only_encrypted_passwords_is_not_let_in(tmp_path: Path) -> None:
    with pppd_on_pty(CONTROLLER_END, tmp_path, *AS_CLIENT, "refuse-pap") as line:
        line.run_until(lambda: line.link.phase is Phase.DEAD)
        line.hang_up()  # pppd would go on asking
        assert line.run_until_end() != 0
    assert line.link.ended_by is End.NO_AUTHENTICATION
    assert line.attempts == []


def test_our_end_dials_in_to_pppd_and_pings_it(tmp_path: Path) -> None:
    with pppd_on_pty(CALLER_END, tmp_path, *AS_SERVER) as line:
        line.run_until(lambda: line.link.phase is Phase.RUNNING and "local  IP address" in line.output())
        assert (line.link.local_address, line.link.peer_address) == (CALLER, CONTROLLER)
        line.ping(PING)
        line.run_until(lambda: bool(line.replies))
        assert line.replies == [PING]
        line.terminate()
        line.run_until_end()
        line.run_until(lambda: line.link.phase is Phase.DEAD)
    assert line.link.ended_by is End.PEER_CLOSED


def test_pppd_that_demands_chap_gets_no_password(tmp_path: Path) -> None:
    SECRETS.with_name("chap-secrets").write_text("lab * geheim *\n")
    with pppd_on_pty(CALLER_END, tmp_path, "require-chap", f"{CONTROLLER}:{CALLER}") as line:
        assert line.run_until_end() == REFUSED_TO_AUTHENTICATE
        line.run_until(lambda: line.link.phase is Phase.DEAD)
        assert "PAP AuthReq" not in line.output()
    assert line.link.local_address == IPv4Address(0)
    assert Phase.RUNNING not in line.phases
