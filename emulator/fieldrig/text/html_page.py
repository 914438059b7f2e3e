"""A page as one file: without scripts, and without anything that a browser would have to fetch."""

from collections.abc import Iterable, Iterator
from html import escape
from typing import Final

STYLE: Final = """
:root { color-scheme: light dark; --run: light-dark(#1a7f37, #3fb950);
  --missed: light-dark(#cf222e, #f85149); --partly: light-dark(#9a6700, #d29922);
  --line: light-dark(#d0d7de, #3d444d); --quiet: light-dark(#59636e, #9198a1); }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: right; padding: .2rem .6rem; border-bottom: 1px solid var(--line); }
th { white-space: nowrap; }
th:first-child, td:first-child { text-align: left; overflow-wrap: anywhere; min-width: 9rem; }
.bar { display: inline-block; width: 6rem; height: .6rem; background: var(--missed); vertical-align: middle; }
.bar i { display: block; height: 100%; background: var(--run); }
pre { font: 13px/1.45 ui-monospace, monospace; overflow-x: auto; border: 1px solid var(--line); }
summary { font-weight: 600; cursor: pointer; margin-top: 1.5rem; }
@media (max-width: 40rem) {
  body { margin: 1rem auto; }
  th, td { padding: .2rem .35rem; font-size: 13px; }
  .bar { width: 3rem; }
  pre { font-size: 11px; }
}
"""


def document(title: str, style: str, body: Iterable[str]) -> bytes:
    """Return a page with the lines of its body; `style` is added to `STYLE`."""
    return "".join(f"{line}\n" for line in _lines(title, style, body)).encode()


def _lines(title: str, style: str, body: Iterable[str]) -> Iterator[str]:
    yield '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<title>{escape(title)}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body>"
    yield f"<h1>{escape(title)}</h1>"
    yield from body
    yield "</body>\n</html>"
