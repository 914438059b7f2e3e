"""Pages of the site with all settings of all kinds, made from the models that check a rig file."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from doc_pages import anchor, code_in, headings, links_in, page_named, rows

from fieldrig.cli.kind_facts import facts_of, settings_of, without
from fieldrig.config import kinds
from fieldrig.config.keys import BusKeys, DeviceKeys, PageKeys, RigKeys
from fieldrig.config.schema import SCHEMAS

FOLDER: Final = "reference"
HEAD: Final = ("key", "type", "without it", "meaning")


def texts() -> dict[str, str]:
    """Return the pages by their names in the folder `FOLDER`."""
    return {
        "settings-of-rigs.md": "\n".join(_of_rigs()),
        "settings-of-buses.md": "\n".join(_of_kinds("buses", kinds.list_buses(), _sections_of_buses())),
        "settings-of-devices.md": "\n".join(_of_kinds("devices", kinds.list_devices(), _sections_of_devices())),
        "settings-of-files.md": "\n".join(_of_files()),
    }


def _of_rigs() -> Iterator[str]:
    yield "# Settings of rigs\n"
    yield "These are the keys of a rig file that belong to no kind. [Rig files](rig-file.md) explains them.\n"
    titles = {"A rig": RigKeys, "The page": PageKeys, "Every bus": BusKeys, "Every device": DeviceKeys}
    for title, model in titles.items():
        yield f"## {title}\n"
        yield from _settings(settings_of(model))


def _of_kinds(sort: str, listed: Iterable[tuple[str, str]], sections: Mapping[str, str]) -> Iterator[str]:
    yield f"# Settings of {sort}\n"
    yield f"These are the settings of all kinds of {sort}, as a rig file has them and `fieldrig check` checks them.\n"
    for kind, about in listed:
        facts = facts_of(kind)
        yield f"## `{kind}`\n"
        yield f"{about[0].upper()}{about[1:]}: [its page]({sections[kind]}).\n"
        if facts["links"]:
            links = ((f"`{at}`", f"{of} {how}".strip()) for at, (of, how) in facts["links"].items())
            yield from _table(("link", "a bus of kind"), links)
        if facts["settings"]:
            yield from _settings(facts["settings"])
        if facts["faults"]:
            faults = ((f"`{what}`", f"`{keys}`" if keys else "") for what, keys in facts["faults"].items())
            yield from _table(("fault", "further keys"), faults)


def _of_files() -> Iterator[str]:
    yield "# Settings of other files\n"
    yield "These are the keys of files that a rig file names. `fieldrig schema NAME` prints their JSON Schema.\n"
    for name, point in kinds.installed(SCHEMAS).items():
        yield f"## `{name}`\n"
        yield from _settings(settings_of(point.load()))


def _settings(settings: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    return _table(HEAD, ((f"`{key}`", _type(of), _code(without(of)), of["about"]) for key, of in settings.items()))


def _type(setting: Mapping[str, Any]) -> str:
    return ", ".join(filter(None, (setting["type"], setting["limits"])))


def _table(head: Iterable[str], body: Iterable[Iterable[str]]) -> Iterator[str]:
    columns = tuple(head)
    yield f"| {' | '.join(columns)} |"
    yield f"|{'---|' * len(columns)}"
    yield from (f"| {' | '.join(map(_cell, row))} |" for row in body)
    yield ""


def _code(default: str) -> str:
    return f"`{default}`" if default and default != "needed" else default


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _sections_of_buses() -> dict[str, str]:
    page = page_named("buses.md")
    return {kind: f"{page.name}#{anchor(title)}" for title in headings(page) for kind in code_in(title)}


def _sections_of_devices() -> dict[str, str]:
    page = page_named("devices.md")
    cells = (row.cells[0] for row in rows(page) if row.columns[0] == "kind")
    links = {code_in(cell)[0]: links_in(cell)[0] for cell in cells}
    return {kind: f"{page.name}{link}" if link.startswith("#") else link for kind, link in links.items()}
