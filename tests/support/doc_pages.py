"""The pages of the documentation as data: their fenced blocks, tables, headings and links.

The first word after a fence names the language, the second says what a test does with the block:

```sh            run it; every command must succeed
```sh lab        the same while the lab is up; further words name programs that it needs
```sh with PROGRAM   run it if the programs are there
```console       a transcript: what stands after `$ ` is run, and each line below it must appear in the output, where
                 ... stands for anything; `console lab` with the lab up, `console fails` where the commands must fail
```python test   a module for pytest
```yaml rig      `fieldrig check` must be content with it
```LANGUAGE file NAME, or a NAME after test and rig: saved under this name for the blocks below
```LANGUAGE elsewhere   not run here; text and the like aren't either
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
"""In the order of their folders."""

INDEX = "README.md"
"""The name of the index of a folder, which GitHub shows below its files."""

FENCE = re.compile(r"^```(.*)$")
HEADING = re.compile(r"^(#+) (.+)$")
LINK = re.compile(r"\]\(([^)\s]+)\)")


@dataclass(frozen=True, slots=True)
class Block:
    page: Path
    line: int
    info: tuple[str, ...]
    text: str

    @property
    def place(self) -> str:
        return f"{place_of(self.page)}:{self.line}"


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a table, with the heading above it and the table's own first row."""

    page: Path
    heading: str
    columns: tuple[str, ...]
    cells: tuple[str, ...]


def page_named(name: str) -> Path:
    """Return the page of docs with this file name, which only the indexes of folders share."""
    [page] = [page for page in PAGES if page.name == name and name != INDEX]
    return page


def place_of(page: Path) -> str:
    """Return where a page is in the project, as tests name it."""
    return str(page.relative_to(ROOT))


def blocks(page: Path) -> Iterator[Block]:
    opened: Block | None = None
    body: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        fence = FENCE.match(line)
        if fence is None:
            body.append(line)
        elif opened is None:
            opened, body = Block(page, number, tuple(fence[1].split()), ""), []
        else:
            yield Block(page, opened.line, opened.info, "\n".join(body) + "\n")
            opened = None
    assert opened is None, f"{page}: a fence is not closed"


def prose(page: Path) -> str:
    """The page without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


def headings(page: Path) -> list[str]:
    return [match[2] for line in prose(page).splitlines() if (match := HEADING.match(line))]


def anchor(heading: str) -> str:
    """Return the anchor of a heading as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def links(page: Path) -> list[str]:
    return links_in(prose(page))


def links_in(text: str) -> list[str]:
    return LINK.findall(text)


def rows(page: Path) -> Iterator[Row]:
    heading, columns = "", None
    for line in prose(page).splitlines():
        if match := HEADING.match(line):
            heading = match[2]
        if not line.startswith("|"):
            columns = None
            continue
        cells = tuple(cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1])
        if columns is None:
            columns = cells
        elif not set("".join(cells)) <= set("-:"):
            yield Row(page, heading, columns, cells)


def code_in(text: str) -> list[str]:
    """Return the texts in backticks."""
    return re.findall(r"`([^`]+)`", text)
