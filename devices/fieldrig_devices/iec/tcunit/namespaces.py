"""Names that several libraries of a project have: each library means its own, as each has a namespace.

Source: the public description of CODESYS V3 and TwinCAT 3 (a library's name resolves to its own objects first, then
to those of the libraries that it names; `Namespace.Object` is the object of that library).

All units of a project are compiled as one, so an object of a library whose name is taken gets another one,
`Pump_of_Lib`, in the text of that library and wherever it is meant.  Lines stay what they are; columns may not.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.languages.source_file import SourceFile

_OBJECT: Final = re.compile(r"<(?:POU|Itf|DUT|GVL)\s[^>]*?Name=\"([^\"]*)\"")
CODE: Final = re.compile(r"(?<=<!\[CDATA\[).*?(?=\]\]>)", re.DOTALL)
"""The text of programs in a file of TwinCAT."""
_PART: Final = re.compile(
    r"\(\*.*?\*\)|//[^\n]*|'(?:\$.|[^'$])*'|\"(?:\$.|[^\"$])*\"|\{[^}]*\}"
    r"|(?P<front>(?:[A-Za-z_]\w*\s*\.\s*)+)?(?P<word>[A-Za-z_]\w*)",
    re.DOTALL,
)
_HEAD: Final = re.compile(
    r"\s*(?:PROPERTY|METHOD|ACTION)\s+(?:(?:PUBLIC|PRIVATE|PROTECTED|INTERNAL|FINAL|ABSTRACT)\s+)*(\w+)"
)
_NAMES: Final = re.compile(r"((?:[A-Za-z_]\w*\s*,\s*)*[A-Za-z_]\w*)\s*(?:AT\s+%\S+\s*)?(:(?!=))?")
"""Names with commas between them, which a colon behind them declares; others are matched too, so that none is twice."""
_MEMBER: Final = re.compile(r"<(?:Method|Property|Action)\s[^>]*?Name=\"([^\"]*)\"")


@dataclass(slots=True)
class Space:
    """The files of a project or of a library, and the libraries that it names."""

    title: str
    """The name of a library, for names that are taken."""
    files: list[SourceFile]
    parameters: dict[tuple[str, str], str] = field(default_factory=dict)
    """Constants that are set in this library, by the list of global variables and the name, both in small letters."""
    named: list[tuple[str, "Space"]] = field(default_factory=list)
    """The libraries that it names, each with its namespace."""
    other: dict[str, str] = field(default_factory=dict)
    """The objects with another name, by their own in small letters."""


def separate(spaces: Sequence[Space]) -> None:
    """Give the objects of libraries other names where those are taken; the project itself is the first space."""
    taken: set[str] = set()
    for space in spaces:
        own = dict(_objects(space.files))
        for name, title in own.items():
            if name in taken:
                space.other[name] = _free(f"{title}_of_{re.sub(r'[^A-Za-z0-9]+', '_', space.title).strip('_')}", taken)
        taken |= {space.other.get(name, name).casefold() for name in own}
    for space in spaces if any(space.other for space in spaces) else ():
        own = dict(_objects(space.files))
        lists = {name: other.casefold() for name, other in space.other.items()}
        space.parameters = {(lists.get(key[0], key[0]), key[1]): value for key, value in space.parameters.items()}
        known = _Names(space, own)
        if known.plain or any(known.behind.values()):
            space.files[:] = [known.applied(file) for file in space.files]


def _free(name: str, taken: set[str]) -> str:
    while name.casefold() in taken:
        name += "_"
    return name


def _objects(files: Iterable[SourceFile]) -> Iterator[tuple[str, str]]:
    """Yield the objects in files of TwinCAT, each by its name in small letters, with the name."""
    for file in files:
        found = _OBJECT.search(file.text[:2_000])
        if found is not None:
            yield found[1].casefold(), found[1]


class _Names:
    """The other names that one space has to use."""

    def __init__(self, space: Space, own: Mapping[str, str]) -> None:
        self.plain: dict[str, str] = dict(space.other)
        """Names of objects without a namespace in front, by the old ones in small letters."""
        self.behind: dict[str, dict[str, str]] = {}
        """Names of objects behind a namespace, by that and the old names in small letters."""
        seen = set(own)
        for namespace, library in space.named:
            self.behind[namespace.casefold()] = library.other
            for name, _ in _objects(library.files):
                old = next((key for key, other in library.other.items() if other.casefold() == name), name)
                if old not in seen and old in library.other:
                    self.plain[old] = library.other[old]
                seen.add(old)

    def applied(self, file: SourceFile) -> SourceFile:
        """Return a file with these names."""
        found = _OBJECT.search(file.text[:2_000])
        if found is None:
            return file
        title = found[1].casefold()
        local = _local(file.text) - {title}
        plain = {name: other for name, other in self.plain.items() if name not in local}
        folded = file.text.casefold()
        if not any(word in folded for word in (*plain, *(name for names in self.behind.values() for name in names))):
            return file
        text = CODE.sub(lambda code: self._changed(code[0], plain), file.text)
        other = plain.get(title)
        if other is not None:
            text = text[: found.start(1)] + other + text[found.end(1) :]
        return replace(file, text=text)

    def _changed(self, code: str, plain: Mapping[str, str]) -> str:
        def named(match: re.Match[str]) -> str:
            word = match["word"]
            if word is None:
                return match[0]
            path = [part.strip() for part in (match["front"] or "").split(".")[:-1]] + [word]
            before = code[: match.start()].rstrip()[-1:]
            if before == "." or (before in ("(", ",") and code[match.end() :].lstrip()[:2] in (":=", "=>")):
                return match[0]  # a component, or the name of an argument
            place = 1 if len(path) > 1 and path[0].casefold() in self.behind else 0
            known = self.behind[path[0].casefold()] if place else plain
            other = known.get(path[place].casefold())
            if other is None:
                return match[0]
            path[place] = other
            return ".".join(path)

        return _PART.sub(named, code)


def _local(text: str) -> set[str]:
    """Return the variables, methods, properties and actions that a file declares, in small letters."""
    found = {name.casefold() for name in _MEMBER.findall(text)}
    for code in CODE.findall(text):
        found |= {name.casefold() for name in _HEAD.findall(code)}
        for match in _NAMES.finditer(code):
            if match[2]:
                found |= {name.strip().casefold() for name in match[1].split(",")}
    return found
