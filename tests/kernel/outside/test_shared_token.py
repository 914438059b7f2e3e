"""The token that a rig and its tools share: where it comes from, and what is refused."""

import os
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from fieldrig.config import yaml_source
from fieldrig.control import endpoint
from fieldrig.errors import ConfigError, RigError
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, is_proof, make_token, proof, token


@pytest.fixture(autouse=True)
def no_token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(TOKEN_VARIABLE, raising=False)
    monkeypatch.delenv(FILE_VARIABLE, raising=False)


def test_without_the_variables_there_is_none() -> None:
    assert token() is None
    make_token()
    assert token() is None


@pytest.mark.parametrize("blank", ["", " ", "\t\n"])
def test_a_blank_token_is_wrong_configuration_and_guards_nothing(blank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(TOKEN_VARIABLE, blank)
    with pytest.raises(ConfigError, match="FIELDRIG_TOKEN: the token is empty"):
        token()
    with pytest.raises(ConfigError):
        endpoint.is_guarded("tcp/0.0.0.0:7447")
    with pytest.raises(ConfigError):
        endpoint.listen("tcp/0.0.0.0:0")


@pytest.mark.parametrize("wrong", ["a\0b", "a\nb", "x" * 5000, "\udcff"])
def test_a_token_is_one_line_of_printable_characters(
    wrong: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "token"
    path.write_bytes(os.fsencode(wrong))
    monkeypatch.setenv(FILE_VARIABLE, str(path))
    with pytest.raises(ConfigError):
        token()


def test_a_blank_file_and_one_that_cant_be_read_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "token"
    path.write_text("\n")
    monkeypatch.setenv(FILE_VARIABLE, str(path))
    with pytest.raises(ConfigError, match="the token is empty"):
        token()
    monkeypatch.setenv(FILE_VARIABLE, str(tmp_path))
    with pytest.raises(ConfigError, match="cannot be read"):
        token()
    monkeypatch.setenv(FILE_VARIABLE, "")
    with pytest.raises(ConfigError, match="FIELDRIG_TOKEN_FILE"):
        token()


def test_the_file_is_made_once_and_for_its_user_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "token"
    monkeypatch.setenv(FILE_VARIABLE, str(path))
    assert token() is None  # a process that starts before the rig waits for it
    make_token()
    made = token()
    assert made is not None
    assert len(made) >= 32
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    make_token()
    assert token() == made
    assert list(path.parent.iterdir()) == [path]


def test_two_rigs_make_two_tokens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = set()
    for name in ("one", "two"):
        monkeypatch.setenv(FILE_VARIABLE, str(tmp_path / name))
        make_token()
        made.add(token())
    assert len(made) == 2


def test_of_many_who_make_it_at_once_all_have_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FILE_VARIABLE, str(tmp_path / "token"))

    def make(_: int) -> str | None:
        make_token()
        return token()

    with ThreadPoolExecutor(16) as pool:
        assert len(set(pool.map(make, range(64)))) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["token"]


def test_a_token_of_the_user_goes_before_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "token"
    monkeypatch.setenv(FILE_VARIABLE, str(path))
    monkeypatch.setenv(TOKEN_VARIABLE, " mine \n")
    make_token()
    assert token() == "mine"
    assert not path.exists()


def test_a_folder_that_cant_be_written_to_is_reported_with_its_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(FILE_VARIABLE, str(tmp_path / "file" / "token"))
    with pytest.raises(RigError, match="no token can be made") as refused:
        make_token()
    assert FILE_VARIABLE in refused.value.remedy


def test_a_proof_is_that_of_rfc_2104_over_all_that_it_is_for() -> None:
    # From `printf 'nonce\0wires\0lamp' | openssl dgst -sha256 -hmac secret`.
    given = "8ab98d0adf7cc50d99db3c56a39c5d170ae3c01a3369ee58e155b6b1736410c2"
    assert proof("secret", "nonce", "wires", "lamp") == given
    assert is_proof(given, "secret", "nonce", "wires", "lamp")
    for other in (
        ("other", "nonce", "wires", "lamp"),
        ("secret", "another", "wires", "lamp"),
        ("secret", "nonce", "can0", "lamp"),
        ("secret", "nonce", "wires", "switch"),
    ):
        assert not is_proof(given, *other)
    assert not is_proof("", "secret", "nonce", "wires", "lamp")
    assert not is_proof("\u00e4", "secret", "nonce", "wires", "lamp")


@pytest.mark.long
def test_no_token_is_published_for_containers() -> None:
    folder = Path(__file__).parents[3] / "docker"
    part = _yaml(folder / "service.yaml")["services"]["part"]
    assert part["environment"][TOKEN_VARIABLE] is None  # that of the shell, if it has one
    volume, _, place = part["volumes"][0].partition(":")
    assert Path(part["environment"][FILE_VARIABLE]).parent == Path(place)
    stacks = [path for path in folder.glob("compose*.yaml") if "rig" in _yaml(path)["services"]]  # not what extends one
    assert len(stacks) == 3
    for path in stacks:
        assert volume in _yaml(path)["volumes"], path


def _yaml(path: Path) -> Any:
    return yaml_source.read(path.read_text(encoding="utf-8"), path.name).data
