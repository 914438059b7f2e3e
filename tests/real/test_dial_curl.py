"""curl fetches a page of a controller through `fieldrig dial`: by a local port, and by its proxy."""

import shutil
import subprocess

import pytest
from dial_peer import PAGE, PtyPeer
from dialled import LOGIN, dialled

from fieldrig.testing import free_port

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not installed: apt-get install curl"),
]


def test_curl_fetches_a_page_by_a_local_port_and_by_the_proxy() -> None:
    local, proxy = free_port(), free_port()
    ways = ("--forward", f"{local}:80", "--socks", str(proxy))
    with PtyPeer() as peer, dialled(peer.path, *LOGIN, *ways) as run:
        run.until("Ctrl-C hangs up.")
        for arguments in (
            [f"http://127.0.0.1:{local}/"],
            ["--socks5", f"127.0.0.1:{proxy}", "http://190.200.100.100/"],
        ):
            done = subprocess.run(["curl", "-s", "-m", "60", *arguments], capture_output=True, check=True)
            assert done.stdout == PAGE.partition(b"\r\n\r\n")[2]
