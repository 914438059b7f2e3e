"""curl, and Python's own clients of HTTP and FTP, with a running MAx-4."""

import ftplib
import http.client
import io
import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from running_rig import RunningRig

from fieldrig.testing import free_port

pytestmark = pytest.mark.real

RIG = """
time: real
buses:
  lan: {{kind: tcp.server, listen: {{http: "127.0.0.1:{http}", ftp: "127.0.0.1:{ftp}"}}}}
devices:
  max4:
    kind: max4
    links: {{tcp: lan}}
    drives: {{belt: {{ring_address: 1, simulated: true}}}}
    ftp: {{user_name: service, password: pacdrive}}
"""
LONG = bytes(range(256)) * 4000


class Services:
    def __init__(self, rig: RunningRig, ports: dict[str, int]) -> None:
        self.rig, self.http_port, self.ftp_port = rig, ports["http"], ports["ftp"]

    def page(self, path: str) -> tuple[int, bytes]:
        client = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=60)
        client.request("GET", path)
        answer = client.getresponse()
        content = answer.read()
        client.close()
        return answer.status, content

    def ftp(self) -> ftplib.FTP:
        client = ftplib.FTP(timeout=60)
        client.connect("127.0.0.1", self.ftp_port)
        client.login("service", "pacdrive")
        return client

    def curl(self, *arguments: str | Path) -> bytes:
        curl = shutil.which("curl")
        if curl is None:
            pytest.skip("curl is not installed: apt-get install curl")
        done = subprocess.run([curl, "-sS", "-m", "60", *arguments], capture_output=True, timeout=100, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def services(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Services]:
    ports = {"http": free_port(), "ftp": free_port()}
    file = tmp_path_factory.mktemp("services") / "rig.yaml"
    file.write_text(RIG.format(**ports))
    with RunningRig(file, None) as running:
        running.until_ready()
        yield Services(running, ports)


@pytest.mark.manual("PD-282")
def test_a_page_put_by_ftp_is_served(services: Services) -> None:
    client = services.ftp()
    client.storbinary("STOR mine.htm", io.BytesIO(b'<p><pac value="belt.AxisState"></p>'))
    client.quit()
    status, content = services.page("/mine.htm")
    assert status == 200
    assert content.startswith(b"<p>")
    assert content.removeprefix(b"<p>").removesuffix(b"</p>").isdigit()


def test_ftplib_does_everything(services: Services) -> None:
    client = services.ftp()
    assert client.pwd() == "/"
    client.storbinary("STOR LONG.TXT", io.BytesIO(LONG))
    assert client.size("LONG.TXT") == len(LONG)
    arrived = bytearray()
    client.retrbinary("RETR long.txt", arrived.extend)
    assert arrived == LONG
    assert "LONG.TXT" in client.nlst()
    lines: list[str] = []
    client.dir(lines.append)
    assert any(line.endswith(" INDEX.HTM") for line in lines)
    client.rename("LONG.TXT", "SHORT.TXT")
    client.delete("SHORT.TXT")
    assert "SHORT.TXT" not in client.nlst()
    for command in ("CWD etc", "MKD x", "DELE ../x"):
        with pytest.raises(ftplib.error_perm, match="550"):
            client.sendcmd(command)
    with pytest.raises(ftplib.error_perm, match="552"):
        client.storbinary("STOR BIG.TXT", io.BytesIO(bytes(5_000_000)))
    client.close()


@pytest.mark.parametrize("is_passive", [True, False])
def test_ftplib_resumes_a_transfer_in_both_modes(services: Services, is_passive: bool) -> None:
    client = services.ftp()
    client.set_pasv(is_passive)
    client.storbinary("STOR HALF.TXT", io.BytesIO(LONG[:1000]))
    client.storbinary("APPE HALF.TXT", io.BytesIO(LONG[1000:2000]))
    client.storbinary("STOR HALF.TXT", io.BytesIO(LONG[2000:]), rest=2000)
    arrived = bytearray(LONG[:500])
    client.retrbinary("RETR HALF.TXT", arrived.extend, rest=500)
    assert arrived == LONG
    ((name, facts),) = [entry for entry in client.mlsd() if entry[0] == "HALF.TXT"]
    assert (name, facts["size"]) == ("HALF.TXT", str(len(LONG)))
    assert client.voidcmd("MDTM HALF.TXT") == "213 20030101000000"
    client.delete("HALF.TXT")
    client.quit()


@pytest.mark.parametrize("mode", [["--ftp-port", "-"], ["--ftp-port", "-", "--disable-eprt"], ["--ftp-pasv"]])
def test_curl_resumes_a_transfer_in_every_mode(services: Services, tmp_path: Path, mode: list[str]) -> None:
    url, login = f"ftp://127.0.0.1:{services.ftp_port}/RESUMED.TXT", ("--user", "service:pacdrive")
    page = tmp_path / "RESUMED.TXT"
    page.write_bytes(LONG[:3000])
    services.curl(*login, *mode, "-T", page, url)
    page.write_bytes(LONG)
    services.curl(*login, *mode, "-C", "-", "-T", page, url)
    page.write_bytes(LONG[:100])
    services.curl(*login, *mode, "-C", "-", "-o", page, url)
    assert page.read_bytes() == LONG
    services.curl(*login, "-Q", "DELE RESUMED.TXT", f"ftp://127.0.0.1:{services.ftp_port}/")


DIALOGUE = """
user service pacdrive
{more}
pwd
cd /
dir
ls
ascii
put {folder}/BY.HTM BY.HTM
binary
get BY.HTM {folder}/BACK.HTM
mdelete BY.H*
ls
bye
"""


@pytest.mark.parametrize(("more", "command"), [("", "EPRT"), ("epsv4", "PORT")])
def test_the_old_command_line_client_works_in_active_mode(
    services: Services, tmp_path: Path, more: str, command: str
) -> None:
    """tnftp is the `ftp` of the BSDs, from which that of Windows comes; `epsv4` has it use PORT instead of EPRT."""
    tnftp = shutil.which("tnftp")
    if tnftp is None:
        pytest.skip("tnftp is not installed: apt-get install tnftp")
    (tmp_path / "BY.HTM").write_bytes(b"line\n")
    done = subprocess.run(
        [tnftp, "-A", "-d", "-n", "-i", "-v", "127.0.0.1", str(services.ftp_port)],
        input=DIALOGUE.format(folder=tmp_path, more=more).encode(), capture_output=True, timeout=100, check=False,
    )  # fmt: skip
    said = done.stdout.decode()
    replies = [line[:3] for line in said.splitlines() if line[:3].isdigit() and line[3:4] == " "]
    assert (tmp_path / "BACK.HTM").read_bytes() in (b"line\n", b"line\r\n"), said
    assert not [code for code in replies if code[0] in "45" and code != "502"], said
    assert "DELE BY.HTM" in said
    assert f"---> {command}" in said


def test_ftplib_with_a_wrong_password_is_refused(services: Services) -> None:
    client = ftplib.FTP(timeout=60)
    client.connect("127.0.0.1", services.ftp_port)
    with pytest.raises(ftplib.error_perm, match="530"):
        client.login("service", "wrong")
    client.close()


def test_curl_fetches_puts_and_lists(services: Services, tmp_path: Path) -> None:
    base = f"ftp://127.0.0.1:{services.ftp_port}/"
    page = tmp_path / "CURL.HTM"
    page.write_bytes(b"by curl")
    login = ("--user", "service:pacdrive")
    services.curl(*login, "-T", page, base)
    assert services.curl(*login, base + "CURL.HTM") == b"by curl"
    assert services.curl(*login, "--disable-epsv", base + "CURL.HTM") == b"by curl"
    assert b"CURL.HTM" in services.curl(*login, "--list-only", base)
    assert services.curl(f"http://127.0.0.1:{services.http_port}/curl.htm") == b"by curl"
    values = services.curl(f"http://127.0.0.1:{services.http_port}/values?of=belt.Position")
    assert json.loads(values) == {"belt.Position": 0.0}


def test_curl_asks_several_times_on_one_connection(services: Services) -> None:
    url = f"http://127.0.0.1:{services.http_port}/AXES.HTM"
    assert services.curl(url, url, url).count(b">belt</td>") == 3
    head = services.curl("-I", url)
    assert head.startswith(b"HTTP/1.1 200 OK\r\n")


@pytest.mark.manual("PD-283")
def test_each_connection_is_in_the_message_logger(services: Services) -> None:
    services.page("/")
    assert "8013" in str(services.rig.value("max4/log"))
