"""Types, blocks, interfaces and constants that need themselves have a message in every dialect."""

import pytest
from iec_program import refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect

BY_ALL = [
    ("TYPE N : STRUCT v : INT; n : N; END_STRUCT; END_TYPE", "n : N;", "N contains itself"),
    (
        "TYPE N : STRUCT v : INT; n : ARRAY[1..2] OF N; END_STRUCT; END_TYPE",
        "n : ARRAY[1..2] OF N;",
        "N contains itself",
    ),
    (
        "TYPE A : STRUCT b : B; END_STRUCT; END_TYPE TYPE B : STRUCT a : ARRAY[1..2] OF A; END_STRUCT; END_TYPE",
        "n : A;",
        "A contains itself",
    ),
    ("TYPE N : STRUCT v : INT; n : N := (v := 3); END_STRUCT; END_TYPE", "n : N := (v := 1);", "N contains itself"),
    ("TYPE N : STRUCT v : INT; n : N; END_STRUCT; END_TYPE", "END_VAR VAR RETAIN n : N;", "N contains itself"),
    ("TYPE A : B; END_TYPE TYPE B : A; END_TYPE", "n : A;", "the type A is defined by itself"),
    ("TYPE A : ARRAY[1..2] OF A; END_TYPE", "n : A;", "the type A is defined by itself"),
    ("TYPE A : POINTER TO A; END_TYPE", "n : A;", "the type A is defined by itself"),
    ("FUNCTION_BLOCK F VAR f : F; END_VAR f(); END_FUNCTION_BLOCK", "n : F;", "F contains itself"),
    (
        "FUNCTION_BLOCK F VAR s : S; END_VAR s.f(); END_FUNCTION_BLOCK TYPE S : STRUCT f : F; END_STRUCT; END_TYPE",
        "n : F;",
        "S contains itself",
    ),
    (
        "FUNCTION F : S VAR_INPUT i : S; END_VAR F := F(i); END_FUNCTION TYPE S : STRUCT s : S; END_STRUCT; END_TYPE",
        "n : S;",
        "S contains itself",
    ),
    ("VAR_GLOBAL CONSTANT c : INT := d; d : INT := c; END_VAR", "n : INT := c;", "c is defined by itself"),
    ("TYPE E : (one := two, two := one); END_TYPE", "n : E;", "two is defined by itself"),
    ("TYPE E : (one := two, two := 5); END_TYPE", "n : E;", "two is defined by itself"),
    (
        "TYPE N : STRUCT v : INT; a : ARRAY[0..SIZEOF(N)] OF INT; END_STRUCT; END_TYPE",
        "n : N;",
        "the size of N depends on itself",
    ),
    (
        "TYPE N : STRUCT a : STRUCT b : ARRAY[0..SIZEOF(N)] OF INT; END_STRUCT; END_STRUCT; END_TYPE",
        "n : N;",
        "the size of N depends on itself",
    ),
]
TODAY = [
    ("TYPE U : UNION v : INT; u : U; END_UNION; END_TYPE", "n : U;", "U contains itself"),
    ("TYPE S EXTENDS S : STRUCT v : INT; END_STRUCT; END_TYPE", "n : S;", "S is no structure that can be extended"),
    ("FUNCTION_BLOCK F EXTENDS F END_FUNCTION_BLOCK", "n : F;", "F extends itself"),
    (
        "FUNCTION_BLOCK F EXTENDS G END_FUNCTION_BLOCK FUNCTION_BLOCK G EXTENDS F END_FUNCTION_BLOCK",
        "n : F;",
        "F extends itself",
    ),
    ("INTERFACE I EXTENDS I END_INTERFACE", "n : I;", "I extends itself"),
    (
        (
            "INTERFACE I EXTENDS J METHOD m END_METHOD END_INTERFACE INTERFACE J EXTENDS I END_INTERFACE "
            "FUNCTION_BLOCK F IMPLEMENTS I METHOD m END_METHOD END_FUNCTION_BLOCK"
        ),
        "n : F;",
        "J extends itself",
    ),
]


def check(before: str, declarations: str, message: str, dialect: Dialect) -> None:
    text = f"{before}\nPROGRAM PLC_PRG VAR {declarations} END_VAR ; END_PROGRAM"
    found = refused(text, dialect)
    assert any(f": {message}" in line for line in found), found


@pytest.mark.parametrize("dialect", [EPAS_4, EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(("before", "declarations", "message"), BY_ALL)
def test_what_needs_itself_has_a_message(before: str, declarations: str, message: str, dialect: Dialect) -> None:
    check(before, declarations, message, dialect)


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS], ids=lambda dialect: dialect.name)
@pytest.mark.parametrize(("before", "declarations", "message"), TODAY)
def test_what_extends_or_overlaps_itself_has_a_message(
    before: str, declarations: str, message: str, dialect: Dialect
) -> None:
    check(before, declarations, message, dialect)
