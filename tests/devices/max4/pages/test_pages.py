"""Pages of the controller over a bus of the kind `tcp.server`, with this bench as its port."""

import json
import re
from functools import cache
from html import unescape
from html.parser import HTMLParser
from typing import Literal
from urllib.parse import urlencode

import pytest
from hypothesis import given
from hypothesis import strategies as st
from max4_page_bench import PageBench

from fieldrig_devices.max4.messages.diagnosis import MAX4, Sender
from fieldrig_devices.max4.pages.tags import expanded


@pytest.fixture(scope="module")
def bench() -> PageBench:
    return PageBench("belt", com1={"modem": "Phone"}, parameters={"Phone.Password": "s3cret"})


@pytest.mark.manual("PD-281")
def test_the_first_page_has_live_values(bench: PageBench) -> None:
    status, _, page = bench.page("/")
    assert status == "200"
    assert f">{bench.max4.firmware.disk.free}</span> bytes free" in page


def test_the_axes_are_a_table_with_their_states(bench: PageBench) -> None:
    _, _, page = bench.page("/AXES.HTM")
    state = int(bench.max4.firmware.tree.get("belt.AxisState"))
    assert state == 1
    assert '<td data-label="Axis">belt</td><td data-label="AxisState">1 waiting for ControllerEnable</td>' in page
    assert "<th>Position, incr</th>" in page


def test_the_logger_is_a_table_with_its_newest_entry_first(bench: PageBench) -> None:
    bench.max4.firmware.logger.insert(1, Sender("A", "B"), 8001, "<script>", "x & y")
    _, _, page = bench.page("/LOG.HTM")
    assert page.index("&lt;script&gt;") < page.index("Max4 boot")
    assert "x &amp; y" in page
    assert "<script>" not in page


def test_parameters_are_shown_without_the_password(bench: PageBench) -> None:
    _, _, page = bench.page("/PARAMS.HTM")
    assert '>Phone.InitString</td><td data-label="Value">AT&amp;F E0' in page
    assert '>Phone.Password</td><td data-label="Value">********</td>' in page
    assert '>Phone.State</td><td data-label="Value">0 being checked</td>' in page
    assert "s3cret" not in page


@pytest.mark.manual("PD-281")
def test_a_page_of_the_user_is_served_with_its_tags(bench: PageBench) -> None:
    bench.max4.firmware.disk.write(
        "\\MY.HTM", b'<p><PAC value="belt.AxisState"> <pac value="belt.Nothing"> <pac x="<b>">'
    )
    _, kind, page = bench.page("/my.htm")
    assert kind == "text/html; charset=utf-8"
    assert page.startswith(f"<p>{int(bench.max4.firmware.tree.get('belt.AxisState'))} [no parameter belt.Nothing] ")


def test_a_value_that_is_markup_is_shown_as_text(bench: PageBench) -> None:
    bench.max4.firmware.tree.set("Phone.UserName", "<b onload='x'>&")
    bench.max4.firmware.disk.write("\\TEXT.HTM", b'<p><pac value="Phone.UserName"></p>')
    for path in ("/text.htm", "/PARAMS.HTM"):
        _, _, page = bench.page(path)
        assert "&lt;b onload=&#x27;x&#x27;&gt;&amp;" in page
        assert "<b onload" not in page


def test_values_are_json(bench: PageBench) -> None:
    _, kind, page = bench.page("/values?of=belt.AxisState&of=Phone.Password&of=no.thing")
    assert kind == "application/json"
    state = int(bench.max4.firmware.tree.get("belt.AxisState"))
    assert json.loads(page) == {"belt.AxisState": state, "Phone.Password": "********", "no.thing": None}


NAMES = ("/", "/AXES.HTM", "/LOG.HTM", "/PARAMS.HTM")


@pytest.mark.parametrize("name", NAMES)
def test_a_page_is_small_fits_a_telephone_and_asks_no_other_host(bench: PageBench, name: str) -> None:
    _, _, page = bench.page(name)
    assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in page
    assert "://" not in page
    style, script = bench.page("/PAGES.CSS"), bench.page("/LIVE.JS")
    assert (style[1], script[1]) == ("text/css; charset=utf-8", "text/javascript; charset=utf-8")
    assert len(page.partition("<table")[0]) + len(style[2]) + len(script[2]) < 5000
    assert "://" not in style[2] + script[2]


@pytest.mark.parametrize("name", NAMES)
def test_a_page_is_kept_up_to_date_by_its_tags(bench: PageBench, name: str) -> None:
    """The script asks for each tag with live="yes", and puts the answer in its place."""
    _, _, page = bench.page(name)
    assert 'http-equiv="refresh"' in page.partition("<noscript>")[2].partition("</noscript>")[0]
    assert page.count('http-equiv="refresh"') == 1, "without a script only"
    tags = [unescape(text) for text in re.findall(r'data-pac="([^"]*)"', page)]
    assert tags
    _, kind, answer = bench.page("/values?" + urlencode([("tag", tag) for tag in tags]))
    assert kind == "application/json"
    values = json.loads(answer)
    assert list(values) == tags
    for tag, html in values.items():
        shown = html.partition("</tr>")[0] if "table" in tag else html  # rows change, as each connection is an entry
        assert f">{shown}</" in page or "Timer1" in tag


def test_values_have_words_and_units(bench: PageBench) -> None:
    bench.max4.firmware.disk.write(
        "\\TEXT.HTM", b'<pac text="belt.AxisState">, <pac text="MAx-4.CycleLoad">, <pac text="x.y">'
    )
    load = bench.max4.firmware.tree.get("MAx-4.CycleLoad")
    assert bench.page("/text.htm")[2] == f"1 waiting for ControllerEnable, {load} %, [no parameter x.y]"


@pytest.mark.parametrize(("language", "of_controller"), [("en", "de"), ("de", "en"), ("en", "en")])
def test_messages_are_in_the_language_of_the_page(language: Literal["de", "en"], of_controller: str) -> None:
    bench = PageBench("belt", language=of_controller)
    bench.max4.firmware.report(1117, MAX4)
    text = {"de": "Lesefehler Geber-EEPROM", "en": "encoder EEPROM read error"}
    tags = f'<pac diagnosis="MAx-4" lang="{language}"> <pac table="log" rows="1" lang="{language}">'
    page = expanded(tags, bench.max4.firmware)
    assert page.count(text[language]) == 2
    assert text["de" if language == "en" else "en"] not in page


@pytest.mark.parametrize(
    ("language", "of_controller", "text"),
    [
        ("de", "en", "0 keine"),
        ("en", "de", "0 none"),
        ("", "de", "0 keine"),
        ("", "en", "0 none"),
        ("fr", "en", "0 none"),
    ],
)
def test_no_message_is_one_in_the_language_of_the_page(
    language: str, of_controller: Literal["de", "en"], text: str
) -> None:
    bench = PageBench("belt", language=of_controller)
    tags = f'<pac diagnosis="MAx-4" lang="{language}"><br><pac diagnosis="belt" lang="{language}">'
    assert expanded(tags, bench.max4.firmware) == f"{text}<br>{text}"


def test_an_error_is_visible_as_one() -> None:
    bench = PageBench("belt")
    _, _, page = bench.page("/")
    assert "<td>0 none" in re.sub("</?span[^>]*>", "", page)
    assert 'class="error"' not in page
    bench.max4.firmware.report(1117, MAX4)
    _, _, page = bench.page("/")
    assert '<span class="error">1117 MAX4/MAX4: encoder EEPROM read error</span>' in page
    assert page.count('<tr class="error">') == 1


@pytest.mark.parametrize(
    "path",
    ["/TEST.PAR", "/TEST.SCF", "/NO.HTM", "/%5CINDEX.HTM", "/../INDEX.HTM", "//INDEX.HTM", "/$SETTINGS", "/%00.HTM"],
)
def test_what_is_no_page_is_not_found(bench: PageBench, path: str) -> None:
    assert bench.page(path)[0] == "404"


@pytest.mark.manual("PD-283")
def test_a_connection_is_entry_8013_with_the_address(bench: PageBench) -> None:
    bench.page("/")
    assert any("8013" in line and "c0a80a07" in line for line in bench.max4.firmware.logger.lines())


class Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)


@cache
def belt() -> PageBench:
    return PageBench("belt")


@given(st.text(max_size=40), st.sampled_from(["value", "text", "diagnosis", "table", "of", "lang", 'live="yes" x']))
def test_a_tag_shows_nothing_but_text(value: str, name: str) -> None:
    bench = belt()
    quoted = value.replace('"', "").replace("<", "").replace(">", "")
    reader = Reader()
    reader.feed(expanded(f'<pac {name}="{quoted}">', bench.max4.firmware))
    assert set(reader.tags) <= {"table", "tr", "th", "td", "span", "div"}


def test_a_controller_without_power_accepts_no_connection() -> None:
    bench = PageBench("belt")
    number = bench.fault("max4", what="power_off")
    assert bench.page("/")[0] == "closed"
    bench.heal("max4", number).run(3000)
    assert bench.page("/")[0] == "200"
