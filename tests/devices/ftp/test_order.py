"""Commands that a client sends without waiting for replies, and what holds for the next transfer only.

Source: RFC 959, 4.1.1 (REIN, QUIT) and 4.1.3 (ABOR, STAT); RFC 2428, 3; RFC 3659, 5.3 and 7.9.
"""

import pytest
from ftp_bench import Client
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.ftp.server import MOST_LINES


@pytest.mark.parametrize("command", ["NOOP", "DELE B.HTM", "USER service", "REIN", "QUIT", "PASV", "CWD /", "REST 2"])
@pytest.mark.parametrize("is_sending", [True, False])
def test_a_command_behind_a_transfer_waits_for_its_end(command: str, is_sending: bool) -> None:
    alone = Client().do(command)
    client = Client()
    client.do("EPSV")
    assert client.do(f"{'RETR A.HTM' if is_sending else 'STOR A.HTM'}\r\n{command}") == ""
    data = client.data()
    if not is_sending:
        data.send(b"new")
        assert client.codes() == "150"
        assert data.take() == b""
        data.end()
        assert client.codes() == f"226 {alone}"
    else:
        assert (client.codes(), data.take()) == (f"150 226 {alone}", b"page a")
    assert client.folder.files["A.HTM"] == (b"page a" if is_sending else b"new")
    assert client.control.is_closed == (command == "QUIT")


def test_stat_is_answered_during_a_transfer() -> None:
    client = Client()
    client.do("EPSV")
    client.do("STOR A.HTM")
    assert "A transfer is under way." in client.ask("STAT")


def test_abor_ends_the_transfer_in_front_of_it_and_every_command_is_answered_in_its_order() -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    client.do("STOR A.HTM")
    data.send(b"half")
    assert client.do("NOOP\r\nSIZE A.HTM") == ""
    assert client.do("ABOR") == "426 200 213 226"
    assert client.folder.files["A.HTM"] == b"page a"


def test_replies_keep_their_order_while_a_port_is_opened() -> None:
    client = Client()
    client.control.is_opening_late = True
    assert client.do("PASV\r\nSIZE A.HTM\r\nRETR no\r\nNOOP") == ""
    client.control.opened()
    assert client.codes() == "227 213 550 200"


def test_a_client_that_sends_commands_without_end_behind_a_transfer_is_closed() -> None:
    client = Client()
    client.do("EPSV")
    client.do("RETR A.HTM")
    assert client.control.send(b"NOOP\r\n" * MOST_LINES) == b""
    assert client.do("NOOP") == "421"
    assert client.control.is_closed


def test_many_commands_at_once_are_answered() -> None:
    client = Client()
    assert client.control.send(b"NOOP\r\n" * 1_000).count(b"200 ") == 1_000


@pytest.mark.parametrize("refused", ["RETR A.HTM", "RETR no", "LIST"])
def test_a_restart_is_for_the_next_transfer_also_if_that_is_refused(refused: str) -> None:
    client = Client()
    client.do("REST 3")
    if refused != "RETR A.HTM":
        client.do("EPSV")
        client.data()
    client.do(refused)
    client.do("EPSV")
    data = client.data()
    client.do("RETR A.HTM")
    assert data.take() == b"page a"


@pytest.mark.parametrize(
    "verb",
    ["ALLO", "APPE", "CWD", "DELE", "MDTM", "MKD", "MODE", "RETR", "RMD", "RNFR", "RNTO", "SIZE", "STOR", "STRU",
     "TYPE", "PORT", "EPRT", "REST"],
)  # fmt: skip
@pytest.mark.parametrize("argument", ["", " ", "  "])
def test_a_command_without_its_argument_is_a_mistake_in_the_syntax(verb: str, argument: str) -> None:
    client = Client()
    client.do("EPSV")
    client.do("RNFR A.HTM")
    assert client.do(verb + argument) == "501"


@pytest.mark.parametrize(
    ("wanted", "reply", "facts", "feature"),
    [
        ("size;type;", "type;size;", b"type=file;size=6; A.HTM", "type*;size*;modify;perm;"),
        ("Modify;unix.mode;", "modify;", b"modify=20030101000000; A.HTM", "type;size;modify*;perm;"),
        ("", "", b" A.HTM", "type;size;modify;perm;"),
    ],
)
def test_a_client_chooses_the_facts_of_its_lists(wanted: str, reply: str, facts: bytes, feature: str) -> None:
    client = Client()
    assert client.ask(f"OPTS MLST {wanted}".strip()) == f"200 MLST OPTS {reply}".strip() + "\r\n"
    client.do("EPSV")
    data = client.data()
    client.do("MLSD")
    assert data.take().split(b"\r\n")[0] == facts
    assert f" {facts.decode()}\r\n" in client.ask("MLST A.HTM")
    assert f" MLST {feature}\r\n" in client.ask("FEAT")
    client.do("REIN")
    assert " MLST type*;size*;modify*;perm*;\r\n" in client.ask("FEAT")


QUICK = {
    "NOOP": "200",
    "SIZE A.HTM": "213",
    "PWD": "257",
    "STAT": "211",
    "XYZZY": "500",
    "RETR": "501",
    "TYPE E": "504",
}


@given(st.lists(st.sampled_from([*QUICK, "EPSV", "RETR A.HTM"]), max_size=12), st.lists(st.integers(1, 40), max_size=8))
def test_each_command_has_its_reply_in_its_order_however_the_bytes_arrive(commands: list[str], cuts: list[int]) -> None:
    """A client that opens each data connection when its port is named gets what it gets by waiting each time."""
    client = Client()
    stream = "".join(f"{command}\r\n" for command in commands).encode()
    for cut in cuts:
        client.control.session.received(stream[:cut])
        stream = stream[cut:]
    client.control.session.received(stream)
    expected, is_open = [], False
    for command in commands:
        if command == "RETR A.HTM":
            expected.append("150 226" if is_open else "425")
            is_open = False
        elif command == "EPSV":
            expected.append("229")
            is_open = True
        else:
            expected.append(QUICK[command])
    while client.control.serve_extra is not None:
        client.data()
    got = client.control.take().decode()
    codes = [line[:3] for line in got.split("\r\n") if line[:3].isdigit() and line[3:4] == " "]
    if "STAT" in commands:
        codes, expected = ([code for code in " ".join(row).split() if code != "211"] for row in (codes, expected))
    assert codes == " ".join(expected).split()
