"""The site of the docs: every page is there and reached, every link and anchor leads somewhere, and nothing is fetched.

Sphinx takes some 14 s of CPU time for the site, so it is built once for all tests of this file.
"""

import json
import re
from collections.abc import Iterator
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from doc_pages import PAGES, place_of
from lxml import html
from tests.site import pages
from tests.site.pages import OUTSIDE, places
from tests.site.render import render

from fieldrig.config import kinds

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]

FETCHED = (
    "//script/@src | //img/@src | //iframe/@src | //source/@srcset | //link[contains('stylesheet icon', @rel)]/@href"
)
"""The attributes that let a browser ask for a file when it shows a page; a person follows links."""
IN_STYLE = re.compile(r"(?:url\(\s*|@import\s+)[\"']?(?!data:)([^\"')\s]+)")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    pages.write(folder / "source")
    assert render(folder / "source", folder / "site") == 0
    return folder / "site"


@cache
def tree(page: Path) -> html.HtmlElement:
    return html.fromstring(page.read_bytes())


def links_of(page: Path) -> Iterator[tuple[Path, str]]:
    """Yield the file and the anchor of each link to the site itself."""
    for link in map(str, tree(page).xpath("//a/@href")):
        if not re.match(r"[a-z]+:", link):
            name, _, part = link.partition("#")
            yield (page.parent / name).resolve() if name else page, part


@cache
def anchors(page: Path) -> frozenset[str]:
    return frozenset(map(str, tree(page).xpath("//@id")))


def test_every_page_of_the_docs_is_reached_from_the_index(site: Path) -> None:
    reached, found = set[Path](), {site / "index.html"}
    while found:
        reached |= found
        found = {target for page in found for target, _ in links_of(page) if target.suffix == ".html"} - reached
    expected = {site / place.with_suffix(".html") for place in places().values()}
    assert expected - reached == set()
    assert len(expected) == len([page for page in PAGES if place_of(page).startswith("docs/")]) + len(OUTSIDE)


def test_every_link_and_anchor_leads_somewhere(site: Path) -> None:
    dead = [
        f"{page.relative_to(site)}: {target}#{part}"
        for page in site.rglob("*.html")
        for target, part in links_of(page)
        if not target.exists() or (part and target.suffix == ".html" and part not in anchors(target))
    ]
    assert dead == []


def test_nothing_is_fetched_but_files_of_the_site(site: Path) -> None:
    asked = {(page, str(name)) for page in site.rglob("*.html") for name in tree(page).xpath(FETCHED)}
    asked |= {(file, name) for file in site.rglob("*.css") for name in IN_STYLE.findall(file.read_text("utf-8"))}
    assert len(asked) > len(PAGES)
    assert [f"{file}: {name}" for file, name in asked if not (file.parent / name.partition("?")[0]).is_file()] == []


def test_the_search_knows_every_page_and_finds_a_word(site: Path) -> None:
    index = json.loads((site / "searchindex.js").read_text("utf-8").removeprefix("Search.setIndex(").removesuffix(")"))
    assert set(index["docnames"]) >= {str(place.with_suffix("")) for place in places().values()}
    found = index["terms"]["unwind"]
    names = {index["docnames"][number] for number in ([found] if isinstance(found, int) else found)}
    assert "devices/plants" in names


@pytest.mark.parametrize(
    ("page", "group"), [("buses", kinds.BUSES), ("devices", kinds.DEVICES), ("files", "fieldrig.schemas")]
)
def test_settings_of_every_installed_kind_are_there(site: Path, page: str, group: str) -> None:
    titles = tree(site / "reference" / f"settings-of-{page}.html").xpath("//h2//code/span/text()")
    assert sorted(map(str, titles)) == sorted(point.name for point in entry_points(group=group))


def test_a_setting_has_its_type_limits_and_default(site: Path) -> None:
    rows = tree(site / "reference" / "settings-of-devices.html").xpath(
        "//section[h2//span='canopen.node']//tr[td[1]//span='node_id' or td[1]//span='sdo_block_size']"
    )
    cells = [[str(cell.text_content()).strip() for cell in row.xpath("td")][:3] for row in rows]
    assert cells == [["node_id", "integer, 1 to 127", "needed"], ["sdo_block_size", "integer, 1 to 127", "127"]]


def test_a_link_that_leads_nowhere_fails_the_site(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "source"
    source.mkdir()
    (source / "index.md").write_text("# Page\n\n[nothing](#no-such-part)\n", encoding="utf-8")
    assert render(source, tmp_path / "site") != 0
    assert "'myst' cross-reference target not found: 'no-such-part'" in capfd.readouterr().err
