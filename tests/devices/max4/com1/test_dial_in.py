"""Calls to the controller: PPP, the login, and the services over the line (PacDrive manual 7.2)."""

from ipaddress import IPv4Address

import pytest
from dial_in_bench import LOGIN, DialInBench

from fieldrig_bus.tcp.message import Connected, Data, TcpMessage
from fieldrig_bus.tcp.model import PORT
from fieldrig_devices.ip.tcp.connection import Connection
from fieldrig_devices.ip.tcp.states import TcpState
from fieldrig_devices.ppp.phases import End, Phase
from fieldrig_devices.ppp.settings import Login, PppSettings


@pytest.mark.manual("PD-258")
@pytest.mark.manual("PD-250")
def test_a_caller_with_user_name_and_password_gets_its_address() -> None:
    bench = DialInBench().call()
    assert bench.link is not None
    assert bench.link.phase is Phase.RUNNING
    assert bench.link.local_address == IPv4Address("190.200.100.101")
    assert bench.link.peer_address == IPv4Address("190.200.100.100")
    assert bench.get("Com1UserState") == 7


@pytest.mark.long
def test_pages_are_served_over_the_line() -> None:
    bench = DialInBench().call()
    page = bench.page("/AXES.HTM")
    assert page.startswith(b"HTTP/1.1 200 OK\r\n")
    assert b">belt</td>" in page
    assert any("8013" in line and "bec86465" in line for line in bench.max4.firmware.logger.lines())


@pytest.mark.long
@pytest.mark.manual("PD-282")
@pytest.mark.manual("PD-285")
def test_files_are_fetched_and_replaced_over_the_line() -> None:
    bench = DialInBench(ftp={"user_name": "lab", "password": "secret"}).call()
    control, heard = bench.connect(21)
    assert heard.startswith(b"220 ")
    assert bench.ask(control, heard, "USER lab").startswith("331 ")
    assert bench.ask(control, heard, "PASS secret").startswith("230 ")
    port = int(bench.ask(control, heard, "EPSV").split("|")[3])
    data, _ = bench.connect(port)
    assert bench.ask(control, heard, "STOR MINE.HTM").startswith("150 ")
    data.send(b"mine")
    data.end()
    bench.go(500)
    assert b"\r\n226 " in heard
    assert bench.page("/MINE.HTM").endswith(b"\r\n\r\nmine")
    port = int(bench.ask(control, heard, "EPSV").split("|")[3])
    _, arrived = bench.connect(port)
    bench.ask(control, heard, "RETR MINE.HTM")
    assert arrived == b"mine"


@pytest.mark.long
@pytest.mark.manual("PD-274")
def test_a_tool_that_calls_another_address_gets_no_answer() -> None:
    """Cause 1: the address of the tool is not LocalIpAddress."""
    bench = DialInBench().call()
    bench.connect(80)
    assert bench.stack is not None
    wrong = bench.stack.connect(IPv4Address("190.200.100.99"), 80)
    bench.go(20_000)
    assert wrong.state is TcpState.SYN_SENT
    assert bench.page("/INDEX.HTM").startswith(b"HTTP/1.1 200 ")


@pytest.mark.long
@pytest.mark.manual("PD-282")
def test_the_ftp_of_windows_fetches_and_replaces_over_the_line() -> None:
    """It knows active mode only: the controller connects to the caller."""
    bench = DialInBench(ftp={"user_name": "lab", "password": "secret"}).call()
    control, heard = bench.connect(21)
    bench.ask(control, heard, "USER lab")
    bench.ask(control, heard, "PASS secret")
    assert bench.stack is not None
    assert bench.link is not None
    arrived, opened = bytearray(), list[Connection]()

    def accept(connection: Connection) -> None:
        opened.append(connection)
        connection.on_data = arrived.extend

    address = str(bench.link.local_address).replace(".", ",")
    bench.stack.listen(5000, accept)
    assert bench.ask(control, heard, f"PORT {address},19,136").startswith("200 ")
    bench.ask(control, heard, "STOR \\OK.HTM")
    opened[-1].send(b"active")
    opened[-1].end()
    bench.go(500)
    assert b"226 " in heard
    bench.ask(control, heard, f"PORT {address},19,136")
    bench.ask(control, heard, "RETR OK.HTM")
    bench.go(500)
    assert (bytes(arrived), b"226 " in heard) == (b"active", True)
    bench.ask(control, heard, f"PORT {address},19,137")  # where no program listens
    bench.ask(control, heard, "RETR OK.HTM")
    bench.go(500)
    assert b"425 " in heard
    assert bench.ask(control, heard, "PORT 127,0,0,1,19,136").startswith("504 ")


@pytest.mark.long
def test_an_extra_port_that_no_command_opened_is_refused() -> None:
    bench = DialInBench().call()
    connection, _ = bench.connect(50_000)
    assert not connection.is_open


@pytest.mark.long
@pytest.mark.manual("PD-240")
@pytest.mark.manual("PD-241")
@pytest.mark.manual("PD-280")
def test_a_call_and_ethernet_serve_at_the_same_time() -> None:
    bench = DialInBench().call()
    port = bench.rig.attach(PORT).link("lan")
    answers: list[TcpMessage] = []
    port.on_receive(answers.append)
    port.send(Connected(1, "http", "10.0.0.7", "10.0.0.1"))
    port.send(Data(1, b"HEAD / HTTP/1.1\r\nHost: plc\r\n\r\n"))
    assert bench.page("/").startswith(b"HTTP/1.1 200 OK\r\n")
    assert any(isinstance(message, Data) and message.data.startswith(b"HTTP/1.1 200 OK") for message in answers)


@pytest.mark.long
@pytest.mark.manual("PD-273")
@pytest.mark.parametrize(
    "settings", [PppSettings(own=Login(b"service", b"wrong")), PppSettings(own=Login(b"", b"")), PppSettings()]
)
def test_a_caller_without_the_right_login_is_hung_up(settings: PppSettings) -> None:
    bench = DialInBench().call(settings).go(500)
    assert bench.link is not None
    assert bench.link.phase is Phase.DEAD
    bench.go(3000)
    assert bench.get("Com1UserState") == 6
    assert bench.dtr


@pytest.mark.long
@pytest.mark.manual("PD-273")
@pytest.mark.parametrize("address", ["127.0.0.1", "224.0.0.1", "0.0.0.0", "255.255.255.255", "190.200.100.100"])
def test_a_reserved_remote_ip_address_ends_the_call_after_the_login(address: str) -> None:
    bench = DialInBench({"Phone.RemoteIpAddress": address}).call().go(3000)
    assert bench.link is not None
    assert bench.link.peer_name is None
    assert bench.link.phase is Phase.DEAD
    assert bench.link.ended_by is End.PEER_CLOSED


@pytest.mark.manual("PD-273")
def test_a_caller_that_insists_on_another_address_gets_no_connection() -> None:
    bench = DialInBench().call(PppSettings(own=LOGIN, local_address=IPv4Address("190.200.100.102")))
    assert bench.link is not None
    assert bench.link.phase is not Phase.RUNNING


@pytest.mark.parametrize("missing", ["Phone.UserName", "Phone.Password"])
def test_without_a_user_name_or_password_no_call_is_answered(missing: str) -> None:
    bench = DialInBench({missing: ""}).call(PppSettings(own=Login(b"", b"")))
    assert bench.link is not None
    assert bench.link.phase is Phase.DEAD


@pytest.mark.long
def test_three_failed_logins_are_logged_and_slowed() -> None:
    bench = DialInBench()
    for _ in range(2):
        bench.call(PppSettings(own=Login(b"mallory", b"x"))).go(4000)
    assert not any("8574" in line for line in bench.max4.firmware.logger.lines())
    bench.call(PppSettings(own=Login(b"mallory", b"x"))).go(20_000)
    assert any("8574" in line and "mallory" in line for line in bench.max4.firmware.logger.lines())
    bench.call()
    assert bench.link is not None
    assert bench.link.phase is Phase.AUTHENTICATE
    assert bench.go(12_000).link.phase is Phase.RUNNING  # type: ignore[union-attr]


@pytest.mark.long
@pytest.mark.manual("PD-275")
def test_a_line_that_drops_in_a_transfer_can_be_dialled_again() -> None:
    bench = DialInBench().call()
    bench.page("/PARAMS.HTM", ms=300)
    assert bench.link is not None
    bench.drop()
    bench.link.down(bench.rig.now_ns)
    bench.stack = None
    assert bench.go(2000).get("Com1UserState") == 6
    assert bench.call().page("/").startswith(b"HTTP/1.1 200 OK\r\n")


@pytest.mark.long
@pytest.mark.manual("PD-275")
def test_a_reset_of_the_controller_drops_the_call_and_another_one_is_answered() -> None:
    bench = DialInBench().call()
    bench.set("command", "system reset").go(5000)
    assert bench.link is not None
    assert bench.link.phase is Phase.DEAD
    assert bench.get("Com1UserState") == 6
    bench.stack = None
    assert bench.call().page("/").startswith(b"HTTP/1.1 200 OK\r\n")


@pytest.mark.manual("PD-256")
def test_a_change_of_com1_user_ends_the_call() -> None:
    bench = DialInBench().call()
    bench.set("Com1User", 0).go(2000)
    assert bench.link is not None
    assert bench.link.phase is Phase.DEAD


LONG_PAGE = b"GET /PARAMS.HTM HTTP/1.1\r\nHost: 190.200.100.100\r\nConnection: close\r\n\r\n"


@pytest.mark.long
def test_an_echo_of_lcp_does_not_wait_behind_pages() -> None:
    """A caller with pppd takes the line for lost after some seconds without an answer."""
    bench = DialInBench().call()
    idle_ms = bench.echo_ms()
    pages = [bench.connect(80) for _ in range(6)]
    for connection, _ in pages:
        connection.send(LONG_PAGE)
    waits_ms = [bench.go(500).echo_ms() for _ in range(8)]
    assert any(connection.is_open for connection, _ in pages), "the pages were too short for this test"
    assert idle_ms < 100
    assert max(waits_ms) < 1200  # 1024 bytes and two packets of 1500 at 3840 bytes a second
    assert min(len(arrived) for _, arrived in pages) > 1000  # they take turns


@pytest.mark.long
def test_a_caller_that_sends_much_has_no_more_than_2_s_of_it_under_way() -> None:
    bench = DialInBench(ftp={"user_name": "lab", "password": "secret"}).call()
    control, heard = bench.connect(21)
    bench.ask(control, heard, "USER lab")
    bench.ask(control, heard, "PASS secret")
    port = int(bench.ask(control, heard, "EPSV").split("|")[3])
    data, _ = bench.connect(port)
    bench.ask(control, heard, "STOR LONG.TXT")
    data.send(bytes(40_000))
    for _ in range(50):
        bench.go(100)
        assert data.outgoing.in_flight <= 8192
