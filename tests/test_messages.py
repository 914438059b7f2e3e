"""Messages are for users of the wheel alone: no regular expressions, no names of classes, no pages of a clone."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
import typer
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.cli.kind_facts import facts_of
from fieldrig.config import kinds
from fieldrig.config.schema import SCHEMAS, names, schema_of
from fieldrig.config.wording import explain
from fieldrig.settings import Settings

ROOT = Path(__file__).parents[1]
SOURCES = sorted(path for folder in ("emulator", "bus", "devices", "page") for path in (ROOT / folder).rglob("*.py"))
FIND = {kinds.BUSES: kinds.find_bus, kinds.DEVICES: kinds.find_device}
MODELS = {
    **{
        f"{group} {name}": kinds.settings_model(find(name))
        for group, find in FIND.items()
        for name in kinds.installed(group)
    },
    **{f"file {name}": point.load() for name, point in kinds.installed(SCHEMAS).items()},
}


def patterned(part: Any, about: str = "") -> Iterator[dict[str, Any]]:
    """Yield each schema in `part` that has a regular expression, with the description that a message would show."""
    if isinstance(part, dict):
        about = part.get("description", about)
        if isinstance(part.get("pattern"), str):
            yield {**part, "description": about}
        for inner in part.values():
            yield from patterned(inner, about)
    elif isinstance(part, list):
        for inner in part:
            yield from patterned(inner, about)


@pytest.mark.parametrize("name", names())
def test_what_a_regular_expression_asks_for_is_said_in_words(name: str) -> None:
    for part in patterned(schema_of(name)):
        assert part.get("examples") or part["description"], part


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_no_message_shows_a_regular_expression(model: Any) -> None:
    """Every text of every model gets one that fits no pattern."""
    schema = model.model_json_schema()
    wrong = dict.fromkeys(schema.get("properties", {}), "\x00 \n")
    try:
        model.model_validate(wrong)
    except ValueError as refused:
        for mistake in explain(refused, wrong, model):  # type: ignore[arg-type]  # it is a ValidationError
            assert not re.search(r"\[\^|\^\[|\)\$|\]\*|\{1,", f"{mistake.what} {mistake.remedy}"), mistake


def texts(path: Path) -> Iterator[ast.Constant]:
    """Yield the strings of a module that are not docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    said = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in said:
            yield node


@pytest.mark.long
def test_no_message_names_a_page_that_a_wheel_lacks() -> None:
    naming = [f"{path}:{text.lineno}" for path in SOURCES for text in texts(path) if "docs/" in str(text.value)]
    assert naming == []


def helps(command: Any, name: str) -> Iterator[tuple[str, str]]:
    context = click.Context(command, info_name=name)
    yield name, command.get_help(context)
    for inner in command.list_commands(context) if hasattr(command, "list_commands") else ():
        yield from helps(command.get_command(context, inner), f"{name} {inner}")


def test_no_help_names_a_page_that_a_wheel_lacks() -> None:
    found = dict(helps(typer.main.get_command(app), "fieldrig"))
    assert len(found) > 50
    assert [name for name, text in found.items() if "docs/" in text] == []


@pytest.mark.parametrize("kind", [*kinds.installed(kinds.DEVICES)])
def test_a_link_is_described_by_kinds_of_buses(kind: str) -> None:
    for link in kinds.link_parameters(kinds.find_device(kind)).values():
        words = kinds.bus_kinds_of(link)
        assert words == "any" or set(words.split(" or ")) <= set(kinds.installed(kinds.BUSES))


@pytest.mark.parametrize("kind", [name for group in FIND for name in kinds.installed(group)])
def test_the_types_of_settings_are_no_classes(kind: str) -> None:
    types = {setting["type"] for setting in facts_of(kind)["settings"].values()}
    classes = {model.__name__ for model in Settings.__subclasses__()}
    assert not [
        word for name in types for word in name.split(" or ") if word in classes or re.search(r"[a-z][A-Z]", word)
    ]


def test_the_help_has_the_commands_in_groups() -> None:
    shown = CliRunner().invoke(app, ["--help"]).stdout
    groups = dict(re.findall(r"^([A-Z][a-z ]+):\n((?:  \S.*\n?)+)", shown, re.MULTILINE))
    in_groups = {group: [line.split()[0] for line in text.splitlines()] for group, text in groups.items()}
    assert in_groups["Run a rig"] == [
        *("up", "exec", "step", "back", "pause", "run", "stop", "restart", "replay", "scenario", "search"),
    ]
    assert in_groups["Look and change"] == ["help", "status", "watch", "get", "set", "fault", "record", "trace"]
    assert in_groups["Files"] == ["check", "schema", "diff", "draw", "eds", "export", "new"]
    assert in_groups["Programs"] == ["coverage", "arp", "debug", "debug-adapter", "editor", "iec", "pam"]
    assert in_groups["Devices"] == ["devices", "conform", "dial", "nameplate"]
