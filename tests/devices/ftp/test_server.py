"""FTP on one control connection, with the replies of RFC 959."""

import pytest
from ftp_bench import Client, Folder
from hypothesis import given
from hypothesis import strategies as st
from tcp_client import ServedConnection

from fieldrig_devices.ftp.server import LONGEST_LINE


@pytest.mark.parametrize(
    ("command", "code"),
    [
        ("NOOP", "200"), ("noop", "200"), ("SYST", "215"), ("PWD", "257"), ("XPWD", "257"), ("CWD /", "250"),
        ("CWD ..", "250"), ("CWD etc", "550"), ("CDUP", "200"), ("TYPE I", "200"), ("TYPE A", "200"),
        ("TYPE A N", "200"), ("TYPE E", "504"), ("MODE S", "200"), ("MODE B", "504"), ("STRU F", "200"),
        ("STRU R", "504"), ("ALLO 9", "202"),
        ("FEAT", "211"), ("OPTS UTF8 ON", "200"), ("OPTS X", "501"), ("SIZE a.htm", "213"), ("SIZE no", "550"),
        ("DELE no", "550"), ("DELE /A.HTM", "250"), ("MKD x", "550"), ("RMD x", "550"), ("RNFR no", "550"),
        ("RNTO x", "503"), ("PASV", "227"), ("EPSV", "229"), ("EPSV ALL", "200"), ("EPSV 3", "522"),
        ("EPSV 1", "229"), ("EPSV 2", "522"), ("CWD /.", "250"), ("CWD .\\", "250"),
        ("CWD /../.", "250"), ("CWD a/..", "550"),
        ("ALLO 9 R 80", "202"), ("ALLO x", "501"), ("ALLO 9 R", "501"), ("EPRT |1|10.0.0.7|65536|", "501"),
        ("EPRT |1|10.0.0.7|0|", "501"), ("OPTS MLST size;", "200"), ("OPTS MLST", "200"),
        ("RETR A.HTM", "425"),
        ("LIST", "425"), ("MLSD", "425"), ("APPE A.HTM", "425"), ("ABOR", "226"), ("AUTH TLS", "502"), ("STOU", "502"),
        ("PORT 10,0,0,7,4,0", "200"), ("PORT 10,0,0,7,3,255", "504"), ("PORT 10,0,0,8,4,0", "504"),
        ("PORT 10,0,0,7,256,0", "501"), ("PORT", "501"), ("EPRT |1|10.0.0.7|1024|", "200"),
        ("EPRT !2!::ffff:10.0.0.7!1024!", "200"), ("EPRT |1|10.0.0.8|1024|", "504"), ("EPRT |1|10.0.0.7|80|", "504"),
        ("EPRT |3|10.0.0.7|1024|", "522"), ("EPRT |2|10.0.0.7|1024|", "501"), ("EPRT |1|plc|1024|", "501"),
        ("REST 1", "350"), ("REST -1", "501"), ("REST", "501"), ("MDTM a.htm", "213"), ("MDTM no", "550"),
        ("STAT", "211"), ("STAT *.HTM", "213"), ("STAT no", "550"), ("HELP", "214"), ("HELP stor", "214"),
        ("HELP XYZZY", "502"), ("ACCT x", "202"), ("REIN", "220"), ("MLST a.htm", "250"), ("MLST", "250"),
        ("MLST no", "550"), ("XYZZY", "500"), ("", "500"), ("PASS x", "503"),
        ("QUIT", "221"),
    ],
)  # fmt: skip
def test_a_command_has_its_reply(command: str, code: str) -> None:
    assert Client().do(command) == code


@pytest.mark.parametrize(
    "command",
    [
        "PWD",
        "CWD",
        "TYPE",
        "PASV",
        "EPSV",
        "LIST",
        "NLST",
        "RETR",
        "STOR",
        "SIZE",
        "DELE",
        "RNFR",
        "RNTO",
        "MKD",
        "ABOR",
        "PORT",
        "EPRT",
        "APPE",
        "REST",
        "MDTM",
        "STAT",
        "MLSD",
        "MLST",
    ],
)
def test_nothing_is_done_before_the_login(command: str) -> None:
    client = Client(is_logged_in=False)
    assert client.do(f"{command} A.HTM") == "530"
    assert client.do("USER service") == "331"
    assert client.do(f"{command} A.HTM") == "530"
    assert client.control.serve_extra is None


def test_passive_replies_name_address_and_port() -> None:
    client = Client()
    assert client.ask("PASV") == "227 Entering Passive Mode (10,0,0,1,195,81).\r\n"
    assert client.ask("EPSV") == "229 Entering Extended Passive Mode (|||50001|)\r\n"
    client.control.local = "fd00::1"
    assert client.do("PASV") == "425"


@pytest.mark.parametrize("connects_first", [True, False])
def test_a_file_is_fetched(connects_first: bool) -> None:
    client = Client()
    client.do("EPSV")
    if connects_first:
        data = client.data()
        assert client.do("RETR a.htm") == "150 226"
    else:
        assert client.do("RETR a.htm") == ""
        data = client.data()
        assert client.codes() == "150 226"
    assert data.take() == b"page a"
    assert data.is_closed
    assert client.do("RETR a.htm") == "425"


def test_lists() -> None:
    client = Client()
    client.do("PASV")
    data = client.data()
    client.do("NLST")
    assert data.take() == b"A.HTM\r\nB.HTM\r\n"
    client.do("PASV")
    data = client.data()
    client.do("LIST")
    assert data.take().split(b"\r\n")[0].split() == b"-rw-rw-rw- 1 max4 max4 6 Jan 01 2003 A.HTM".split()


@pytest.mark.parametrize(
    ("command", "lines"),
    [
        ("NLST *.htm", b"A.HTM B.HTM"), ("NLST a*", b"A.HTM"), ("NLST x*", b""), ("NLST b.htm", b"B.HTM"),
        ("NLST -al", b"A.HTM B.HTM"), ("NLST /", b"A.HTM B.HTM"),
        ("LIST -a \\*b.*", b"-rw-rw-rw- 1 max4 max4 6 Jan 01 2003 B.HTM"),
    ],
)  # fmt: skip
def test_a_list_of_some_files(command: str, lines: bytes) -> None:
    """The `mget *.htm` of a client begins with NLST *.htm."""
    client = Client()
    client.do("PASV")
    data = client.data()
    assert client.do(command) == "150 226"
    assert data.take().split() == lines.split()


def test_mlsd_has_facts() -> None:
    """RFC 3659, 7.2."""
    client = Client()
    client.do("PASV")
    data = client.data()
    client.do("MLSD")
    facts = b"type=file;size=6;modify=20030101000000;perm=adfrw; "
    assert data.take() == facts + b"A.HTM\r\n" + facts + b"B.HTM\r\n"


def test_a_list_of_a_file_that_does_not_exist_is_refused() -> None:
    client = Client()
    client.do("PASV")
    assert client.do("NLST no.htm") == "550"


def test_the_last_command_for_a_data_connection_counts() -> None:
    client = Client()
    client.do("PASV")
    first = client.data()
    assert client.do("EPSV") == "229"
    assert first.is_closed
    assert client.do("PORT 10,0,0,7,195,80") == "200"
    assert client.control.serve_extra is None
    assert client.do("PASV") == "227"
    second = client.data()
    assert client.do("RETR A.HTM") == "150 226"
    assert (client.control.connecting, second.take()) == (None, b"page a")


def open_active(client: Client) -> ServedConnection:
    """The server connects to the client, which has named its port."""
    assert client.control.connecting is not None
    number, _, serve = client.control.connecting
    assert number == 50_000
    return ServedConnection(serve)


@pytest.mark.parametrize("port", ["PORT 10,0,0,7,195,80", "EPRT |1|10.0.0.7|50000|"])
def test_a_file_is_fetched_in_active_mode(port: str) -> None:
    client = Client()
    client.do(port)
    assert client.control.connecting is None, "the server connects when a transfer begins"
    assert client.do("RETR a.htm") == ""
    data = open_active(client)
    assert client.codes() == "150 226"
    assert (data.take(), data.is_closed) == (b"page a", True)
    assert client.do("RETR a.htm") == "425"


def test_a_file_is_stored_in_active_mode() -> None:
    client = Client()
    client.do("PORT 10,0,0,7,195,80")
    client.do("STOR new.htm")
    data = open_active(client)
    data.send(b"new page")
    data.end()
    assert client.codes() == "150 226"
    assert client.folder.files["NEW.HTM"] == b"new page"


def test_a_client_that_does_not_accept_its_data_connection_gets_425() -> None:
    client = Client()
    client.do("PORT 10,0,0,7,195,80")
    client.do("RETR a.htm")
    assert client.control.connecting is not None
    _, on_failed, _ = client.control.connecting
    on_failed()
    assert client.codes() == "425"
    assert client.do("EPSV") == "229"


def test_the_dialogue_of_the_ftp_of_windows() -> None:
    """Its commands for `open`, `pwd`, `cd`, `dir`, `ls`, `ascii`, `get`, `binary`, `put`, `mget` and so on."""
    client = Client(is_logged_in=False)
    for command, code in (("OPTS UTF8 ON", "200"), ("USER service", "331"), ("PASS pacdrive", "230"),
                          ("XPWD", "257"), ("CWD /", "250")):  # fmt: skip
        assert client.do(command) == code
    assert b"A.HTM" in transferred(client, "LIST")
    assert transferred(client, "NLST") == b"A.HTM\r\nB.HTM\r\n"
    assert client.do("TYPE A") == "200"
    assert transferred(client, "RETR a.htm") == b"page a"
    assert client.do("TYPE I") == "200"
    assert client.do("PORT 10,0,0,7,195,80") == "200"
    client.do("STOR new.htm")
    data = open_active(client)
    data.send(b"new")
    data.end()
    assert client.codes() == "150 226"
    assert [client.do("TYPE A"), transferred(client, "NLST *.htm")] == ["200", b"A.HTM\r\nB.HTM\r\nNEW.HTM\r\n"]
    assert [transferred(client, f"RETR {name}") for name in ("A.HTM", "NEW.HTM")] == [b"page a", b"new"]
    assert [client.do(command) for command in ("DELE new.htm", "XCWD \\", "XMKD x", "QUIT")] == [
        "250",
        "250",
        "550",
        "221",
    ]


def transferred(client: Client, command: str) -> bytes:
    """Do a transfer as the `ftp` of Windows does: name a port, then give the command; return the data."""
    assert client.do("PORT 10,0,0,7,195,80") == "200"
    client.do(command)
    data = open_active(client)
    assert client.codes() == "150 226"
    return data.take()


@pytest.mark.parametrize(
    "line", ["POST / HTTP/1.1", "post / http/1.1", "QUERY /a HTTP/1.1", "Get http://plc/ HTTP/1.1"]
)
@pytest.mark.parametrize("is_logged_in", [False, True])
def test_a_request_of_http_ends_the_connection_before_any_other_line(line: str, is_logged_in: bool) -> None:
    client = Client(is_logged_in=is_logged_in)
    assert client.do(f"{line}\r\nUSER service\r\nPASS pacdrive\r\nDELE A.HTM") == "500"
    assert client.control.is_closed
    assert "A.HTM" in client.folder.files


def test_epsv_all_leaves_no_other_command_for_data_connections() -> None:
    """RFC 2428, 4."""
    client = Client()
    client.do("EPSV ALL")
    assert [client.do(command) for command in ("PASV", "PORT 10,0,0,7,4,0", "EPRT |1|10.0.0.7|1024|")] == ["503"] * 3
    assert client.do("EPSV") == "229"


def test_a_transfer_is_resumed() -> None:
    client = Client()
    client.do("REST 3")
    client.do("EPSV")
    data = client.data()
    assert client.do("RETR a.htm") == "150 226"
    assert data.take() == b"e a"
    client.do("EPSV")
    data = client.data()
    client.do("RETR a.htm")
    assert data.take() == b"page a", "REST is for one transfer"


@pytest.mark.parametrize(
    ("commands", "content"),
    [
        (["APPE a.htm"], b"page a, more"), (["APPE c.htm"], b", more"), (["REST 4", "STOR a.htm"], b"page, more"),
        (["REST 6", "STOR a.htm"], b"page a, more"), (["REST 0", "STOR a.htm"], b", more"),
        (["REST 2", "APPE a.htm"], b"page a, more"),
    ],
)  # fmt: skip
def test_a_file_goes_on(commands: list[str], content: bytes) -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    for command in commands:
        client.do(command)
    data.send(b", more")
    data.end()
    assert client.codes() == "226"
    assert client.folder.files[commands[-1].split()[1].upper()] == content


@pytest.mark.parametrize("command", ["RETR A.HTM", "STOR A.HTM", "STOR NEW"])
def test_no_transfer_begins_behind_the_end_of_a_file(command: str) -> None:
    client = Client()
    client.do("EPSV")
    client.do("REST 7")
    assert client.do(command) == "554"


def test_help_names_every_command_and_stat_the_transfer() -> None:
    client = Client()
    assert {"APPE", "EPRT", "HELP", "MDTM", "PORT", "REST", "RETR", "SIZE", "STAT"} <= set(client.ask("HELP").split())
    client.do("EPSV")
    client.do("STOR A.HTM")
    assert "A transfer is under way." in client.ask("STAT")


def test_a_new_user_begins_from_the_start() -> None:
    client = Client()
    client.do("REST 3")
    client.do("EPSV ALL")
    assert client.do("REIN") == "220"
    assert client.do("NLST") == "530"
    client.do("USER service")
    client.do("PASS pacdrive")
    client.do("PASV")
    data = client.data()
    client.do("RETR a.htm")
    assert data.take() == b"page a"


def test_a_file_is_stored_when_it_is_complete() -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    assert client.do("STOR new.htm") == "150"
    data.send(b"new ")
    data.send(b"page")
    assert "NEW.HTM" not in client.folder.files
    data.end()
    assert client.codes() == "226"
    assert client.folder.files["NEW.HTM"] == b"new page"


def test_data_that_end_before_the_command_are_stored() -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    data.send(b"early")
    data.end()
    assert client.do("STOR x") == "150 226"
    assert client.folder.files["X"] == b"early"


@pytest.mark.parametrize("how", ["the data connection breaks", "the control connection breaks", "control ends", "ABOR"])
def test_half_a_file_leaves_the_old_one(how: str) -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    client.do("STOR A.HTM")
    data.send(b"half")
    match how:
        case "the data connection breaks":
            data.lose()
            assert client.codes() == "426"
        case "the control connection breaks":
            client.control.lose()
        case "control ends":
            client.control.end()
        case "ABOR":
            assert client.control.send(b"\xff\xf4\xff\xf2ABOR\r\n").startswith(b"426 ")
    data.end()
    assert client.folder.files["A.HTM"] == b"page a"
    assert data.is_closed


@pytest.mark.parametrize(
    "signals",
    [
        b"\xff\xf4\xff\xf2",  # interrupt process, data mark
        b"\xff\xf4\xff",  # the data mark was urgent data, and is read apart
        b"\xff\xf2",
        b"\xff\xf4\xf2",  # tnftp: the FFh of the data mark was urgent data
        b"\xff\xfd\x03\xff\xfb\x18",  # do suppress go ahead, will terminal type
        b"\xff\xfe\x0c",  # do not use an option
        b"\xff\xf1",
    ],
)
def test_commands_of_telnet_before_one_of_ftp_are_skipped(signals: bytes) -> None:
    client = Client()
    assert client.control.send(signals + b"ABOR\r\n") == b"226 Closing data connection; transfer aborted.\r\n"


def test_a_file_that_does_not_fit_is_refused() -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    client.do("STOR big")
    data.send(bytes(1000))
    data.end()
    assert client.codes() == "552"
    client.do("EPSV")
    data = client.data()
    client.do("STOR bigger")
    data.send(bytes(10_000))
    assert client.codes() == "552"
    assert data.is_closed
    assert client.folder.names == ["A.HTM", "B.HTM"]


def test_a_file_is_renamed() -> None:
    client = Client()
    assert client.do("RNFR a.htm") == "350"
    assert client.do("RNTO c.htm") == "250"
    assert client.folder.names == ["B.HTM", "C.HTM"]
    client.do("RNFR b.htm")
    client.do("NOOP")
    assert client.do("RNTO d.htm") == "503"


@pytest.mark.parametrize("path", ["../x", "/etc/passwd", "/", "a/../../x"])
def test_no_path_leads_out_of_the_folder(path: str) -> None:
    client = Client()
    client.do("EPSV")
    data = client.data()
    for verb in ("RETR", "DELE", "SIZE", "MDTM", "RNFR"):
        assert client.do(f"{verb} {path}") == "550"
    for verb in ("STOR", "APPE"):
        assert client.do(f"{verb} {path}") == "553"
    assert client.do("RNFR A.HTM") == "350"
    assert client.do(f"RNTO {path}") == "553"
    data.end()
    assert client.folder.names == ["A.HTM", "B.HTM"]


def test_a_reason_in_a_reply_is_one_line() -> None:
    assert Client().ask("DELE a\tb") == "550 expected the name of a file, got A?B\r\n"


def test_a_client_that_does_not_connect_gets_425() -> None:
    client = Client()
    client.do("EPSV")
    client.do("RETR A.HTM")
    client.run(31)
    assert client.codes() == "425"


def test_a_stalled_transfer_ends_and_a_slow_one_does_not() -> None:
    client = Client()
    client.folder.files["A.HTM"] = bytes(500)
    client.do("EPSV")
    assert client.control.serve_extra is not None
    data = ServedConnection(client.control.serve_extra, is_taking=False)
    assert client.do("RETR A.HTM") == "150"
    for _ in range(4):
        client.run(50)
        data.accept(100)
    assert client.codes() == ""
    client.run(130)
    assert client.codes() == "426"


def test_three_failed_logins_end_the_connection_are_reported_and_slow_down_others() -> None:
    client = Client(is_logged_in=False)
    for _ in range(2):
        client.do("USER mallory")
        assert client.do("PASS x") == "530"
    assert client.refused == []
    client.do("USER mallory")
    assert client.do("PASS x") == ""
    assert client.refused == ["mallory"]
    client.run(10)
    assert client.codes() == "421"
    assert client.control.is_closed
    client.control = client.connect()
    client.do("USER eve")
    assert client.do("PASS y") == ""
    assert client.do("NOOP") == ""
    client.run(10)
    assert client.codes() == "530 200"
    client.do("USER service")
    assert client.do("PASS pacdrive") == "230"
    client.do("USER mallory")
    assert client.do("PASS x") == "530"


def test_a_line_that_is_too_long_ends_the_connection() -> None:
    client = Client()
    assert client.control.send(b"x" * (LONGEST_LINE + 1)) == b"500 Command line too long.\r\n"
    assert client.control.is_closed


def test_an_idle_connection_is_closed() -> None:
    client = Client()
    client.run(301)
    assert client.codes() == "421"
    assert client.control.is_closed
    assert client.clock.next_ns() is None


def test_a_client_that_reads_no_replies_is_closed() -> None:
    client = Client()
    client.control.is_taking = False
    for _ in range(10_000):
        client.control.send(b"NOOP\r\n")
    assert client.control.is_closed


VERBS = [
    "USER", "PASS", "QUIT", "SYST", "FEAT", "NOOP", "PWD", "CWD", "TYPE", "PASV", "EPSV", "LIST", "NLST", "RETR",
    "STOR", "ABOR", "SIZE", "DELE", "RNFR", "RNTO", "MKD", "X", "PORT", "EPRT", "REST", "APPE", "STAT", "MDTM", "MLSD",
    "MLST", "HELP", "REIN",
]  # fmt: skip
ARGUMENTS = [
    "",
    "A.HTM",
    "service",
    "pacdrive",
    "../x",
    "\xff\x00",
    "I",
    "1",
    "*[!",
    "10,0,0,7,195,80",
    "|1|10.0.0.7|50000|",
]
STEPS = st.one_of(
    st.binary(max_size=30),
    st.tuples(st.sampled_from(VERBS), st.sampled_from(ARGUMENTS)).map(lambda pair: f"{' '.join(pair)}\r\n".encode()),
    st.sampled_from(["connect", "data", "end", "lose", "wait"]),
)


@given(st.lists(STEPS, max_size=25), st.booleans())
def test_no_bytes_raise_and_without_a_login_nothing_changes(steps: list[bytes | str], is_logged_in: bool) -> None:
    client = Client(is_logged_in=is_logged_in)
    datas: list[ServedConnection] = []
    has_login = False
    for step in steps:
        if isinstance(step, bytes):
            has_login |= b"230 " in client.control.send(step)
        elif step == "connect" and client.control.serve_extra is not None:
            datas.append(client.data())
        elif step == "connect" and client.control.connecting is not None:
            datas.append(ServedConnection(client.control.connecting[2]))
        elif step == "wait":
            client.run(20)
        elif datas and step == "data":
            datas[-1].send(b"abc")
        elif datas and step in ("end", "lose"):
            (datas[-1].end if step == "end" else datas[-1].lose)()
    if not is_logged_in and not has_login:
        assert client.folder.files == Folder().files
        assert not datas
