r"""The directives of the preprocessor, carried out on the tokens (manual lines 8581, 8845 and 8932).

`#define N ...` gives a name to the rest of the line.  `#set N A | B` gives a name to the OR of masks.  `#undef N`
takes a name away.  `#include "FILE"` reads another file.  A `\` at the end of a line continues the directive.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.system_files import SYSTEM_FILES, system_file, system_file_with
from fieldrig_devices.pam.language.tokens import Token, Tokens, mistake, split

DEEPEST_INCLUDE: Final = 10
"""Levels of files that include each other."""
MOST_TOKENS: Final = 2_000_000
"""Tokens of a whole application, after all names have been replaced."""

Reader = Callable[[str], str | None]
"""Returns the text of an included file, or None if there is none of this name.  ValueError: it cannot be read."""


def no_files(_name: str) -> str | None:
    return None


@dataclass(slots=True)
class Preprocessor:
    """Reads files and gives one list of tokens without directives."""

    read: Reader = no_files
    mistakes: list[Mistake] = field(default_factory=list)
    names: dict[str, list[Token]] = field(default_factory=dict)
    tokens: list[Token] = field(default_factory=list)
    depth: int = 0

    def file(self, source: Tokens) -> None:
        """Take the tokens of a file over, except for its end."""
        self.mistakes += source.mistakes
        tokens, at = source.tokens, 0
        while tokens[at].kind != "end":
            if tokens[at].kind == "directive":
                at = self._directive(tokens, at)
                continue
            if len(self.tokens) > MOST_TOKENS:
                self.mistakes.append(mistake(tokens[at].place, "the application is too long", f"{MOST_TOKENS} tokens"))
                return
            self.tokens += self._replaced(tokens[at])
            at += 1

    def _replaced(self, token: Token) -> list[Token]:
        """Return what a name stands for, at the place of the name."""
        if token.kind != "name" or token.text not in self.names:
            return [token]
        return [Token(part.kind, part.text, token.place, part.value) for part in self.names[token.text]]

    def _directive(self, tokens: list[Token], at: int) -> int:
        """Carry a directive out, and return where the next line begins."""
        end = at + 1
        while tokens[end].kind != "end" and not tokens[end].begins_line:
            end += 1
        directive, rest = tokens[at], tokens[at + 1 : end]
        if not directive.begins_line:
            self._say(directive, f"#{directive.text} is not the first word of its line", "a line of its own")
        elif directive.text == "include":
            self._include(directive, rest)
        elif not rest or rest[0].kind != "name":
            self._say(rest[0] if rest else directive, f"#{directive.text} has no name", "a name")
        elif directive.text == "define":
            self._define(rest[0], [part for token in rest[1:] for part in self._replaced(token)])
        elif directive.text == "set":
            self._set(rest[0], rest[1:])
        else:
            self._undefine(rest)
        return end

    def _define(self, name: Token, meaning: list[Token]) -> None:
        if name.text in self.names:
            hint = f"Write #undef {name.text} first."
            self._say(name, f"{name.text} is already defined", "a new name", hint)
        elif len(meaning) > 1000:
            self._say(name, f"the meaning of {name.text} is too long", "at most 1000 tokens")
        else:
            self.names[name.text] = meaning

    def _set(self, name: Token, masks: list[Token]) -> None:
        value = 0
        for position, token in enumerate(masks):
            if position % 2 == 1:
                if token.text != "|":
                    self._say(token, f"got {token.text}", "|")
                    return
                continue
            parts = self._replaced(token)
            if len(parts) != 1 or not isinstance(parts[0].value, int) or parts[0].kind != "integer":
                self._say(
                    token, f"{token.text} is not a mask", "a mask that is known here", missing_file_hint(token.text)
                )
                return
            value |= parts[0].value
        if len(masks) % 2 == 0:
            self._say(name, f"the masks of {name.text} are not complete", "masks with | between them")
            return
        self._define(name, [Token("integer", str(value), name.place, value)])

    def _undefine(self, rest: list[Token]) -> None:
        if self.names.pop(rest[0].text, None) is None:
            self._say(rest[0], f"{rest[0].text} is not defined yet", "a name of #define or #set")
        elif len(rest) > 1:
            self._say(rest[1], f"got {rest[1].text}", "the end of the line")

    def _include(self, directive: Token, rest: list[Token]) -> None:
        name = str(rest[0].value) if rest and rest[0].kind == "text" else "".join(token.text for token in rest)
        name = name.strip("<>")
        system = system_file(name)
        if not name or self.depth >= DEEPEST_INCLUDE:
            expected = f"at most {DEEPEST_INCLUDE} files in each other" if name else "the name of a file in quotes"
            self._say(directive, "a file cannot be included", expected)
            return
        try:
            text = self._text(name, directive.place.file)
        except ValueError as cause:
            self._say(directive, str(cause), "a text file")
            return
        if text is None and system is None:
            expected = f"a file beside the application, or {', '.join(SYSTEM_FILES)}"
            hint = "Copy it beside the application, and write its name without the drive." if ":" in name else ""
            self._say(directive, f"there is no file {name}", expected, hint)
            return
        if text is not None:
            self.depth += 1
            self.file(split(text, name))
            self.depth -= 1
        for mask, value in (system or {}).items():  # users may add masks to a file of their own (manual line 8839)
            self.names.setdefault(mask, [Token("integer", str(value), directive.place, value)])

    def _text(self, name: str, includer: str) -> str | None:
        """Return the text of a file beside the application, or else of one beside the file that includes it."""
        text = self.read(name)
        folder = includer.replace("\\", "/").rpartition("/")[0]
        return self.read(f"{folder}/{name}") if text is None and folder and self.depth > 0 else text

    def _say(self, token: Token, what: str, expected: str, hint: str = "") -> None:
        self.mistakes.append(mistake(token.place, what, expected, hint))


def missing_file_hint(name: str) -> str:
    """Return the hint that a system file defines the name, or nothing."""
    file = system_file_with(name)
    return f'{name} is defined in {file}: write #include "{file}".' if file else ""
