"""The shipped rigs listen on loopback only; a user who wants more says so in a file of their own."""

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ADDRESS = re.compile(r"(?:[a-z0-9]+/|[a-z0-9]+://)?(?P<host>[^:/@\s]+):\d{1,5}$")
FILES = sorted((Path(__file__).parents[3] / "configs").glob("*.yaml"))


def hosts(value: object) -> set[str]:
    """The hosts of all texts that look like host:port."""
    if isinstance(value, dict):
        return {host for part in value.values() for host in hosts(part)}
    if isinstance(value, list):
        return {host for part in value for host in hosts(part)}
    found = ADDRESS.match(value) if isinstance(value, str) else None
    return {found["host"]} if found else set()


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_address_is_on_loopback(file: Path) -> None:
    assert hosts(YAML(typ="safe", pure=True).load(file)) <= {"127.0.0.1"}


def test_an_address_is_found() -> None:
    assert hosts(
        {"a": ["tcp/0.0.0.0:1", "tcp://rig:2"], "b": {"c": "127.0.0.1:3", "d": "6000:01"}, "e": "tank.low"}
    ) == {*("0.0.0.0", "rig", "127.0.0.1", "6000")}
