"""Changes that no test has to notice, and the file in which people say so, with their reasons.

Its lines are those of the report of `fieldrig iec mutate`, each with a reason behind `#`:

    conveyor.st:21  constant  `1` -> `2`  # the state 2 comes after it anyway

In another file, the lines say which changes are tried again, without reasons.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

from fieldrig.cli.common import reading
from fieldrig.errors import UsageError
from fieldrig_devices.iec.mutation.changes import Change

_LINE: Final = re.compile(r"(?P<what>.*`)(?:\s*\(no test runs it\))?\s*(?:#\s*(?P<reason>.*))?")
_PLACE: Final = re.compile(r"(?P<file>.*?):(?P<line>\d+) (?P<rest>.*)")


def line_of(change: Change) -> str:
    """Return the line about a change, as reports have it."""
    what = f"`{change.before}` -> `{change.after}`" if change.after else f"without `{change.before}`"
    return f"{Path(change.file).name}:{change.line}  {change.kind}  {what}"


def accepted(path: Path, changes: Iterable[Change]) -> Mapping[Change, str]:
    """Return those changes that a file names, with the reasons.

    UsageError, with the line, for one without a reason and for one that is no change of the program.
    """
    found: dict[Change, str] = {}
    for place, what, reason, named in _named(path, changes):
        if not reason:
            raise UsageError(f"{place}: {what} has no reason", "# and why no test has to notice it, behind the line")
        found.update(dict.fromkeys(named, reason))
    return found


def chosen(path: Path, changes: Iterable[Change]) -> Collection[Change]:
    """Return those changes that a file names.  UsageError, with the line, for one that is no change of the program."""
    return {change for *_, named in _named(path, changes) for change in named}


def _named(path: Path, changes: Iterable[Change]) -> Iterator[tuple[str, str, str, list[Change]]]:
    """Yield the place, the text, the reason and the changes of each line of a file."""
    with reading(path):
        text = path.read_text(encoding="utf-8")
    known: dict[str, list[Change]] = {}
    for change in changes:
        known.setdefault(_plain(line_of(change)), []).append(change)
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        match = _LINE.fullmatch(line.strip())
        what, reason = (_plain(match["what"]), match["reason"] or "") if match else (_plain(line), "")
        named = known.get(what)
        if named is None:
            raise UsageError(f"{path}:{number}: the program has no such change", _near(what, known))
        yield f"{path}:{number}", what, reason, named


def _plain(line: str) -> str:
    return " ".join(line.split())


def _near(what: str, known: Iterable[str]) -> str:
    """Return where the same change is now, if it is anywhere."""
    wanted = _PLACE.fullmatch(what)
    lines = [
        place["line"]
        for place in map(_PLACE.fullmatch, known)
        if place and wanted and (place["file"], place["rest"]) == (wanted["file"], wanted["rest"])
    ]
    return f"the same text is in line {' and '.join(lines)}" if lines else "expected a line of the report"
