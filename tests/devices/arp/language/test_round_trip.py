"""Reading any text raises nothing but mistakes; printing and reading any tree returns the same tree."""

from dataclasses import replace

import pytest
from arp_card import RecordedCard
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.coverage.marks import HIT
from fieldrig_devices.arp.language import tree
from fieldrig_devices.arp.language.compiler import Compiled, compile_text
from fieldrig_devices.arp.language.instructions import KEYWORDS, SIGNATURES, Value
from fieldrig_devices.arp.language.lower import NAMES
from fieldrig_devices.arp.language.parser import parse
from fieldrig_devices.arp.language.printer import line_text, routine_lines
from fieldrig_devices.arp.runtime.program import ArpProgram
from fieldrig_devices.languages.mistakes import CompileError, Mistake
from fieldrig_devices.languages.writer import Build

WORDS = [
    *sorted(KEYWORDS), "ON1", "ON6", "ON7", "CAM3", "V1", "V1000", "V1001", "F1", "F262", "F320", "I101", "O104",
    "V[V1]", "F[V2]", "I[A]", "@POS1", "#VEL2", "@PAR1[4]", "@PAR[1]", "@FLAG9", "@OUT1", "#INP3", "HFF", "A", "B",
    "==", "=", "+=", "<<=", "<", ">", "<>", "<=", "+", "-", "*", "/", "\\", "%", "&", "|", "^", "!", "<<", ">>",
    "(", ")", ",", ":", ";", '"x"', '"', "0", "1", "2", "0.5", "999999.999", "\n", "\n", "§", "BEG M", "END", "ENDA",
]  # fmt: skip
SOUP = st.lists(st.sampled_from(WORDS), max_size=60).map(" ".join)
FRAMED = SOUP.map(lambda soup: f"A EQU V5\nBEG M\n{soup}\nB:\nEND\nBEGA IRQ\nENDA")
HEAVY = settings(max_examples=150, deadline=None)
HEAVIER = settings(max_examples=40, deadline=None)


def compiled_or_mistakes(text: str) -> Compiled | list[Mistake]:
    try:
        return compile_text(text)
    except CompileError as wrong:
        return wrong.mistakes


@pytest.mark.long
@HEAVY
@given(text=st.one_of(st.text(), SOUP, FRAMED))
def test_any_text_gives_a_program_or_mistakes(text: str) -> None:
    found = compiled_or_mistakes(text)
    if isinstance(found, Compiled):
        ArpProgram(found, RecordedCard()).code.compile()
    else:
        assert any(not mistake.is_note for mistake in found)
        assert all(mistake.line >= 1 and mistake.column >= 1 and mistake.what for mistake in found)


@pytest.mark.long
@HEAVIER
@given(lines=st.lists(st.lists(st.sampled_from(WORDS[:-8]), min_size=1, max_size=8).map(" ".join), max_size=30))
def test_what_compiles_is_python_that_the_sandbox_takes(lines: list[str]) -> None:
    good = [line for line in lines if compiles(line)]
    compiled = compile_text(framed(good))
    code = ArpProgram(compiled, RecordedCard()).code
    assert set(code.names) == NAMES | {HIT}
    for build in Build:
        code.compile(build)  # ForbiddenPythonError if not


def framed(lines: list[str]) -> str:
    return "\n".join(["A EQU V5", "BEG M", *lines, "B:", "END", "BEGA IRQ", "ENDA"])


def compiles(line: str) -> bool:
    if "\n" in line or ":" in line or "EQU" in line:
        return False
    return isinstance(compiled_or_mistakes(framed([line])), Compiled)


# ---- trees

NAME = st.from_regex(r"[A-Z][A-Z0-9_]{2,8}", fullmatch=True).filter(
    lambda text: text not in KEYWORDS and not text.startswith(("H", "V", "F", "I", "O", "CAM"))
)
DIGITS = st.integers(0, 9_999)
NUMBER = st.one_of(
    st.integers(0, 999_999_999).map(tree.Number),
    st.builds(tree.Number, st.integers(-(2**31), 2**31 - 1), st.just(True)),
)
NAMED = NAME.map(tree.Name)
DIRECT = st.builds(tree.Direct, st.sampled_from("VFIO"), DIGITS)
INDEXED = st.builds(
    tree.Indexed, st.sampled_from("VFIO"), st.one_of(st.builds(tree.Direct, st.just("V"), DIGITS), NAMED)
)
SYSTEM = st.one_of(
    st.builds(tree.System, st.sampled_from(["@POS", "#VEL", "#LQOSP", "#LQOSN", "@FLAG", "@OUT", "#INP"]), DIGITS),
    st.builds(tree.System, st.just("@PAR"), st.one_of(st.none(), st.integers(0, 9)), DIGITS),
)
RESOURCE: st.SearchStrategy[tree.Resource] = st.one_of(NAMED, DIRECT, INDEXED, SYSTEM)
ATOM: st.SearchStrategy[tree.Expression] = st.one_of(
    NUMBER, RESOURCE, st.sampled_from(["PIG", "HI", "LO", "ON", "OFF"]).map(tree.Constant)
)
EXPRESSION: st.SearchStrategy[tree.Expression] = st.recursive(
    ATOM,
    lambda inner: st.one_of(
        st.builds(tree.Unary, st.sampled_from("-+!"), inner),
        st.builds(tree.Binary, st.sampled_from(["|", "^", "&", "<<", ">>", "+", "-", "*", "/", "%"]), inner, inner),
        st.builds(tree.Function, st.sampled_from(["SQR", "INT", "SEN", "COS"]), inner),
    ),
    max_leaves=6,
)
TEXT = st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters='"'), max_size=16).map(tree.Text)
VALUES: dict[Value, st.SearchStrategy[tree.Argument]] = {
    Value.TEXT: TEXT,
    Value.MODE: st.sampled_from("EP").map(tree.Mode),
}


@st.composite
def commands(draw: st.DrawFn) -> tree.Command:
    signature = draw(st.sampled_from(sorted(SIGNATURES.values(), key=lambda signature: signature.word)))
    count = draw(st.sampled_from(signature.counts or (len(signature.values),)))
    number = draw(st.integers(1, 6)) if signature.word in ("ON", "CAM") else None
    arguments = tuple(draw(VALUES.get(value, EXPRESSION)) for value in signature.values[:count])
    return tree.Command(signature.word, arguments, number)


SIMPLE: st.SearchStrategy[tree.Statement] = st.one_of(
    commands(),
    st.builds(
        tree.Assign, RESOURCE, st.sampled_from(["==", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>="]),
        EXPRESSION,
    ),
    st.builds(tree.Assign, RESOURCE, st.just("=="), st.builds(tree.Read, st.sampled_from(["ADC", "TIM"]), EXPRESSION)),
    st.builds(tree.Assign, RESOURCE, st.just("=="), st.builds(tree.Read, st.sampled_from(["ERROR", "WARNING"]))),
    st.builds(tree.Goto, NAME),
    st.builds(tree.Call, NAME),
    st.builds(
        tree.OnEvent, st.integers(1, 6), RESOURCE,
        st.one_of(
            st.builds(tree.BitCondition, st.sampled_from(["", "!", "/", "\\"]), RESOURCE),
            st.builds(tree.PositionCondition, st.one_of(NUMBER, NAMED), st.sampled_from("<>"), RESOURCE),
        ),
        NAME,
    ),
)  # fmt: skip
STATEMENT: st.SearchStrategy[tree.Statement] = st.recursive(
    SIMPLE,
    lambda inner: st.builds(
        tree.If,
        EXPRESSION,
        st.sampled_from(["=", "<>", "<", ">", "<=", ">="]),
        EXPRESSION,
        st.one_of(inner, st.builds(tree.Goto, NAME, st.just(True))),
    ),
    max_leaves=2,
)
EQU = st.builds(tree.Equ, NAME, st.one_of(RESOURCE, NUMBER))
LINE = st.builds(
    tree.Line, st.just(0), st.one_of(st.none(), NAME), st.one_of(STATEMENT, STATEMENT, EQU)
).filter(lambda line: len(line_text(line)) <= 120)  # fmt: skip
ROUTINE = st.builds(
    tree.Routine, NAME, st.booleans(), st.lists(LINE, max_size=5).map(tuple), st.just(0), st.just(0)
)  # fmt: skip
PROGRAM = st.builds(
    tree.Program,
    st.tuples(ROUTINE.map(lambda routine: replace(routine, is_interrupt=False)), ROUTINE),
    st.lists(EQU.map(lambda equ: tree.Line(0, None, equ)), max_size=3).map(tuple),
)


@HEAVY
@given(program=PROGRAM)
@pytest.mark.long
def test_a_printed_program_is_read_as_the_same_program(program: tree.Program) -> None:
    lines = [line_text(line) for line in program.outside]
    lines += [text for routine in program.routines for _, text in routine_lines(routine)]
    assert parse("".join(f"{line}\n" for line in lines)) == (program, [])
