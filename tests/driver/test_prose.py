"""The prose linter: what it reads of each kind of file, and what it reports."""

import tomllib
from pathlib import Path

import pytest
from tests.driver import prose
from tests.driver.prose import Finding

RULES = prose.rules_of(tomllib.loads(prose.WORDS.read_text(encoding="utf-8")))
EXPECTED = "write: expected ..."


def found(suffix: str, source: str) -> list[tuple[int, str]]:
    return [(finding.line, finding.text) for finding in prose.findings(suffix, source, RULES)]


def test_a_finding_has_its_line_and_what_to_write() -> None:
    source = "# Ports\n\nThe port is taken.\nA message that right\nwould be clear.\n"
    assert prose.findings(".md", source, RULES) == [Finding(4, "right would be", EXPECTED)]


@pytest.mark.parametrize(
    "source",
    [
        "```sh\nfieldrig mend\n```\n",
        "Call `mend` twice.\n",
        "See [the page](mend.md).\n",
        "The port is fixed.\n",
    ],
)
def test_code_on_a_page_is_not_read(source: str) -> None:
    assert found(".md", source) == []


def test_a_comment_of_a_rig_file_is_read_and_its_keys_are_not() -> None:
    assert found(".yaml", "nobody: 1  # nobody hears it\nurl: a#nobody\n") == [(1, "nobody")]


def test_docstrings_messages_and_comments_are_read_and_names_are_not() -> None:
    source = '''"""Of the port."""
ties = {"nobody": "nobody"}
log.info("nobody is %s there", nobody)
log.info(f"the {nobody!r} nobody")
# nobody
'''
    assert found(".py", source) == [(1, "Of"), (3, "nobody"), (4, "nobody"), (5, "nobody")]


def test_an_error_of_english_is_found_by_proselint() -> None:
    assert found(".md", "It is for all intensive purposes right.\n") == [(1, "for all intensive purposes")]


def test_a_word_twice_is_found_across_lines() -> None:
    assert found(".md", "It is the\nthe port.\n") == [(1, "the the")]


@pytest.mark.parametrize("word", ["whoever", "mended", "of iron", "the screws", "turned over", "cannot be had", "anew"])
def test_the_words_of_the_guide_are_refused(word: str) -> None:
    assert [text for _, text in found(".md", f"It is {word} now.\n")] == [word.removeprefix("the ")]


def test_the_files_to_check_exist() -> None:
    assert all(path.suffix in prose.PROSE_OF for path in prose.checked())


@pytest.mark.long
def test_only_what_changed_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "page.md"
    page.write_text("The port is taken.\n")
    monkeypatch.setattr(prose, "CLEAN", tmp_path / "build" / "clean")
    monkeypatch.setattr(prose, "checked", lambda: [page])
    clean = prose.state_of(page)
    assert (prose.main([]), prose.known_as_clean()) == (0, {clean})
    page.write_text("Nobody hears it.\n")
    assert prose.state_of(page) != clean
    assert (prose.main([]), prose.known_as_clean()) == (1, set())
    prose.CLEAN.write_bytes(b"\xff")  # of an interrupted run
    assert (prose.main([]), prose.known_as_clean()) == (1, set())
    monkeypatch.setattr(prose, "known_as_clean", lambda: {prose.state_of(page)})
    assert prose.main([]) == 0
