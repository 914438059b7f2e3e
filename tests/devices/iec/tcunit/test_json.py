"""JSON in suites, as Tc3_JsonXml has it.  Expected texts are those of RFC 8259 and of RapidJSON's documentation."""

import json
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as some
from tcunit_bench import SuiteBench, suite

from fieldrig_devices.iec.tcunit.json import iso, natives, nodes

SCALARS = some.none() | some.booleans() | some.integers(-(2**63), 2**64 - 1) | some.text(alphabet=' ab"\\/\n\x01é€')
DOCUMENTS = some.recursive(
    SCALARS,
    lambda inner: some.lists(inner, max_size=4) | some.dictionaries(some.text('ab"', max_size=3), inner, max_size=4),
    max_leaves=12,
)


def _passes(declarations: str, body: str) -> None:
    bench = SuiteBench.ran(suite(f"TEST('t');\n{body}\nTEST_FINISHED();", declarations), longest_ns=10**9)
    test = bench.test("t")
    assert test.is_finished, bench.suites[0].fault
    assert not test.failures, bench.lines


# ---- texts


@given(DOCUMENTS)
def test_a_document_that_is_written_is_the_one_that_was_read(value: object) -> None:
    # A STRING has the bytes of UTF-8, each as a character.
    text = json.dumps(value, ensure_ascii=False).encode().decode("latin-1")
    node = nodes.parsed(text)
    assert node is not None
    assert json.loads(nodes.written(node).encode("latin-1")) == value


@given(some.floats(allow_nan=False, allow_infinity=False))
def test_a_number_that_is_written_is_the_one_that_was_read(value: float) -> None:
    assert float(nodes.scalar_text(value)) == value
    assert json.loads(nodes.scalar_text(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.0"),
        (-0.0, "-0.0"),
        (1.0, "1.0"),
        (-123456.789, "-123456.789"),
        (1e20, "100000000000000000000.0"),
        (1.5e21, "1.5e21"),
        (0.00001, "0.00001"),
        (1.25e-7, "1.25e-7"),
        (1e100, "1e100"),
        (3.4028230607370965e38, "3.4028230607370967e38"),
        (1e23, "9.999999999999999e22"),
        (5e-324, "5e-324"),
        (1.7976931348623157e308, "1.7976931348623157e308"),
        (inf, ""),
        (nan, ""),
    ],
)
def test_numbers_have_the_forms_of_the_library(value: float, text: str) -> None:
    assert nodes.scalar_text(value) == text


@pytest.mark.parametrize(
    ("value", "places", "text"),
    [(1.2345, 3, "1.234"), (1.0001, 2, "1.0"), (0.0123, 3, "0.012"), (0.0001, 2, "0.0"), (1e-9, 3, "0.0")],
)
def test_decimal_places_are_cut_and_not_rounded(value: float, places: int, text: str) -> None:
    assert nodes.scalar_text(value, places) == text


@pytest.mark.parametrize(
    "text", ["", "{", "[1,]", "{'a':1}", "[NaN]", "[1e999]", '"\\ud800"', "[" * 10**5, "01", "\x01"]
)
def test_what_is_not_json_is_no_document(text: str) -> None:
    assert nodes.parsed(text) is None


@pytest.mark.parametrize(
    ("clock", "value", "text"),
    [
        (iso.DATE_AND_TIME, 1_703_949_600, "2023-12-30T15:20:00"),
        (iso.DCTIME, 12_345_678, "2000-01-01T00:00:00.012345678"),
        (iso.FILETIME, 12_345_678, "1601-01-01T00:00:01.2345678"),
    ],
)
def test_times_are_those_of_iso_8601(clock: iso.Clock, value: int, text: str) -> None:
    assert clock.text(value) == text
    assert clock.value(text) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1970-01-01T02:00:00+02:00", 0),
        ("1970-01-01T00:00:05Z", 5),
        ("1970-01-01T00:00:05.9", 5),
        ("1970-13-01T00:00:00", 0),
        ("yesterday", 0),
        ("1601-01-01T00:00:00", 0),
    ],
)
def test_a_time_may_have_a_zone_and_is_zero_if_there_is_none(text: str, value: int) -> None:
    assert iso.DATE_AND_TIME.value(text) == value


# ---- the writer


def test_the_writer_puts_commas_and_colons_between_what_it_is_given() -> None:
    _passes(
        "w : FB_JsonSaxWriter; s : STRING(300); bytes : ARRAY[0..4] OF BYTE := [16#68, 16#65, 16#6C, 16#6C, 16#6F];",
        """w.StartObject();
        w.AddKey('a'); w.AddDint(-1);
        w.AddKeyBool('b', TRUE);
        w.AddKey('c'); w.StartArray(); w.AddLreal(2); w.AddNull(); w.AddString('"x"'); w.AddReal(0.5); w.EndArray();
        w.AddKeyDateTime('t', DT#2023-12-30-15:20:00);
        w.AddKey('d'); w.AddBase64(ADR(bytes), SIZEOF(bytes));
        w.AddKey('h'); w.AddHexBinary(ADR(bytes), 3);
        w.AddKey('r'); w.AddRawObject('{}');
        w.EndObject();
        AssertEquals_STRING('{"a":-1,"b":true,"c":[2.0,null,"\\"x\\"",0.5],"t":"2023-12-30T15:20:00","d":"aGVsbG8=","h":"68656c","r":{}}',
            w.GetDocument(), 'document');
        AssertEquals_UDINT(INT_TO_UDINT(LEN(w.GetDocument())) + 1, w.GetDocumentLength(), 'with the closing zero');
        w.ResetDocument();
        AssertEquals_UDINT(0, w.GetDocumentLength(), 'nothing');""",
    )


def test_a_document_is_copied_whole_or_not_at_all() -> None:
    _passes(
        "w : FB_JsonSaxWriter; s : STRING(301) := 'old'; n : INT;",
        """w.StartArray();
        FOR n := 1 TO 100 DO w.AddDint(10); END_FOR;
        w.EndArray();
        AssertEquals_STRING('', w.GetDocument(), 'more than 255');
        AssertEquals_UDINT(0, w.CopyDocument(s, 255), 'no room');
        AssertEquals_STRING('', s, 'emptied');
        AssertEquals_UDINT(302, w.CopyDocument(s, 302), 'size');
        AssertEquals_UDINT(301, LEN2(ADR(s)), 'length');""",
    )


# ---- the parser


def test_values_are_found_by_name_by_index_and_by_iterators() -> None:
    _passes(
        """d : FB_JsonDomParser; root, v : SJsonValue; i, iEnd : SJsonIterator; a, aEnd : SJsonAIterator;
        names : STRING(255); sum : DINT;""",
        """root := d.ParseDocument('{"a":1,"b":[10,20,30],"c":{"x":"text","y":2.5},"e":[]}');
        i := d.MemberBegin(root);
        iEnd := d.MemberEnd(root);
        WHILE i <> iEnd DO
            names := CONCAT(names, d.GetMemberName(i));
            i := d.NextMember(i);
        END_WHILE;
        AssertEquals_STRING('abce', names, 'names');
        v := d.FindMember(root, 'b');
        a := d.ArrayBegin(v);
        aEnd := d.ArrayEnd(v);
        WHILE a <> aEnd DO
            sum := sum + d.GetInt(d.GetArrayValue(a));
            a := d.NextArray(a);
        END_WHILE;
        AssertEquals_DINT(60, sum, 'sum');
        AssertEquals_DINT(20, d.GetInt(d.GetArrayValueByIdx(v, 1)), 'by index');
        AssertTrue(d.GetArrayValueByIdx(v, 3) = 0, 'beyond the end');
        AssertTrue(d.ArrayBegin(d.FindMember(root, 'e')) = d.ArrayEnd(d.FindMember(root, 'e')), 'empty');
        AssertEquals_STRING('text', d.GetString(d.FindMemberPath(root, 'c/x')), 'path');
        AssertEquals_LREAL(2.5, d.GetDouble(d.FindMemberPath(root, 'c/y')), 0, 'number');
        AssertTrue(d.FindMember(root, 'z') = 0 AND NOT d.HasMember(root, 'z'), 'nothing');
        AssertTrue(d.IsInt(d.FindMember(root, 'a')) AND d.IsUint(d.FindMember(root, 'a')), 'type');
        AssertFalse(d.IsDouble(d.FindMember(root, 'a')), 'no point');
        AssertTrue(d.GetType(v) = EJsonType.eArrayType, 'kind');""",
    )


def test_a_text_that_is_not_valid_is_an_exception_of_the_parser() -> None:
    _passes(
        "d : FB_JsonDynDomParser; root : SJsonValue;",
        """root := d.ParseDocument('{"a":');
        AssertTrue(root = 0 AND d.ExceptionRaised(), 'wrong');
        root := d.ParseDocument('{}');
        AssertTrue(root <> 0 AND NOT d.ExceptionRaised(), 'right');""",
    )


def test_documents_are_built_and_changed() -> None:
    _passes(
        "d : FB_JsonDomParser; root, v, old : SJsonValue;",
        """root := d.NewDocument();
        v := d.AddObjectMember(root, 'o');
        d.AddIntMember(v := v, member := 'n', value := 5);
        d.AddStringMember(v, 's', 'x');
        v := d.AddArrayMember(root, 'a', 0);
        old := d.PushbackBoolValue(v, FALSE);
        d.PushbackNullValue(v);
        d.SetInt64(d.GetArrayValueByIdx(v, 1), LINT#9000000000);
        d.AddJsonMember(root, 'j', '[1]');
        AssertEquals_STRING('{"o":{"n":5,"s":"x"},"a":[false,9000000000],"j":[1]}', d.GetDocument(), 'built');
        d.RemoveArray(v, d.ArrayBegin(v));
        AssertTrue(d.RemoveMemberByName(root, 'j', TRUE), 'removed');
        AssertFalse(d.RemoveMemberByName(root, 'j', TRUE), 'no longer there');
        d.SetString(d.FindMemberPath(root, 'o/n'), 'five');
        AssertEquals_STRING('{"o":{"n":"five","s":"x"},"a":[9000000000]}', d.GetDocument(), 'changed');
        AssertFalse(d.IsBool(old), 'a value that is gone');
        AssertTrue(d.SetInt(old, 1) = 0, 'a value that is gone is not set');""",
    )


def test_a_null_becomes_an_object_or_an_array_by_what_is_added() -> None:
    _passes(
        "d : FB_JsonDomParser; root, v : SJsonValue;",
        """root := d.NewDocument();
        v := d.AddNullMember(d.AddNullMember(root, 'a'), 'b');
        d.PushbackIntValue(v, 1);
        AssertEquals_STRING('{"a":{"b":[1]}}', d.GetDocument(), 'made');
        AssertTrue(d.AddNullMember(v, 'c') = 0, 'an array has no members');""",
    )


def test_values_of_one_parser_are_known_to_another() -> None:
    _passes(
        "one, other : FB_JsonDomParser; root : SJsonValue;",
        """root := one.ParseDocument('{"a":7}');
        AssertEquals_DINT(7, other.GetInt(other.FindMember(root, 'a')), 'value');""",
    )


def test_a_block_may_extend_the_parser_and_be_made_with_new() -> None:
    extended = "FUNCTION_BLOCK Mine EXTENDS FB_JsonDomParser\nVAR document : INT; END_VAR\nEND_FUNCTION_BLOCK\n"
    body = """p := __NEW(Mine);
        p^.ParseDocument('[1,2]');
        AssertEquals_STRING('[1,2]', p^.GetDocument(), 'text');
        __DELETE(p);"""
    text = suite(f"TEST('t');\n{body}\nTEST_FINISHED();", "p : POINTER TO Mine;")
    bench = SuiteBench.ran(f"{extended}{text}", longest_ns=10**9)
    assert bench.test("t").is_finished
    assert not bench.lines


def test_bytes_of_new_take_a_text_of_any_size() -> None:
    _passes(
        "d : FB_JsonDomParser; size : UDINT; p : POINTER TO STRING;",
        """d.ParseDocument('{"a":"0123456789012345678901234567890123456789012345678901234567890123456789","b":"0123456789"}');
        size := d.GetDocumentLength();
        p := __NEW(BYTE, size);
        AssertEquals_UDINT(size, d.CopyDocument(p^, size), 'copied');
        d.NewDocument();
        AssertTrue(d.ParseDocument(p^) <> 0, 'parsed');
        AssertEquals_UDINT(size, d.GetDocumentLength(), 'size');
        __DELETE(p);""",
    )


@pytest.mark.parametrize(
    ("text", "is_base64", "size", "expected"), [("aGVsbG8=", True, 5, "hello"), ("aGVsbG8", False, 0, "")]
)
def test_bytes_come_from_base64(text: str, is_base64: bool, size: int, expected: str) -> None:
    _passes(
        "d : FB_JsonDomParser; v : SJsonValue; s : STRING;",
        f"""v := d.ParseDocument('"{text}"');
        AssertTrue(d.IsBase64(v) = {str(is_base64).upper()}, 'form');
        AssertEquals_DINT({size}, d.GetBase64(v, ADR(s), SIZEOF(s)), 'size');
        AssertEquals_STRING('{expected}', s, 'bytes');""",
    )


KINDS = (*natives.RANGES, *natives.KINDS, "Double")


@pytest.mark.parametrize(
    ("text", "types"),
    [
        ("1", "Int Uint Int64 Uint64 Number"),
        ("-1", "Int Int64 Number"),
        ("3000000000", "Uint Int64 Uint64 Number"),
        ("-3000000000", "Int64 Number"),
        ("18446744073709551615", "Uint64 Number"),
        ("18446744073709551616", "Double Number"),
        ("1.0", "Double Number"),
        ("true", "Bool True"),
        ("false", "Bool False"),
        ("null", "Null"),
        ('"x"', "String"),
        ("{}", "Object"),
        ("[]", "Array"),
    ],
)
def test_a_value_has_the_types_that_can_hold_it(text: str, types: str) -> None:
    asked = "\n".join(f"AssertEquals_BOOL({kind in types.split()}, d.Is{kind}(v), '{kind}');" for kind in KINDS)
    _passes("d : FB_JsonDomParser; v : SJsonValue;", f"v := d.ParseDocument('{text}');\n{asked}")


# ---- variables of a type

TYPED = """
    r : Recipe; p : Point; j : FB_JsonReadWriteDatatype; w : FB_JsonSaxWriter; s : STRING(999);
    n : INT := 5; e : HRESULT;
"""
RECIPE_TYPES = """
TYPE Color : (red, green, blue := 7); END_TYPE
TYPE Point : STRUCT x, y : REAL; END_STRUCT; END_TYPE
TYPE Recipe : STRUCT
    Name : STRING(5) := 'a"b'; Wide : WSTRING(9) := "\u65e5\u00ef"; On : BOOL; Count : INT := -5; Ratio : LREAL := 0.1;
    Big : ULINT := 16#FFFF_FFFF_FFFF_FFFF; Hue : Color := Color.blue; Baked : DT := DT#2026-01-31-08:30:00;
    b0, b1 : BIT; Points : ARRAY[1..2] OF Point; Grid : ARRAY[0..1, 0..1] OF BYTE := [1, 2, 3, 4];
END_STRUCT; END_TYPE
"""
WHOLE = {
    "Name": 'a"b', "Wide": "\u65e5\u00ef", "On": False, "Count": -5, "Ratio": 0.1, "Big": 2**64 - 1, "Hue": 7,
    "Baked": "2026-01-31T08:30:00", "b0": False, "b1": False, "Points": [{"x": 0.0, "y": 0.0}] * 2,
    "Grid": [[1, 2], [3, 4]],
}  # fmt: skip
CHANGES = {
    "name": "longer text", "Wide": "\u8a9e", "b1": True, "Points": [{"x": 3}, {"y": -4.5}], "Grid": [[9], [8, 7, 6]],
    "Baked": "2027-01-01T00:00:00", "Hue": 1, "Other": None,
}  # fmt: skip
CHANGED = WHOLE | {
    "Name": "longe", "Wide": "\u8a9e", "b1": True, "Points": [{"x": 3.0, "y": 0.0}, {"x": 0.0, "y": -4.5}],
    "Grid": [[9, 2], [8, 7]], "Baked": "2027-01-01T00:00:00", "Hue": 1,
}  # fmt: skip


def _typed(body: str) -> str:
    """Run a body with variables of the types, and return what it has written into `s`."""
    text = RECIPE_TYPES + suite(f"TEST('t');\n{body}\nTEST_FINISHED();", TYPED)
    bench = SuiteBench.ran(text, longest_ns=10**9)
    test = bench.test("t")
    assert test.is_finished, bench.suites[0].fault
    assert not test.failures, bench.lines
    return str(bench.runtime.read(bench.runtime.find("PRG_TEST.s.s")))


def _of(text: str) -> object:
    return json.loads(text.encode("latin-1"))


SYMBOL = "'Recipe', SIZEOF(r), ADR(r)"


def test_a_variable_is_written_by_its_type() -> None:
    assert _of(_typed(f"AssertTrue(j.CopyJsonStringFromSymbol({SYMBOL}, s, SIZEOF(s)) > 0, '');")) == WHOLE


def test_variables_are_parts_of_what_a_writer_writes() -> None:
    body = f"""w.StartObject(); AssertTrue(j.AddJsonKeyValueFromSymbol(w, 'recipe', {SYMBOL}), 'recipe');
    w.AddKey('n'); AssertTrue(j.AddJsonValueFromSymbol(w, 'INT', SIZEOF(n), ADR(n)), 'n'); w.EndObject();
    w.CopyDocument(s, SIZEOF(s));"""
    assert _of(_typed(body)) == {"recipe": WHOLE, "n": 5}


def test_what_is_read_changes_the_components_that_the_text_names() -> None:
    given = json.dumps(CHANGES)
    body = f"""s := '{given.replace("$", "$$")}'; AssertTrue(j.SetSymbolFromJson(s, {SYMBOL}), 'it is read');
    j.CopyJsonStringFromSymbol({SYMBOL}, s, SIZEOF(s));"""
    assert _of(_typed(body)) == CHANGED


@pytest.mark.parametrize(
    "text",
    [
        '{"On":true,"Count":40000}',
        '{"On":true,"Count":1.5}',
        '{"On":true,"Count":"1"}',
        '{"On":1}',
        '{"On":true,"b0":1}',
        '{"On":true,"Name":5}',
        '{"On":true,"Points":{}}',
        '{"On":true,"Points":[1]}',
        '{"On":true,"Baked":"yesterday"}',
        "[]",
        "5",
        "{",
        "",
    ],
)
def test_a_text_that_the_type_does_not_have_changes_nothing(text: str) -> None:
    body = f"""AssertFalse(j.SetSymbolFromJson('{text}', {SYMBOL}, hrErrorCode => e), 'refused');
    AssertTrue(FAILED(e), 'error'); j.CopyJsonStringFromSymbol({SYMBOL}, s, SIZEOF(s));"""
    assert _of(_typed(body)) == WHOLE


@pytest.mark.parametrize("symbol", ["'Nothing', SIZEOF(r), ADR(r)", "'Recipe', SIZEOF(r) - 1, ADR(r)", "'', 0, 0"])
def test_an_unknown_type_or_another_size_is_an_error(symbol: str) -> None:
    body = f"""AssertEquals_STRING('', j.GetJsonStringFromSymbol({symbol}), '');
    AssertFalse(j.AddJsonValueFromSymbol(w, {symbol}, hrErrorCode => e), 'added'); AssertTrue(FAILED(e), 'error');
    AssertEquals_UDINT(0, j.GetSizeJsonStringFromSymbol({symbol}), '');"""
    _typed(body)


def test_variables_have_the_names_of_their_addresses() -> None:
    body = """AssertEquals_STRING('Recipe', j.GetDatatypeNameByAddress(SIZEOF(r), ADR(r)), '');
    AssertEquals_STRING('PRG_TEST.s.r.Points[2].y', j.GetSymbolNameByAddress(4, ADR(r.Points[2].y)), '');
    AssertEquals_STRING('REAL', j.GetDatatypeNameByAddress(4, ADR(r.Points[2].y)), '');
    AssertEquals_STRING('', j.GetSymbolNameByAddress(3, ADR(r)), '');"""
    _typed(body)
