"""The page's process beside a rig: its address, its end, and that the rig runs on without it."""

import os
import signal
import socket
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest
from lamp_rig import KINDS, lamp_rig
from page_addresses import WITH_PAGE, addresses
from running_rig import RunningRig, is_running, until

from fieldrig.outside.page_seat import DEFAULT_PAGE
from fieldrig.system.exits import Exit
from fieldrig.testing import free_port

pytestmark = pytest.mark.system

REAL = lamp_rig()
VIRTUAL = lamp_rig(time="time: virtual", wires="wires.virtual")


@contextmanager
def rig_with_page(rig: str, *options: str) -> Iterator[RunningRig]:
    ui = f"ui.listen=127.0.0.1:{free_port()}"
    with RunningRig(rig, KINDS, "--set", ui, *options, environment=WITH_PAGE) as running:
        yield running.until_ready()


def asked(rig: RunningRig, path: str) -> bytes:
    """Return what the page answers, with the token of who operates."""
    place, _, token = addresses(rig)["operate"].partition("?token=")
    request = urllib.request.Request(f"{place}{path}", headers={"Authorization": f"Bearer {token}"})
    with urllib.request.urlopen(request, timeout=60) as answer:
        content: bytes = answer.read()
        return content


def page_of(rig: RunningRig) -> dict[str, Any]:
    page: dict[str, Any] = rig.status()["ui"]
    return page


@pytest.mark.long
@pytest.mark.parametrize("text", [REAL, VIRTUAL], ids=["real", "virtual"])
def test_a_page_that_is_killed_comes_back_at_its_address_and_the_rig_runs_on(text: str) -> None:
    with rig_with_page(text) as rig:
        before = rig.status()
        assert b"<!doctype html>" in asked(rig, "")
        os.kill(before["ui"]["pid"], signal.SIGKILL)
        until(lambda: page_of(rig)["restarts"] == 1)
        assert b"<!doctype html>" in asked(rig, "")  # with the same token, as a page that is open has it
        after = rig.status()
        assert after["processes"].keys() == before["processes"].keys()
        assert [process["pid"] for process in after["processes"].values()] == [
            process["pid"] for process in before["processes"].values()
        ]
        assert "ui died: killed by SIGKILL; the rig goes on" in rig.output()
        assert rig.end() == Exit.OK
        assert not is_running(after["ui"]["pid"])


@pytest.mark.long
def test_a_page_ends_with_a_rig_that_is_killed() -> None:
    with rig_with_page(VIRTUAL) as rig:
        pid = page_of(rig)["pid"]
        rig.end(signal.SIGKILL)
        until(lambda: not is_running(pid))


@pytest.mark.long
def test_status_shows_the_page_without_its_tokens() -> None:
    with rig_with_page(VIRTUAL) as rig:
        until(lambda: b'"state": "ready"' in asked(rig, "api/v1/status"))
        page = rig.json("status")["ui"]
        assert page["state"] == "ready"
        assert page["address"] == addresses(rig)["operate"].partition("?")[0]
        assert page["memory_mb"] > 0
        assert f"the page at {page['address']}" in rig.tool("status").stdout
        token = addresses(rig)["operate"].partition("token=")[2]
        assert token not in rig.tool("status", "--json").stdout


@pytest.mark.long
def test_a_rig_without_a_page_prints_no_address_and_listens_nowhere() -> None:
    with RunningRig(VIRTUAL, KINDS, environment=WITH_PAGE) as with_page:
        assert "page to operate" in with_page.until_ready().output()
        with RunningRig(VIRTUAL, KINDS, "--no-ui", environment=WITH_PAGE) as rig:
            assert "page to" not in rig.until_ready().output()
            assert "ui" not in rig.status()
        with RunningRig(VIRTUAL, KINDS, "--set", "ui=false", environment=WITH_PAGE) as rig:
            assert "page to" not in rig.until_ready().output()


@pytest.mark.long
def test_the_page_takes_a_free_port_if_its_usual_one_is_taken() -> None:
    host, _, port = DEFAULT_PAGE.partition(":")
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with suppress(OSError):  # another rig of this host has it, which serves as well
            other.bind((host, int(port)))
            other.listen()
        with RunningRig(VIRTUAL, KINDS, environment=WITH_PAGE) as rig:
            until(lambda: "page to operate" in rig.output())
            assert f"http://{DEFAULT_PAGE}/" not in rig.until_ready().output()


@pytest.mark.long
def test_an_address_of_the_rig_file_that_is_taken_refuses_the_start() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        place = f"127.0.0.1:{other.getsockname()[1]}"
        with RunningRig(VIRTUAL, KINDS, "--set", f"ui.listen={place}", environment=WITH_PAGE) as rig:
            assert rig.ended() == Exit.CANNOT_START
            assert f"the page cannot listen on {place}" in rig.output()


@pytest.mark.long
def test_beyond_loopback_the_page_needs_the_token_of_the_rig() -> None:
    wide = ("--set", f"ui.listen=0.0.0.0:{free_port()}")
    with RunningRig(VIRTUAL, KINDS, *wide, environment=WITH_PAGE) as rig:
        assert rig.ended() == Exit.CANNOT_START
        assert "can be reached from other machines" in rig.output()
    with RunningRig(VIRTUAL, KINDS, *wide, environment={**WITH_PAGE, "FIELDRIG_TOKEN": "secret"}) as rig:
        until(lambda: "ready in " in rig.output())  # this process has no token to ask it
        token = addresses(rig)["look"].partition("token=")[2]
        assert "secret" not in rig.output()
        assert rig.end() == Exit.OK
    with RunningRig(VIRTUAL, KINDS, *wide, environment={**WITH_PAGE, "FIELDRIG_TOKEN": "secret"}) as again:
        until(lambda: "ready in " in again.output())
        assert addresses(again)["look"].endswith(token)  # a page that is open finds it again
