"""Pages of the controller over a bus of the kind `tcp.server`, with this bench as its port."""

import json
from functools import cache
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st
from max4_page_bench import PageBench

from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.pages.tags import expanded


@pytest.fixture(scope="module")
def bench() -> PageBench:
    return PageBench("belt", com1={"modem": "Phone"}, parameters={"Phone.Password": "s3cret"})


@pytest.mark.manual("PD-281")
def test_the_first_page_has_live_values(bench: PageBench) -> None:
    status, _, page = bench.page("/")
    assert status == "200"
    assert "bytes free" in page
    assert f"{bench.max4.disk.free} bytes free" in page


def test_the_axes_are_a_table_with_their_states(bench: PageBench) -> None:
    _, _, page = bench.page("/AXES.HTM")
    state = int(bench.max4.tree.get("belt.AxisState"))
    assert f"<td>belt</td><td>{state}</td>" in page


def test_the_logger_is_a_table_with_its_newest_entry_first(bench: PageBench) -> None:
    bench.max4.logger.insert(1, Sender("A", "B"), 8001, "<script>", "x & y")
    _, _, page = bench.page("/LOG.HTM")
    assert page.index("&lt;script&gt;") < page.index("Max4-Boot")
    assert "x &amp; y" in page
    assert "<script>" not in page


def test_parameters_are_shown_without_the_password(bench: PageBench) -> None:
    _, _, page = bench.page("/PARAMS.HTM")
    assert "<td>Phone.InitString</td><td>AT&amp;F E0" in page
    assert "<td>Phone.Password</td><td>********</td>" in page
    assert "s3cret" not in page


@pytest.mark.manual("PD-281")
def test_a_page_of_the_user_is_served_with_its_tags(bench: PageBench) -> None:
    bench.max4.disk.write("\\MY.HTM", b'<p><PAC value="belt.AxisState"> <pac value="belt.Nothing"> <pac x="<b>">')
    _, kind, page = bench.page("/my.htm")
    assert kind == "text/html; charset=utf-8"
    assert page.startswith(f"<p>{int(bench.max4.tree.get('belt.AxisState'))} [no parameter belt.Nothing] ")


def test_a_value_that_is_markup_is_shown_as_text(bench: PageBench) -> None:
    bench.max4.tree.set("Phone.UserName", "<b onload='x'>&")
    bench.max4.disk.write("\\TEXT.HTM", b'<p><pac value="Phone.UserName"></p>')
    for path in ("/text.htm", "/PARAMS.HTM"):
        _, _, page = bench.page(path)
        assert "&lt;b onload=&#x27;x&#x27;&gt;&amp;" in page
        assert "<b onload" not in page


def test_values_are_json(bench: PageBench) -> None:
    _, kind, page = bench.page("/values?of=belt.AxisState&of=Phone.Password&of=no.thing")
    assert kind == "application/json"
    state = int(bench.max4.tree.get("belt.AxisState"))
    assert json.loads(page) == {"belt.AxisState": state, "Phone.Password": "********", "no.thing": None}


@pytest.mark.parametrize(
    "path",
    ["/TEST.PAR", "/TEST.SCF", "/NO.HTM", "/%5CINDEX.HTM", "/../INDEX.HTM", "//INDEX.HTM", "/$SETTINGS", "/%00.HTM"],
)
def test_what_is_no_page_is_not_found(bench: PageBench, path: str) -> None:
    assert bench.page(path)[0] == "404"


@pytest.mark.manual("PD-283")
def test_a_connection_is_entry_8013_with_the_address(bench: PageBench) -> None:
    bench.page("/")
    assert any("8013" in line and "c0a80a07" in line for line in bench.max4.logger.lines())


class Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)


@cache
def belt() -> PageBench:
    return PageBench("belt")


@given(st.text(max_size=40), st.sampled_from(["value", "table", "of", "rows"]))
def test_a_tag_shows_nothing_but_text(value: str, name: str) -> None:
    bench = belt()
    quoted = value.replace('"', "").replace("<", "").replace(">", "")
    reader = Reader()
    reader.feed(expanded(f'<pac {name}="{quoted}">', bench.max4))
    assert set(reader.tags) <= {"table", "tr", "th", "td"}


def test_a_controller_without_power_accepts_no_connection() -> None:
    bench = PageBench("belt")
    number = bench.fault("max4", what="power_off")
    assert bench.page("/")[0] == "closed"
    bench.heal("max4", number).run(3000)
    assert bench.page("/")[0] == "200"
