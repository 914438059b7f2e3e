"""The prose linter: `python -m tests.driver.prose [FILE...]`, and `make check` for the files that pyproject.toml names.

It reads Markdown without code, comments in YAML, and comments, docstrings and messages in Python.  proselint knows the
common mistakes of English; `words.toml` lists the words that this project replaces.  Everything else in the
file is blanked out first, character by character, so that every finding has its line.
"""

import io
import re
import sys
import token
import tokenize
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from proselint.checks import __register__ as proselint_checks
from proselint.config import Config
from proselint.registry import CheckRegistry
from proselint.tools import LintFile

ROOT = Path(__file__).parents[2]
WORDS = Path(__file__).parent / "words.toml"
CLEAN = ROOT / "build" / "prose-clean"

CheckRegistry().register_many(proselint_checks)

# proselint takes the first name that matches, so deeper names come first.
PROSELINT: Config = {
    "max_errors": 1000,
    "checks": {
        "misc.phrasal_adjectives": False,
        "misc.scare_quotes": False,
        "misc.capitalization": False,
        "misc.preferred_forms": False,  # it takes the operator NE of Instruction List for a French word
        "industrial_language.jargon": False,
        "spelling.consistency": False,
        "cliches": False,
        "terms": False,
        "social_awareness": False,
        "annotations": True,
        "archaism": True,
        "hedging": True,
        "malapropisms": True,
        "misc": True,
        "mixed_metaphors": True,
        "mondegreens": True,
        "needless_variants": True,
        "nonwords": True,
        "oxymorons": True,
        "psychology": True,
        "redundancy": True,
        "spelling": True,
        "uncomparables": True,
    },
}

FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
CODE_IN_MARKDOWN = re.compile(r"`[^`\n]+`|\]\([^)\s]+\)|https?://\S+|<!--.*?-->", re.DOTALL)
COMMENT_IN_YAML = re.compile(r"(?:^|\s)#(.*)$", re.MULTILINE)
CODE_IN_TEXT = re.compile(r"`[^`]+`|\{[^{}]*\}|\\.|^[rbfuRBFU]+(?=[\"'])", re.DOTALL)
QUOTES = re.compile(r"\"\"\"|'''|[\"']")
OUTSIDE = re.compile(r"\S(?:[^\n]*\S)?")
NUMBER = re.compile(r"\b[0-9A-F]*\d[0-9A-Fa-f]*\b")
STRINGS = {token.STRING, getattr(token, "FSTRING_MIDDLE", token.STRING)}


class Finding(NamedTuple):
    line: int
    text: str
    instead: str


class Rule(NamedTuple):
    pattern: re.Pattern[str]
    instead: str


def main(arguments: Sequence[str]) -> int:
    rules = rules_of(tomllib.loads(WORDS.read_text(encoding="utf-8")))
    paths = [Path(argument).resolve() for argument in arguments] or list(checked())
    clean = known_as_clean()
    states = {path: state_of(path) for path in paths}
    unknown = [path for path in paths if states[path] not in clean]
    wrong: set[Path] = set()
    with ProcessPoolExecutor() as pool:
        for path, found in zip(unknown, pool.map(partial(findings_in, rules), unknown, chunksize=8), strict=True):
            name = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
            for finding in found:
                wrong.add(path)
                sys.stdout.write(f'{name}:{finding.line}: "{finding.text}": {finding.instead}\n')
    if not arguments:
        remember_as_clean(states[path] for path in paths if path not in wrong)
    return 1 if wrong else 0


def state_of(path: Path) -> str:
    """Return a digest of the kind of file, of its content, and of all that decides what is found in it."""
    parts = (path.suffix.encode(), *deciding(), path.read_bytes())
    return sha256(b"".join(sha256(part).digest() for part in parts)).hexdigest()


@cache
def deciding() -> tuple[bytes, ...]:
    """Return what decides on the findings in any file."""
    versions = f"{version('proselint')} {sys.version_info[:2]}".encode()
    return versions, Path(__file__).read_bytes(), WORDS.read_bytes()


def known_as_clean() -> set[str]:
    """Return the states in which the last run over all files found nothing: most files are as they were then."""
    try:
        return set(CLEAN.read_text(encoding="ascii").split())
    except (OSError, UnicodeDecodeError):
        return set()


def remember_as_clean(states: Iterable[str]) -> None:
    CLEAN.parent.mkdir(parents=True, exist_ok=True)
    CLEAN.write_text("".join(f"{state}\n" for state in sorted(states)), encoding="ascii")


def findings_in(rules: Sequence[Rule], path: Path) -> list[Finding]:
    """Return the findings in a file."""
    return findings(path.suffix, path.read_text(encoding="utf-8"), rules)


def checked() -> Iterator[Path]:
    """Yield the files that `[tool.fieldrig.prose]` of pyproject.toml names, without those that `except` names."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    table: Mapping[str, list[str]] = project["tool"]["fieldrig"]["prose"]
    excepted = {ROOT / name for name in table["except"]}
    for pattern in table["files"]:
        files = (path for path in ROOT.glob(pattern) if path.is_file() and "node_modules" not in path.parts)
        found = sorted(path for path in files if path not in excepted)
        if not found:
            raise SystemExit(f"pyproject.toml: tool.fieldrig.prose.files: no file matches {pattern!r}")
        yield from found


def rules_of(tables: Mapping[str, Mapping[str, str]]) -> list[Rule]:
    def compiled(pattern: str, flags: int, instead: str) -> Rule:
        across_lines = pattern.replace(" ", r"[\s#]+")
        return Rule(re.compile(across_lines, flags), f"write: {instead}")

    return [
        *(compiled(rf"\b(?:{key})(?!\w)", re.IGNORECASE, text) for key, text in tables["words"].items()),
        *(compiled(rf"(?:(?<=[.;]\s)|(?<=\n\n))(?:{key})", 0, text) for key, text in tables["sentences"].items()),
        *(compiled(rf"\"\"\"(?:{key})", 0, text) for key, text in tables["openings"].items()),
    ]


def findings(suffix: str, source: str, rules: Sequence[Rule]) -> list[Finding]:
    """The findings in the prose of a file, sorted by line."""
    text = PROSE_OF[suffix](source)
    found = [
        Finding(line_of(text, match.start()), " ".join(match[0].strip('"').split()), rule.instead)
        for rule in rules
        for match in rule.pattern.finditer(text)
    ]
    linted = LintFile("text", NUMBER.sub(blank, QUOTES.sub(blank, text)) or "\n")
    for result in linted.lint(PROSELINT):
        start, end = result.check_result.span
        place = linted.content[start:end]
        start += len(place) - len(place.lstrip())
        # proselint puts a line break before the text.
        found.append(
            Finding(linted.content.count("\n", 0, start), " ".join(place.split()), result.check_result.message)
        )
    return sorted(set(found))


def line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def blank(match: re.Match[str]) -> str:
    """Filler with the length and the line breaks of the match, so that positions stay the same."""
    return re.sub(r"[^\n]", "~", match[0])


def prose_of_markdown(source: str) -> str:
    return CODE_IN_MARKDOWN.sub(blank, FENCED.sub(blank, source))


def prose_of_yaml(source: str) -> str:
    return only(source, [match.span(1) for match in COMMENT_IN_YAML.finditer(source)])


def prose_of_python(source: str) -> str:
    """Comments, and the strings that are text, which are those with a blank inside."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    spans = []
    for part in tokenize.generate_tokens(io.StringIO(source).readline):
        is_text = part.type in STRINGS and re.search(r"\S +\S", part.string) is not None
        if part.type == token.COMMENT or is_text:
            (first, left), (last, right) = part.start, part.end
            spans.append((starts[first - 1] + left, starts[last - 1] + right))
    text = only(source, spans)
    return CODE_IN_TEXT.sub(blank, text)


def only(source: str, spans: Sequence[tuple[int, int]]) -> str:
    """The source with one sign of filler instead of everything that a line has outside the spans."""
    parts, position = [], 0
    for start, end in (*spans, (len(source), len(source))):
        parts += [OUTSIDE.sub("~", source[position:start]), source[start:end]]
        position = end
    return "".join(parts)


PROSE_OF: Mapping[str, Any] = {".md": prose_of_markdown, ".yaml": prose_of_yaml, ".py": prose_of_python}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
