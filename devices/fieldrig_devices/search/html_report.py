"""The report of a search as a page: findings with picture, reason and scenario, strategies, and the coverage page.

A folder that can be sent as it is.  `index.html` has the pictures inside, so that it can also be sent alone.
"""

import base64
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Final, NamedTuple

from fieldrig.coverage.reports.page import page as coverage_page
from fieldrig.coverage.reports.table import per_cent
from fieldrig.coverage.summary import Coverage
from fieldrig.points.values import counted
from fieldrig.system.whole_file import replace_file
from fieldrig.text.html_page import document
from fieldrig_devices.search.corpus import Corpus, Finding

INDEX: Final = "index.html"
COVERAGE: Final = "coverage.html"
_STYLE: Final = """
h2 { margin-top: 2.5rem; border-top: 1px solid var(--line); padding-top: 1rem; overflow-wrap: anywhere; }
img { width: 100%; min-width: 40rem; height: auto; border: 1px solid var(--line); }
.wrong { color: var(--missed); font-weight: 600; }
.quiet { color: var(--quiet); }
td.words { text-align: left; }
th.words { text-align: left; }
pre { padding: .5rem; }
ol.reason { padding-left: 1.2rem; list-style: none; }
ol.reason li { overflow-wrap: anywhere; }
"""


class Strategy(NamedTuple):
    """A strategy in the report."""

    name: str
    runs: int
    failing: int
    """The runs in which a property does not hold."""


def write_report(
    title: str, corpus: Corpus, files: Mapping[int, Path], told: Sequence[str], coverage: Coverage, folder: Path
) -> Path:
    """Write the report into a folder, and return its first page.

    `files` are the scenario files of the findings by number, with their pictures beside them; `told` is what strategies
    say of themselves.
    """
    folder.mkdir(parents=True, exist_ok=True)
    has_coverage = coverage.total.count().all > 0
    if has_coverage:
        replace_file(folder / COVERAGE, coverage_page(coverage))
    body = _body(corpus, files, told, coverage if has_coverage else None)
    replace_file(folder / INDEX, document(title, _STYLE, body))
    return folder / INDEX


def strategies_of(corpus: Corpus) -> list[Strategy]:
    """Return the strategies of the runs of a corpus, in the order of their first run."""
    counts: dict[str, tuple[int, int]] = {}
    for _, name, violations in corpus.all_runs():
        runs, failing = counts.get(name, (0, 0))
        counts[name] = runs + 1, failing + bool(violations)
    return [Strategy(name, *count) for name, count in counts.items()]


def _body(corpus: Corpus, files: Mapping[int, Path], told: Sequence[str], coverage: Coverage | None) -> Iterator[str]:
    findings, strategies = corpus.findings(), strategies_of(corpus)
    words, runs = (
        counted(len(findings), "finding") if findings else "nothing was found",
        sum(one.runs for one in strategies),
    )
    yield f'<p class="{"wrong" if findings else ""}">{words} in {runs} different runs</p>'
    if coverage is not None:
        yield f'<p><a href="{COVERAGE}">Coverage: {per_cent(coverage.total.count())} %</a> of the programs has run.</p>'
    yield from _strategies(strategies, told)
    for number, finding in enumerate(findings, 1):
        yield from _finding(number, finding, files.get(finding.number))


def _strategies(strategies: Sequence[Strategy], told: Sequence[str]) -> Iterator[str]:
    yield '<div class="wide"><table><tr><th>strategy</th><th>runs</th><th>with a violation</th></tr>'
    for one in strategies:
        yield f"<tr><td>{escape(one.name)}</td><td>{one.runs}</td><td>{one.failing}</td></tr>"
    yield "</table></div>"
    yield from (f'<p class="quiet">{escape(line)}</p>' for line in told)


def _finding(number: int, finding: Finding, file: Path | None) -> Iterator[str]:
    yield f'<section id="finding-{finding.number}"><h2>{number}. {escape(finding.property)}</h2>'
    yield f'<p class="wrong">at {finding.at_ns / 1e6:g} ms: {escape(finding.what)}</p>'
    if finding.world:
        yield f"<p>with {escape(', '.join(finding.world))}</p>"
    yield '<div class="wide"><table><tr><th>at</th><th class="words">what was done besides</th></tr>'
    for act in finding.acts:
        yield f'<tr><td>{act.at_ns / 1e6:g} ms</td><td class="words">{escape(str(act))}</td></tr>'
    yield "</table></div>"
    yield f'<ol class="reason">{"".join(f"<li>{escape(line)}</li>" for line in finding.reason[1:])}</ol>'
    if file is not None:
        yield from _repeated(finding, file)
    yield "</section>"


def _repeated(finding: Finding, file: Path) -> Iterator[str]:
    picture = base64.b64encode(file.with_suffix(".svg").read_bytes()).decode()
    about = f"the signals of {finding.property} over time"
    yield f'<div class="wide"><img src="data:image/svg+xml;base64,{picture}" alt="{escape(about)}"></div>'
    scenario = escape(file.read_text(encoding="utf-8"))
    yield f"<details><summary>{escape(file.name)}</summary><pre>{scenario}</pre></details>"
    yield f"<pre>fieldrig scenario run {escape(file.name)}\nfieldrig debug {escape(file.name)}</pre>"
