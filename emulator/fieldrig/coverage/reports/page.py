"""Coverage as a page with the source, without anything from outside and without scripts."""

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Final

from fieldrig.coverage.reports.table import Column, columns_of, per_cent, said
from fieldrig.coverage.summary import Count, Coverage, Part, pous
from fieldrig.text.html_page import document
from fieldrig.text.source_text import decoded

_STYLE: Final = """
tr.file td { font-weight: 600; }
tr.pou td:first-child { padding-left: 2rem; }
pre span { display: block; padding-left: .5rem; border-left: 4px solid transparent; white-space: pre; }
pre b { display: inline-block; width: 4.5rem; color: var(--quiet); font-weight: 400; }
pre em { color: var(--partly); font-style: normal; }
.run { border-color: var(--run); }
.missed { border-color: var(--missed); background: light-dark(#ffebe9, #4b1113); }
.partly { border-color: var(--partly); background: light-dark(#fff8c5, #3b2e04); }
.legend { color: var(--quiet); }
@media (max-width: 40rem) { tr.pou td:first-child { padding-left: 1rem; } }
"""
_SIGNS: Final = {"run": "+", "missed": "!", "partly": "?", "": " "}
"""The signs for readers who see no colours."""


def page(coverage: Coverage) -> bytes:
    """Return the page."""
    return document(f"Coverage {per_cent(coverage.total.count())} %", _STYLE, _lines(coverage))


def _lines(coverage: Coverage) -> Iterator[str]:
    files, total = coverage.files(), coverage.total
    yield "<div class='wide'><table>"
    columns = [*columns_of(total)]
    titles = "".join(f"<th>{column.title}</th>" for column in columns)
    yield f"<tr><th>file, POU</th>{titles}<th>%</th><th></th></tr>"
    for number, file in enumerate(files):
        yield _row(f'<a href="#f{number}">{escape(file.name)}</a>', file, "file", columns)
        yield from (_row(escape(pou.name), pou, "pou", columns) for pou in pous(file))
    yield f"{_row('total', total, 'file', columns)}\n</table></div>"
    yield '<p class="legend">+ has run; ! has not run; ? has run, but not in all its branches</p>'
    for number, file in enumerate(files):
        yield f'<details open id="f{number}"><summary>{escape(file.name)}</summary>\n<pre>'
        yield "".join(_source(file))
        yield "</pre></details>"


def _row(name: str, part: Part, kind: str, columns: Sequence[Column]) -> str:
    counts = "".join(f"<td>{_count(column.counted(part))}</td>" for column in columns)
    share = part.count()
    bar = f'<span class="bar"><i style="width: {share.per_cent:.1f}%"></i></span>'
    return f'<tr class="{kind}"><td>{name}</td>{counts}<td>{per_cent(share)}</td><td>{bar}</td></tr>'


def _count(count: Count) -> str:
    return f"{count.run}/{count.all}" if count.all else ""


def _source(file: Part) -> Iterator[str]:
    lines, missed = file.lines(), set(file.missed_lines())
    open_branches: dict[int, list[str]] = {}
    for place in file.missed_branches():
        open_branches.setdefault(place.line, []).append(f"not taken: {place.what}")
    for place in file.missed_details():
        open_branches.setdefault(place.line, []).append(f"never: {said(place)}")
    for number, text in enumerate(_text(file.name).splitlines(), 1):
        is_partly = number in open_branches or (number in missed and lines[number])
        kind = "partly" if is_partly else "missed" if number in missed else "run" if number in lines else ""
        note = f"  <em>{escape(', '.join(open_branches[number]))}</em>" if number in open_branches else ""
        yield f'<span class="{kind}"><b>{number:>5} {_SIGNS[kind]}</b>{escape(text)}{note}</span>'


def _text(file: str) -> str:
    """Return the source; it may have gone since the tests ran."""
    try:
        return decoded(Path(file).read_bytes())
    except (OSError, ValueError):
        return ""
