"""`fieldrig dial` as a user runs it: a process, a pty, local ports, and Ctrl-C."""

import signal
import socket

import pytest
from dial_peer import PAGE, PtyPeer
from dialled import LOGIN, dialled

from fieldrig.testing import free_port

pytestmark = pytest.mark.system


def exchange(port: int, request: bytes, ends: bool = True) -> bytes:
    found = bytearray()
    with socket.create_connection(("127.0.0.1", port), timeout=60) as client:
        client.sendall(request)
        if ends:
            client.shutdown(socket.SHUT_WR)
        while chunk := client.recv(65536):
            found += chunk
    return bytes(found)


def test_local_ports_lead_to_the_services_until_ctrl_c() -> None:
    pages, echoes = free_port(), free_port()
    forwards = ("--forward", f"{pages}:80", "--forward", f"{echoes}:7")
    with PtyPeer() as peer, dialled(peer.path, *LOGIN, *forwards) as run:
        run.until("Ctrl-C hangs up.")
        assert exchange(pages, b"GET", ends=False) == PAGE
        data = bytes(place & 0xFF for place in range(200_000))
        assert exchange(echoes, data) == data
        run.process.send_signal(signal.SIGINT)
        assert run.end() == (0, "The call has ended.\n")
        assert peer.end.commands[-1] == b"ATH"


def test_the_second_ctrl_c_does_not_wait_for_a_controller_that_is_silent() -> None:
    with PtyPeer() as peer, dialled(peer.path, *LOGIN, "--forward", f"{free_port()}:80") as run:
        run.until("Ctrl-C hangs up.")
        peer.stop()
        run.process.send_signal(signal.SIGINT)
        run.process.send_signal(signal.SIGTERM)
        assert run.end() == (0, "The call has ended.\n")


def test_a_proxy_leads_to_every_port_of_the_controller_and_to_no_other_host() -> None:
    port = free_port()
    with PtyPeer() as peer, dialled(peer.path, *LOGIN, "--socks", str(port)) as run:
        run.until(f"127.0.0.1:{port} leads to every port of the controller.")
        run.until("Ctrl-C hangs up.")
        hello = bytes.fromhex("05 01 00")
        to_echo, to_other = bytes.fromhex("05 01 00 01 be c8 64 64 0007"), bytes.fromhex("05 01 00 01 be c8 64 63 0007")
        assert exchange(port, hello + to_echo + b"echo") == bytes.fromhex("0500 05000001 00000000 0000") + b"echo"
        to_closed = to_echo[:-2] + bytes.fromhex("0009")
        assert exchange(port, hello + to_closed, ends=False) == bytes.fromhex("0500 05050001 00000000 0000")
        assert exchange(port, hello + to_other, ends=False) == bytes.fromhex("0500 05030001 00000000 0000")
        for wrong, code in (("05020001 bec86464 0007", 7), ("05010002", 8), ("04", 1)):
            answer = exchange(port, hello + bytes.fromhex(wrong), ends=False)
            assert answer == bytes((5, 0, 5, code, 0, 1)) + bytes(6)


def test_a_lost_carrier_ends_with_a_sentence() -> None:
    with PtyPeer() as peer, dialled(peer.path, *LOGIN, "--forward", f"{free_port()}:80") as run:
        run.until("Ctrl-C hangs up.")
        peer.hang_up()
        assert run.end() == (6, "error: The connection was lost.\n  Call again.\n")


def test_a_wrong_password_ends_with_a_sentence() -> None:
    login = ("--user", "service", "--password", "wrong")
    with PtyPeer() as peer, dialled(peer.path, *login, "--forward", f"{free_port()}:80") as run:
        code, text = run.end()
        assert (code, "The controller refuses the user name or the password." in text) == (6, True)


def test_a_local_port_that_is_taken_costs_no_call() -> None:
    with PtyPeer() as peer, socket.create_server(("127.0.0.1", 0)) as taken:
        with dialled(peer.path, *LOGIN, "--forward", f"{taken.getsockname()[1]}:80") as run:
            code, text = run.end()
        assert (code, peer.end.commands) == (3, []), text


@pytest.mark.parametrize("forward", ["80", "a:80", "80:0", "1:65536", "1:2:3", ""])
def test_a_wrong_pair_of_ports_is_explained(forward: str) -> None:
    with dialled("/dev/null", "--forward", forward) as run:
        code, text = run.end()
    assert (code, "expected LOCAL:REMOTE" in " ".join(text.split())) == (2, True), text
