"""Texts as they are on old disks: their ends, their lines, their code pages, and the names of the files."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.text.code_page import DOS, WINDOWS, likely_code_page
from fieldrig.text.source_text import decoded
from fieldrig_devices.languages.source_file import found_beside


@pytest.mark.parametrize(
    "data",
    [
        b"x <- 1;\r\ny <- 2;\r\n",
        b"x <- 1;\ny <- 2;\n",
        b"x <- 1;\ry <- 2;\r",
        b"x <- 1;\r\r\ny <- 2;\r\r\n",
        b"x <- 1;\r\ny <- 2;\r\n\x1a",
        b"x <- 1;\r\ny <- 2;\r\n\x1a\x1a\x1a\x1a",
        b"x <- 1;\r\ny <- 2;\r\n\x1a; END\r\n\xff",
        b"x <- 1;\r\ny <- 2;\r\n\0\0\0",
        b"\xef\xbb\xbfx <- 1;\r\ny <- 2;\r\n\x1a\0\0",
        "\ufeffx <- 1;\r\ny <- 2;\r\n\x1a\0".encode("utf-16-le"),
    ],
)
def test_a_text_ends_as_dos_ends_it(data: bytes) -> None:
    assert decoded(data) == "x <- 1;\ny <- 2;\n"


# The bytes are those of the tables of the code pages, written out by hand.
TEXTS = {
    "Für größere Wärme": (b"F\xfcr gr\xf6\xdfere W\xe4rme", b"F\x81r gr\x94\xe1ere W\x84rme"),
    "ÄNDERUNG, Öl und Übergang": (b"\xc4NDERUNG, \xd6l und \xdcbergang", b"\x8eNDERUNG, \x99l und \x9abergang"),
    "arrêté, déjà reçu à l'entrée": (b"arr\xeat\xe9, d\xe9j\xe0 re\xe7u \xe0 l'entr\xe9e",
                                     b"arr\x88t\x82, d\x82j\x85 re\x87u \x85 l'entr\x82e"),
    "velocità più alta, però": (b"velocit\xe0 pi\xf9 alta, per\xf2", b"velocit\x85 pi\x97 alta, per\x95"),
    "vel. máxima del motor, año": (b"vel. m\xe1xima del motor, a\xf1o", b"vel. m\xa0xima del motor, a\xa4o"),
    "Færdig på øen": (b"F\xe6rdig p\xe5 \xf8en", b"F\x91rdig p\x86 \x9ben"),
    "80 °C at 1.5°": (b"80 \xb0C at 1.5\xb0", b"80 \xf8C at 1.5\xf8"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "windows", "dos"), [(text, *pages) for text, pages in TEXTS.items()], ids=list(TEXTS))
def test_the_code_page_follows_from_the_letters(text: str, windows: bytes, dos: bytes) -> None:
    assert (likely_code_page(windows), decoded(windows)) == (WINDOWS, text)
    assert (likely_code_page(dos), decoded(dos)) == (DOS, text)


@pytest.mark.parametrize(
    "data",
    [
        b"(* the \x93first\x94 axis doesn\x92t move, \x84so\x94, 1\x965 \xfcber *)",
        b"(* Achse f\xe4hrt \x96 nicht weit *)",
        b"(* it\x92s the drive\x92s limit, \x97 and \x91that\x92 of the belt *)",
        b"(* \x84Not-Aus\x93 gedr\xfcckt *)",
    ],
)
def test_quotes_and_dashes_of_windows_are_no_letters_of_dos(data: bytes) -> None:
    assert likely_code_page(data) == WINDOWS


def test_lines_that_are_drawn_are_of_dos() -> None:
    assert decoded(b"\xc9\xcd\xcd\xcd\xcd\xbb\r\n\xba ab \xba") == "╔════╗\n║ ab ║"
    assert decoded(b"(* \xc4\xc4\xc4\xc4\xc4\xc4 *)") == "(* ────── *)"


def test_signs_of_windows_stay_those_of_windows() -> None:
    assert (
        decoded(b"(* \x84so\x93 \x96 5 \xb5m, 3 \xd7 4, \x80 *)")
        == "(* „so“ \N{EN DASH} 5 µm, 3 \N{MULTIPLICATION SIGN} 4, € *)"
    )


@given(st.binary(max_size=200))
def test_every_text_is_read_in_one_way(data: bytes) -> None:
    text = decoded(data)
    assert not set("\r\x1a") & set(text)
    assert decoded(text.encode()) == text.removeprefix("\ufeff") or text.startswith("\ufeff")


@pytest.fixture
def disk(tmp_path: Path) -> Path:
    for name in ("app/MAIN.PAM", "app/Inc/Defs.pam", "app/Inc/DEFS.H", "app/defs.pam", "other/secret.pam"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    return tmp_path / "app"


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("Inc/Defs.pam", "Inc/Defs.pam"),
        ("inc\\defs.pam", "Inc/Defs.pam"),
        ("INC\\DEFS.PAM", "Inc/Defs.pam"),
        (".\\inc\\.\\defs.h", "Inc/DEFS.H"),
        ("inc\\..\\DEFS.PAM", "defs.pam"),
        ("DEFS.PAM", "defs.pam"),
        ("inc", None),
        ("", None),
        ("inc\\none.pam", None),
        ("..\\other\\secret.pam", None),
        ("inc\\..\\..\\other\\secret.pam", None),
        ("/etc/passwd", None),
        ("\\defs.pam", None),
        ("C:\\defs.pam", None),
        ("a\0b", None),
        ("x" * 5_000, None),
    ],
)
def test_files_are_found_under_the_names_of_dos(disk: Path, name: str, found: str | None) -> None:
    assert found_beside(disk, name) == (None if found is None else disk / found)


def test_the_same_spelling_comes_first(disk: Path) -> None:
    for name in ("a.pam", "A.PAM", "A.pam"):
        (disk / name).write_text(name)
    assert [found_beside(disk, name) for name in ("A.pam", "a.pam", "a.PAM")] == [
        disk / "A.pam", disk / "a.pam", disk / "A.PAM",
    ]  # fmt: skip


def test_a_link_that_leads_out_of_the_folder_is_not_followed(disk: Path) -> None:
    (disk / "link.pam").symlink_to(disk.parent / "other" / "secret.pam")
    (disk / "away").symlink_to(disk.parent / "other")
    assert found_beside(disk, "LINK.PAM") is None
    assert found_beside(disk, "away\\secret.pam") is None


@given(st.text(max_size=30))
def test_any_name_is_found_or_not(name: str) -> None:
    found_beside(Path(__file__).parent, name)
