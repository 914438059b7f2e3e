"""The source of the site: the pages of the docs as Sphinx reads them, with what only the site needs.

On GitHub a folder shows its README.md, and links lead to any file of the project.  On the site an index is called
index.html, pages outside docs get a place in it, other files are copied beside the pages, and each index names its
pages for the menu at the side.
"""

import os
import re
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from doc_pages import INDEX, PAGES, ROOT, links_in
from tests.site import settings

DOCS: Final = ROOT / "docs"
OUTSIDE: Final = {
    "CONTRIBUTING.md": "developers/contributing.md",
    "CHANGELOG.md": "changelog.md",
    "THIRD-PARTY.md": "packages.md",
}
"""Pages outside docs, with their places on the site."""
SITE_INDEX: Final = "index.md"
FILES: Final = "files"
"""The folder of the source for files that are no pages."""

PART = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<=\]\()([^)\s#]+)(?=[)#])")
MENU = "\n```{{toctree}}\n:hidden:\n\n{names}\n```\n"


def places() -> dict[Path, Path]:
    """Return where each page is in the source of the site, relative to its top."""
    inside = [page for page in PAGES if page.is_relative_to(DOCS)]
    found = {page: _as_index(page.relative_to(DOCS)) for page in inside}
    return found | {ROOT / name: Path(place) for name, place in OUTSIDE.items()}


def write(source: Path) -> None:
    """Write the source of the site into an empty folder."""
    known, made = places(), settings.texts()
    for page, place in known.items():
        text = "".join(_with_site_links(page, place, known, source, part) for part in _parts(page))
        if place.name == SITE_INDEX:
            text += menu(text, made if place.parent.name == settings.FOLDER else ())
        (source / place).parent.mkdir(parents=True, exist_ok=True)
        (source / place).write_text(text, encoding="utf-8")
    for name, text in made.items():
        (source / settings.FOLDER / name).write_text(text, encoding="utf-8")


def menu(index: str, more: Iterable[str]) -> str:
    """Return the menu of an index, in order: the pages of its folder and the indexes below that its text links to."""
    own = [link for link in links_in(index) if re.fullmatch(rf"[\w-]+\.md|[\w-]+/{SITE_INDEX}", link)]
    return MENU.format(names="\n".join(dict.fromkeys(link.removesuffix(".md") for link in (*own, *more))))


def _as_index(place: Path) -> Path:
    return place.with_name(SITE_INDEX) if place.name == INDEX else place


def _parts(page: Path) -> Iterator[str]:
    yield from PART.split(page.read_text(encoding="utf-8"))


def _with_site_links(page: Path, place: Path, known: dict[Path, Path], source: Path, part: str) -> str:
    if PART.fullmatch(part):
        return part

    def link(found: re.Match[str]) -> str:
        if ":" in found[1]:  # to the outside
            return found[1]
        target = Path(os.path.normpath(page.parent / found[1]))
        return os.path.relpath(known.get(target) or _copied(target, source), place.parent)

    return LINK.sub(link, part)


def _copied(file: Path, source: Path) -> Path:
    """Copy a file of the project into the source, and return its place there."""
    place = file.relative_to(DOCS) if file.is_relative_to(DOCS) else FILES / file.relative_to(ROOT)
    (source / place).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(file, source / place)
    return place
