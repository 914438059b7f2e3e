"""The shell of the page: both addresses, a server that dies, and what a person finds by keyboard."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgpack
import pytest
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, expect
from running_rig import until

LAB = Path(__file__).parents[3] / "configs" / "lab.yaml"

NOTE_STATES = """async () => {
    const { live } = await import('/static/live.js');
    window.states = [];
    live.on('state', (message) => states.push(message.state));
}"""
"""Notes the states of the connection, each of which may be over before a test looks."""

END_LATE = """async () => {
    const { live } = await import('/static/live.js');
    const endFirst = live.want('values', { points: ['tank/level'] });
    live.want('values', { points: ['tank/inflow'] });
    endFirst();
    window.heard = [];
    live.on('values', (frame) => heard.push(...Object.keys(frame.values)));
}"""
"""Ends what is wanted of a topic after something else of it is wanted, as Preact does it on a busy host."""

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def lab() -> Iterator[ServedRig]:
    """The lab in virtual time, at the speed of real time."""
    with ServedRig(LAB, None, "--set=time=virtual") as rig:
        yield rig


def test_a_page_connects_again_when_its_server_was_killed_and_the_rig_runs_on(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        state = page.locator("header").get_by_role("status")
        expect(state).to_have_text("ready")
        expect(page.get_by_role("heading", name="Scope")).to_be_visible()  # a module that fails has the page load again
        page.evaluate(NOTE_STATES)
        before = lab.status()
        os.kill(before["ui"]["pid"], signal.SIGKILL)
        until(lambda: page.evaluate("states.at(-1)") == "open")
        assert page.evaluate("states[0]") == "away"
        expect(state).to_have_text("ready")
        assert lab.status()["ui"]["restarts"] == before["ui"]["restarts"] + 1
        assert lab.status()["pid"] == before["pid"]
        assert lab.status()["now_ns"] > before["now_ns"]


def test_a_server_that_hangs_is_silent_until_it_goes_on(browser: Browser, lab: ServedRig) -> None:
    """Its connections stay, so the values of before were shown as the present ones, with `ready` above them."""
    with opened(browser, lab) as page:
        pill = page.locator("header .pill")
        expect(pill).to_have_text("ready")
        server = lab.status()["ui"]["pid"]
        os.kill(server, signal.SIGSTOP)
        try:
            expect(pill).to_have_text("page server silent: what is shown is old")
        finally:
            os.kill(server, signal.SIGCONT)
        expect(pill).to_have_text("ready")


def test_a_view_that_was_opened_while_the_server_was_away_is_filled_when_it_is_back(
    browser: Browser, lab: ServedRig
) -> None:
    with opened(browser, lab) as page:
        page.route("**/api/**", lambda route: route.abort())
        page.get_by_role("link", name="Values").click()
        devices = page.get_by_label("device", exact=True).locator("option")
        expect(page.get_by_role("heading", name="Values")).to_be_visible()
        expect(devices).to_have_count(0)
        page.unroute_all(behavior="wait")
        os.kill(lab.status()["ui"]["pid"], signal.SIGKILL)
        expect(devices).to_have_text(["tank", "io", "sensor", "drive"])


def test_what_is_drawn_no_longer_ends_nothing_of_what_is_drawn_in_its_place(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/faults") as page:
        expect(page.get_by_role("heading", name="New fault")).to_be_visible()
        page.evaluate(END_LATE)
        until(lambda: page.evaluate("heard") == ["tank/inflow"])


def test_an_address_of_a_part_that_the_rig_does_not_have_says_so_and_what_it_has(
    browser: Browser, lab: ServedRig
) -> None:
    with opened(browser, lab) as page:
        expect(page.locator("main article")).to_have_count(4)
        page.evaluate(NOTE_STATES)
        for path, words, instead in (
            ("device/tanc", "lab has no device tanc", "device/tank"),
            ("values/tanc", "lab has no device tanc", "values/tank"),
            ("programs/tanc", "lab has no device tanc", "programs/tank"),
            ("bus/can7", "lab has no bus can7", "bus/can0"),
            ("traffic/can7", "lab has no bus can7", "traffic/can0"),
            ("faults/can7", "lab has no device or bus can7", "faults/can0"),
        ):
            page.goto(f"{page.url.partition('#')[0]}#/{path}")
            expect(page.get_by_role("alert")).to_have_text(words)
            page.locator(f'main a[href="#/{instead}"]').click()
            expect(page.get_by_text(words)).to_have_count(0)
        assert page.evaluate("states") == []  # the connection was never lost


def test_the_token_leaves_the_address_and_a_reload_in_the_middle_needs_none(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, "look", path="/time") as page:
        expect(page.locator("main section").first).to_be_visible()
        assert "token" not in page.url
        page.reload()
        expect(page.locator("main section").first).to_be_visible()
        expect(page.locator("header .facts")).to_contain_text("looking only")
        assert page.url.endswith("#/time")


def test_no_request_leaves_the_machine_and_nothing_breaks_the_policy(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        own = urlsplit(page.url).netloc
        asked: list[str] = []
        said: list[str] = []
        missing: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.on("console", lambda message: said.append(message.text))
        page.on("response", lambda answer: missing.extend([answer.url] * (answer.status >= 400)))
        page.reload()
        for link in page.get_by_role("navigation", name="views").get_by_role("link").all():
            link.click()
            expect(page.locator("main section").first).to_be_visible()
        assert len(asked) > 5
        assert {urlsplit(url).netloc for url in asked if not url.startswith(("data:", "blob:"))} == {own}
        assert [text for text in said if "Security Policy" in text] == []
        assert missing == []


def test_the_first_step_by_keyboard_leads_past_the_head(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        expect(page.locator("header")).to_be_visible()
        page.keyboard.press("Tab")
        expect(page.get_by_role("link", name="to the content")).to_be_focused()
        page.keyboard.press("Enter")
        expect(page.locator("main")).to_be_focused()


def test_two_rigs_of_a_host_do_not_take_each_others_cookies(browser: Browser, lab: ServedRig) -> None:
    with ServedRig(LAB, None, "--set=time=virtual") as other, opened(browser, lab) as page:
        page.goto(other.addresses()["look"])
        expect(page.locator("header .facts")).to_contain_text("looking only")
        page.goto(lab.addresses()["operate"].partition("?")[0])  # its cookie is still there
        expect(page.locator("header .facts")).to_contain_text("operating")


def test_a_page_whose_rig_was_started_anew_asks_for_the_new_address(browser: Browser) -> None:
    with ServedRig(LAB, None, "--set=time=virtual") as rig, opened(browser, rig) as page:
        expect(page.locator("header").get_by_role("status")).to_have_text("ready")
        port = urlsplit(page.url).port
        rig.end()
        rig.process = rig.up("--set=time=virtual", f"--set=ui.listen=127.0.0.1:{port}")  # with other tokens
        expect(page.locator("header").get_by_role("status")).to_contain_text("this address is no longer good")


VALUES: list[Any] = [
    *(
        None,
        True,
        False,
        0,
        1,
        -1,
        31,
        -32,
        -33,
        127,
        128,
        -128,
        -129,
        255,
        256,
        65_535,
        65_536,
        -32_769,
        2**31,
        -(2**31) - 1,
    ),
    *(
        2**32,
        2**53 - 1,
        -(2**53) + 1,
        0.5,
        -1e300,
        float("inf"),
        "",
        "a",
        "é€𝄞",
        "x" * 31,
        "x" * 32,
        "x" * 300,
        "x" * 70_000,
    ),
    *([], [1] * 15, [1] * 16, [1] * 70_000, {}, {"a": {"b": [None]}}, {str(n): n for n in range(16)}),
]


def test_the_page_reads_and_writes_messagepack_as_its_library_does(browser: Browser, lab: ServedRig) -> None:
    read = """async (bytes) => {
        const { decode } = await import('/static/wire.js');
        return decode(Uint8Array.from(bytes).buffer);
    }"""
    written = """async (value) => {
        const { encode } = await import('/static/wire.js');
        return [...encode(value)];
    }"""
    with opened(browser, lab, "look") as page:
        for value in VALUES:
            assert page.evaluate(read, list(msgpack.packb(value))) == value
            assert msgpack.unpackb(bytes(page.evaluate(written, value))) == value
        assert page.evaluate(read, list(msgpack.packb(1.5, use_single_float=True))) == 1.5
