"""The report of a search: one page with everything that a person asks for, which fetches nothing."""

from html.parser import HTMLParser
from pathlib import Path

import pytest
from st_tests import LAMP_RIG
from typer.testing import CliRunner

from fieldrig_devices.search.command import app
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.html_report import strategies_of

pytestmark = [pytest.mark.lean, pytest.mark.long]

PROGRAM = """\
PROGRAM PLC_PRG
VAR
  switch AT %IX0.0 : BOOL;
  lamp AT %QX0.0 : BOOL;
  edge : R_TRIG;
  presses : INT;
END_VAR
edge(CLK := switch);
IF edge.Q THEN presses := presses + 1; END_IF
lamp := switch;
IF presses >= 2 THEN lamp := TRUE; END_IF
IF presses > 999 THEN presses := 0; END_IF
END_PROGRAM
"""
PLAN = """\
rig: rig.yaml
after: 500ms
for: 300ms
steps:
- {at: 50ms, press: {wires/switch.on: true}, hold: 50ms}
properties:
  the lamp <goes> out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
vary:
- {press: {wires/switch.on: true}, hold: 50ms}
"""


class Read(HTMLParser):
    """A page as a browser reads it: its text, what it would fetch, and what is open at its end."""

    VOID = ("meta", "img", "br", "link")

    def __init__(self, page: str) -> None:
        super().__init__()
        self.text, self.fetched, self.open, self.links = "", list[str](), list[str](), list[str]()
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        given = dict(attributes)
        self.fetched += [value or "" for name, value in attributes if name == "src"]
        self.fetched += [tag] if tag in ("script", "link", "iframe") else []
        self.links += [given["href"] or ""] if "href" in given else []

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("search")
    for name, text in (("rig.yaml", LAMP_RIG), ("lamp.st", PROGRAM), ("plan.yaml", PLAN)):
        (folder / name).write_text(text)
    options = ["--strategy", "swarm", "--most", "12", "--corpus", str(folder / "c.sqlite"), "--budget", "10min"]
    done = CliRunner().invoke(app, ["run", str(folder / "plan.yaml"), *options, "--html", str(folder / "report")])
    assert done.exit_code == 1, done.output
    return folder


def test_the_report_says_what_was_found_and_how(folder: Path) -> None:
    page = Read((folder / "report/index.html").read_text(encoding="utf-8"))
    assert page.open == []
    scenario = (folder / "report/finding-1.yaml").read_text(encoding="utf-8")
    for words in ("1. the lamp <goes> out", "was true for longer than 0.05 s", "in the 50 ms before:", scenario):
        assert words in page.text
    assert "fieldrig debug finding-1.yaml" in page.text
    assert "swarm: 12 runs" in page.text


def test_the_report_fetches_nothing_and_its_coverage_is_beside_it(folder: Path) -> None:
    page = Read((folder / "report/index.html").read_text(encoding="utf-8"))
    assert [one[:19] for one in page.fetched] == ["data:image/svg+xml;"]
    assert page.links == ["coverage.html"]
    coverage = Read((folder / "report/coverage.html").read_text(encoding="utf-8"))
    assert (coverage.open, coverage.fetched) == ([], [])
    missed = next(line for line in coverage.text.splitlines() if "presses > 999" in line)
    assert "?" in missed, "it has run, but not in all its branches"


def test_strategies_are_counted_by_their_runs(folder: Path) -> None:
    corpus = Corpus(folder / "c.sqlite")
    [swarm] = strategies_of(corpus)
    corpus.close()
    assert swarm.name == "swarm"
    assert 1 <= swarm.failing <= swarm.runs <= 12


def test_a_corpus_that_was_merged_has_the_same_report(folder: Path, tmp_path: Path) -> None:
    for number in (1, 2):
        part = ["--strategy", "swarm", "--most", "4", "--shard", f"{number}/2", "--corpus", str(tmp_path / f"{number}")]
        CliRunner().invoke(app, ["run", str(folder / "plan.yaml"), *part])
    assert CliRunner().invoke(app, ["merge", *(str(tmp_path / name) for name in ("all", "1", "2"))]).exit_code == 0
    done = CliRunner().invoke(app, ["report", str(tmp_path / "all"), str(tmp_path / "report")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "report" / "finding-1.yaml").exists()
    page = Read((tmp_path / "report/index.html").read_text(encoding="utf-8"))
    assert "1. the lamp <goes> out" in page.text
    assert page.links == ["coverage.html"]
    whole, parts = Corpus(tmp_path / "all"), [Corpus(tmp_path / name) for name in ("1", "2")]
    assert whole.coverage().total.count() == max(one.coverage().total.count() for one in parts)
    for corpus in (whole, *parts):
        corpus.close()
