"""Constants with their values, and those that have none (manual 693 to 755 and 2819 to 2936)."""

import pytest
from iec_program import IecBench, program

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.parser import parse_body
from fieldrig_devices.iec.printer import expression_text
from fieldrig_devices.iec.tree import Literal, LiteralKind

INTEGER, REAL, STRING, TIME = LiteralKind.INTEGER, LiteralKind.REAL, LiteralKind.STRING, LiteralKind.TIME
DATE, TOD, DT, BOOL = LiteralKind.DATE, LiteralKind.TOD, LiteralKind.DT, LiteralKind.BOOL

# Dates in seconds since 1970-01-01, as `date -u +%s` prints them.
GOOD = [
    ("TRUE", BOOL, True, ""),
    ("BOOL#0", BOOL, False, "BOOL"),
    ("14", INTEGER, 14, ""),
    ("1_000", INTEGER, 1000, ""),
    ("2#1001_0011", INTEGER, 147, ""),
    ("8#67", INTEGER, 55, ""),
    ("16#A", INTEGER, 10, ""),
    ("16#0A_1B", INTEGER, 2587, ""),
    ("INT#16#7F", INTEGER, 127, "INT"),
    ("DINT#-5", INTEGER, -5, "DINT"),
    ("1000.23", REAL, 1000.23, ""),
    ("1.23e3", REAL, 1230.0, ""),
    ("1.23E03", REAL, 1230.0, ""),
    ("1.64e+009", REAL, 1.64e9, ""),
    ("7E-2", REAL, 0.07, ""),
    ("REAL#2.5", REAL, 2.5, "REAL"),
    ("T#14ms", TIME, 14, ""),
    ("T#100S12ms", TIME, 100_012, ""),
    ("t#12h34m15s", TIME, 45_255_000, ""),
    ("TIME#2d_4h_12m", TIME, 187_920_000, ""),
    ("T#25h", TIME, 90_000_000, ""),
    ("T#49d17h2m47s295ms", TIME, 4_294_967_295, ""),
    ("DATE#1996-05-06", DATE, 831_340_800, ""),
    ("d#1972-03-29", DATE, 70_675_200, ""),
    ("D#1998-12-07", DATE, 912_988_800, ""),  # X14: 7 December
    ("TIME_OF_DAY#15:36:30.123", TOD, 56_190_123, ""),
    ("tod#00:00:00", TOD, 0, ""),
    ("DATE_AND_TIME#1996-05-06-15:36:30", DT, 831_396_990, ""),
    ("dt#1972-03-29-00:00:00", DT, 70_675_200, ""),
    ("DT#1998-02-13-14:20", DT, 887_379_600, ""),
    ("'w1Wüß?'", STRING, "w1Wüß?", ""),
    ("':-)'", STRING, ":-)", ""),
    ("''", STRING, "", ""),
    ("'$$ $' $L $n $P $r $T $41 $e4'", STRING, "$ ' \n \n \f \r \t A ä", ""),
    ("'(* no comment // either *)'", STRING, "(* no comment // either *)", ""),
]


def read(text: str, dialect: Dialect = EPAS_4) -> tuple[tree.Expression | None, list[str]]:
    body, mistakes = parse_body(f"x := {text};", "test.st", "ST", dialect)
    assert isinstance(body, tree.StBody)
    first = body.statements[0] if body.statements else None
    return first.value if isinstance(first, tree.Assign) else None, [mistake.what for mistake in mistakes]


@pytest.mark.parametrize(("text", "kind", "value", "type_name"), GOOD)
def test_a_constant_has_its_value(text: str, kind: LiteralKind, value: object, type_name: str) -> None:
    found, mistakes = read(text)
    assert mistakes == []
    assert found == Literal(kind, value, text, type_name)  # type: ignore[arg-type]
    assert isinstance(found, Literal)
    assert type(found.value) is type(value)


@pytest.mark.parametrize(("text", "kind", "value", "type_name"), GOOD)
def test_the_value_of_a_constant_can_be_printed_and_read_again(
    text: str, kind: LiteralKind, value: object, type_name: str
) -> None:
    literal = Literal(kind, value, "", type_name)  # type: ignore[arg-type]
    assert read(expression_text(literal)) == (literal, [])


BAD = [
    ("t#5m68s", "68s overflows"),  # PD-L47, X9
    ("15ms", "15ms has no T# in front of it"),
    ("t#4ms13d", "d follows ms"),
    ("T#2d_26h_4m", "26h overflows"),  # manual 731, which X9 overrules
    ("T#5s5s", "s follows s"),
    ("T#", "nothing follows T#"),
    ("T#5", "T#5 is not a time"),
    ("T#1.5s", "1.5s has a fraction"),
    ("T#-5s", "a time cannot be negative"),
    ("T#50d", "T#50d is too long"),
    ("2#12", "2#12 is not a number of base 2"),
    ("8#8", "8#8 is not a number of base 8"),
    ("16#G1", "16#G1 is not a number of base 16"),
    ("16#", "16# is not a number of base 16"),
    ("3#12", "3#12 has base 3"),
    ("99999999999999999999", "99999999999999999999 is too large"),
    ("9" * 5_000, "the number is too long"),
    ("1.0E999", "the number is too large"),
    ("D#1998-02-30", "there is no day 1998-02-30"),
    ("D#1969-12-31", "1969-12-31 is out of range"),
    ("D#1998", "1998 is not a date"),
    ("TOD#24:00:00", "24:00:00 is not a time of day"),
    ("DT#1998-02-13", "1998-02-13 is not a date with a time"),
    ("'a$q'", "$q means nothing in a string"),
    ("'€'", "the character '€' is not in the character set of the controller"),
    ("BOOL#2", "BOOL#2 is not a truth value"),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_a_wrong_constant_is_refused_with_its_reason(text: str, message: str) -> None:
    assert read(text)[1] == [message]


@pytest.mark.parametrize(
    ("text", "value"),
    [("T#1.5s", 1_500), ("T#-5s", -5_000), ("T#2d_26h", 266_400_000), ("T#5m68s", 368_000), ("T#1500us", 1)],
)
def test_edition_3_knows_more_times(text: str, value: int) -> None:
    assert read(text, EDITION_3) == (Literal(TIME, value), [])


# Every number in a constant is an Unsigned_Int of annex A, table 9's `LTOD#15:36:55.360_227_400` among them.
UNDERSCORES = [
    ("LTOD#15:36:55.360_227_400", 56_215_360_227_400),
    ("LDT#1984-06-25-15:36:55.360_227_400", 457_025_815_360_227_400),
    ("LDATE#1_984-06-25", 456_969_600_000_000_000),
    ("LTIME#1_000us_5ns", 1_000_005),
    ("T#1_000ms", 1_000),
    ("T#1_0.2_5s", 10_250),
    ("D#19_84-0_6-25", 456_969_600),
    ("TOD#1_5:3_6:5_5.36", 56_215_360),
    ("DT#1984-06-25-1_5:36:55", 457_025_815),
    ("1_0.2_5", 10.25),
    ("1.5E1_0", 15_000_000_000.0),
    ("REAL#1.5E1_0", 15_000_000_000.0),
    ("INT#1_0", 10),
]


@pytest.mark.parametrize(("text", "value"), UNDERSCORES)
def test_underscores_stand_between_any_two_digits(text: str, value: float) -> None:
    found, mistakes = read(text, EDITION_3)
    assert mistakes == []
    assert isinstance(found, Literal)
    assert found.value == value


@pytest.mark.parametrize(
    "text",
    ["D#1984_-06-25", "TOD#1_:00:00", "TOD#12:00:00._5", "T#1__0s", "T#_1s", "T#1.2_s", "1.5E1_", "REAL#1_.5",
     "REAL#1__0.5", "REAL#1.5E1_", "INT#1_", "INT#1__0", "2#1_", "2#_1", "2#1__0"],
)  # fmt: skip
def test_underscores_elsewhere_are_refused(text: str) -> None:
    assert len(read(text, EDITION_3)[1]) == 1


def test_a_value_of_an_enumeration_may_have_its_type_in_front() -> None:
    assert read("Colour#red") == (tree.Member(tree.Name("Colour"), "red"), [])


ADDRESSES = [
    ("%QX75", tree.Direct("Q", "X", (75,))),
    ("%Q75", tree.Direct("Q", "", (75,))),
    ("%IW215", tree.Direct("I", "W", (215,))),
    ("%qb7", tree.Direct("Q", "B", (7,))),
    ("%MD48", tree.Direct("M", "D", (48,))),
    ("%IW2.5.7.1", tree.Direct("I", "W", (2, 5, 7, 1))),
    ("%MX5.0", tree.Direct("M", "X", (5, 0))),
]


@pytest.mark.manual("PD-363")
@pytest.mark.parametrize(("text", "expected"), ADDRESSES)
def test_an_address_has_an_area_a_size_and_numbers(text: str, expected: tree.Direct) -> None:
    assert read(text) == (expected, [])


@pytest.mark.manual("PD-363")
@pytest.mark.parametrize("text", ["%X5", "%QZ5", "%Q", "%QX", "%QX1.", "%IW5a"])
def test_what_is_no_address_is_refused(text: str) -> None:
    assert len(read(text)[1]) == 1


def test_the_size_l_belongs_to_the_long_types() -> None:
    assert read("%ML3")[1] == ["%ML3 has the size L, which is not supported"]
    assert read("%ML3", EDITION_3) == (tree.Direct("M", "L", (3,)), [])


def test_the_next_word_may_follow_a_number_at_once() -> None:
    body = "IF n >= 0THEN n := 3; END_IF; FOR m := 1TO 4DO ; END_FOR; IF m = 5AND n = 3THEN n := 4; END_IF;"
    bench = IecBench(program("n, m : INT;", body), CODESYS)
    bench.cycle()
    assert (bench["n"], bench["m"]) == (4, 5)
