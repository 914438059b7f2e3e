"""Code under conditions of the compiler: `{IF defined (NAME)} ... {ELSIF ...} ... {ELSE} ... {END_IF}`.

Source: the public description of CODESYS V3 and TwinCAT 3.  `{define NAME 'text'}` and `{undefine NAME}` are valid from
there to the end of the object.  What is not compiled becomes blanks, so that all other code keeps its place.
Deviation: conditions about POUs, types, variables and attributes are not evaluated; all their branches are compiled.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake

IS_USED: Final = re.compile(r"\{\s*(?:IF|ELSIF|ELSE|END_IF|define|undefine)\b", re.IGNORECASE)
_BORDER: Final = re.compile(r"\(\*|//|/\*|'|\"|\{")
_WORD: Final = re.compile(r"\s*([A-Za-z_]\w*)\s*(.*)", re.DOTALL)
_DEFINE: Final = re.compile(r"([A-Za-z_]\w*)\s*(?:'((?:\$.|[^'$])*)'|(\S.*))?", re.DOTALL)
_TOKEN: Final = re.compile(r"\s*([A-Za-z_]\w*|'(?:\$.|[^'$])*'|[(),:]|<=|>=|<>|[=<>]|-?\d[\w.]*)")
_KNOWN: Final = {"islittleendian": True, "isfpusupported": True, "issimulationmode": False}
"""Facts of the target that a condition may ask for."""
_OF_PROJECTS: Final = frozenset({"hasattribute", "hastype", "hasconstantvalue"})
_EXPECTED: Final = "defined (NAME) or hasvalue (NAME, 'text'), also with NOT, AND, OR"
_MOST_LEVELS: Final = 100


@dataclass(slots=True)
class _Level:
    """One {IF} that is open."""

    offset: int
    is_around_active: bool
    was_taken: bool
    """True once a branch was compiled."""
    is_active: bool
    is_unknown: bool
    """True if a condition is not evaluated; all branches behind it are compiled then."""
    is_last: bool = False
    """True behind {ELSE}."""


@dataclass(slots=True)
class Resolved:
    """A text without the code that is not compiled."""

    text: str
    mistakes: list[tuple[int, Mistake]] = field(default_factory=list)
    """The mistakes, each with its offset; their lines and columns are not set."""


def resolved(text: str, *, nests_comments: bool) -> Resolved:
    """Return a text with blanks for what is not compiled."""
    return _Reader(text, nests_comments).run()


class _Reader:
    def __init__(self, text: str, nests_comments: bool) -> None:
        self._text, self._nests = text, nests_comments
        self._defines: dict[str, str] = {}
        self._levels: list[_Level] = []
        self._made = Resolved("")

    def run(self) -> Resolved:
        parts, done = list[str](), 0
        for start, end in self._pragmas():
            part = self._text[done:start]
            parts.append(part if self._is_active else _blank(part))
            word = _WORD.fullmatch(self._text, start + 1, end - 1)
            is_ours = word is not None and self._obey(word[1].casefold(), word[2].strip(), start)
            pragma = self._text[start:end]
            parts.append(_blank(pragma) if is_ours or not self._is_active else pragma)
            done = end
        rest = self._text[done:]
        parts.append(rest if self._is_active else _blank(rest))
        for level in self._levels:
            self._say(level.offset, "{IF} is not closed", "{END_IF}")
        self._made.text = "".join(parts)
        return self._made

    @property
    def _is_active(self) -> bool:
        return all(level.is_active for level in self._levels)

    def _say(self, offset: int, what: str, expected: str = "", hint: str = "", *, is_note: bool = False) -> None:
        self._made.mistakes.append((offset, Mistake(0, 0, what, expected, is_note=is_note, hint=hint)))

    def _pragmas(self) -> Iterator[tuple[int, int]]:
        """Yield where pragmas are, which neither comments nor texts contain."""
        text, at = self._text, 0
        while (found := _BORDER.search(text, at)) is not None:
            sign = found[0]
            if sign == "{":
                end = text.find("}", found.end())
                if end < 0:
                    return
                yield found.start(), end + 1
                at = end + 1
            elif sign == "(*":
                at = self._after_comment(found.end())
            else:
                at = _after(text, found)

    def _after_comment(self, at: int) -> int:
        depth = 1
        for found in re.compile(r"\(\*|\*\)").finditer(self._text, at):
            depth += (1 if self._nests else 0) if found[0] == "(*" else -1
            if depth == 0:
                return found.end()
        return len(self._text)

    def _obey(self, word: str, rest: str, offset: int) -> bool:
        """Follow a pragma of conditions; return whether it is one."""
        match word:
            case "if":
                self._begin(rest, offset)
            case "elsif":
                self._go_on(rest, offset, is_last=False)
            case "else":
                self._go_on("", offset, is_last=True)
            case "end_if":
                if self._levels:
                    self._levels.pop()
                else:
                    self._say(offset, "{END_IF} has no {IF}", "{IF condition} in front of it")
            case "define" | "undefine":
                if self._is_active:
                    self._define(word, rest, offset)
            case _:
                return False
        return True

    def _define(self, word: str, rest: str, offset: int) -> None:
        found = _DEFINE.fullmatch(rest)
        if found is None:
            self._say(offset, f"{{{word} {rest[:40]}}} has no name", f"{{{word} NAME}}")
        elif word == "define":
            self._defines[found[1].casefold()] = found[2] or found[3] or ""
        else:
            self._defines.pop(found[1].casefold(), None)

    def _begin(self, rest: str, offset: int) -> None:
        is_around_active = self._is_active and len(self._levels) < _MOST_LEVELS
        holds = self._holds(rest, offset) if is_around_active else False
        self._levels.append(_Level(offset, is_around_active, holds is True, holds is not False, holds is None))

    def _go_on(self, rest: str, offset: int, *, is_last: bool) -> None:
        word = "ELSE" if is_last else "ELSIF"
        if not self._levels or self._levels[-1].is_last:
            self._say(offset, f"{{{word}}} has no {{IF}}", "{IF condition} in front of it")
            return
        level = self._levels[-1]
        level.is_last = is_last
        if not level.is_around_active or level.was_taken:
            level.is_active = False
            return
        holds = True if is_last else self._holds(rest, offset)
        level.is_unknown |= holds is None
        level.was_taken = holds is True and not level.is_unknown
        level.is_active = holds is not False

    def _holds(self, condition: str, offset: int) -> bool | None:
        """Return whether a condition holds; None if it is about the project."""
        try:
            return _Condition(condition, self._defines).value()
        except ValueError:
            self._say(offset, f"the condition {condition[:60] or 'of {IF}'} cannot be read", _EXPECTED)
            return False
        except LookupError:
            what = f"the condition {condition[:60]} is not evaluated, and all its branches are compiled"
            self._say(offset, what, hint="Conditions about names that are defined are.", is_note=True)
            return None


class _Condition:
    """Reads and evaluates a condition without blanks around it.

    ValueError if it is none; LookupError if it is about the project.
    """

    def __init__(self, text: str, defines: Mapping[str, str]) -> None:
        self._tokens, at = list[str](), 0
        while at < len(text):
            found = _TOKEN.match(text, at)
            if found is None:
                raise ValueError(text)
            self._tokens.append(found[1])
            at = found.end()
        self._defines, self._at, self._depth, self._is_about_project = defines, 0, 0, False

    def value(self) -> bool:
        value = self._any()
        if self._at < len(self._tokens):
            raise ValueError("more than a condition")
        if self._is_about_project:
            raise LookupError
        return value

    def _next(self, *expected: str) -> str:
        token = self._tokens[self._at] if self._at < len(self._tokens) else ""
        if not token or (expected and token.casefold() not in expected):
            raise ValueError(token)
        self._at += 1
        return token

    def _is_next(self, word: str) -> bool:
        is_there = self._at < len(self._tokens) and self._tokens[self._at].casefold() == word
        self._at += is_there
        return is_there

    def _any(self) -> bool:
        value = self._all()
        while self._is_next("or"):
            value = self._all() or value
        return value

    def _all(self) -> bool:
        value = self._one()
        while self._is_next("and"):
            value = self._one() and value
        return value

    def _one(self) -> bool:
        self._depth += 1
        if self._depth > _MOST_LEVELS:
            raise ValueError("too deep")
        if self._is_next("not"):
            value = not self._one()
        elif self._is_next("("):
            value = self._any()
            self._next(")")
        else:
            value = self._asked(self._next().casefold())
        self._depth -= 1
        return value

    def _asked(self, name: str) -> bool:
        if name not in ("defined", "project_defined", "hasvalue", *_OF_PROJECTS):
            raise ValueError(name)
        self._next("(")
        given = list[str]()
        while not self._is_next(")"):
            given.append(self._next())
        if not given:
            raise ValueError(name)
        if name in _OF_PROJECTS or (name == "defined" and given[1:2] == [":"]):
            self._is_about_project = True
            return False
        key = given[0].casefold()
        if name == "hasvalue":
            if len(given) != 3 or given[1] != ",":
                raise ValueError(name)
            return key in self._defines and self._defines[key] == given[2].strip("'")
        if len(given) != 1:
            raise ValueError(name)
        return key in self._defines or _KNOWN.get(key, False)


def _after(text: str, found: re.Match[str]) -> int:
    """Return the offset behind a comment or a text that begins there; a text ends in its line at the latest."""
    if found[0] in ("//", "/*"):
        end = text.find("\n" if found[0] == "//" else "*/", found.end())
        return len(text) if end < 0 else end + (0 if found[0] == "//" else 2)
    closed = re.compile(rf"(?:\$.|[^{found[0]}$\n])*{found[0]}?").match(text, found.end())
    assert closed is not None
    return closed.end()


def _blank(text: str) -> str:
    """Return a text of the same lines and columns with nothing in it."""
    return re.sub(r"[^\n]", " ", text)
