"""Random trees of IEC source text, for property tests of whatever reads or writes them."""

from dataclasses import replace
from typing import TypeVar

from hypothesis import strategies as st

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.instructions import BRACKETS
from fieldrig_devices.iec.parser.expressions import RANKS
from fieldrig_devices.iec.tokens import keywords
from fieldrig_devices.iec.tree import LiteralKind

T = TypeVar("T")


def many(of: st.SearchStrategy[T], least: int = 0, most: int = 3) -> st.SearchStrategy[tuple[T, ...]]:
    return st.lists(of, min_size=least, max_size=most).map(tuple)


_WORDS = st.from_regex(r"[A-Za-z][a-z0-9]{0,5}(_[a-z0-9]{1,3})?", fullmatch=True)
_NOT_NAMES = keywords(EDITION_3) | {"T", "D", "TIME", "STEP", "TASK", "FROM", "JMP", "STRING"}
NAMES = st.one_of(st.sampled_from(["a", "b", "axis", "i_count", "S", "R", "LD", "End", "EN", "ENO"]), _WORDS).filter(
    lambda name: name.upper() not in _NOT_NAMES
)
PLAIN_NAMES = NAMES.filter(lambda name: name not in ("S", "R", "LD"))
_LATIN = st.characters(codec="latin-1")
_NUMBERS = st.builds(tree.Literal, st.just(LiteralKind.INTEGER), st.integers(0, 2**64 - 1))
_DAYS = st.integers(0, 49_709).map(lambda days: days * 86_400)

LITERALS = st.one_of(
    st.builds(tree.Literal, st.just(LiteralKind.BOOL), st.booleans()),
    _NUMBERS,
    st.builds(
        tree.Literal,
        st.just(LiteralKind.INTEGER),
        st.integers(-(2**31), 2**31),
        type_name=st.sampled_from(["INT", "DINT", "BYTE", "WORD"]),
    ),
    st.builds(tree.Literal, st.just(LiteralKind.REAL), st.floats(0, allow_infinity=False)),
    st.builds(tree.Literal, st.just(LiteralKind.STRING), st.text(_LATIN, max_size=8)),
    st.builds(tree.Literal, st.just(LiteralKind.TIME), st.integers(0, 2**31 - 1)),
    st.builds(tree.Literal, st.just(LiteralKind.DATE), _DAYS),
    st.builds(tree.Literal, st.just(LiteralKind.TOD), st.integers(0, 86_399_999)),
    st.builds(tree.Literal, st.just(LiteralKind.DT), st.integers(0, 2**32 - 1)),
)
DIRECTS = st.builds(
    tree.Direct, st.sampled_from("IQM"), st.sampled_from(["", "X", "B", "W", "D"]), many(st.integers(0, 999), 1, 3)
)
_LEAVES = st.one_of(NAMES.map(tree.Name), LITERALS, DIRECTS)


_CALLED = st.one_of(NAMES.map(tree.Name), st.builds(tree.Member, NAMES.map(tree.Name), NAMES))


def _arguments(of: st.SearchStrategy[tree.Expression]) -> st.SearchStrategy[tree.Argument]:
    return st.one_of(
        st.builds(tree.Argument, of),
        st.builds(tree.Argument, of, NAMES),
        st.builds(tree.Argument, st.none() | of, NAMES, st.just(True), st.booleans()),
    )


def _places(of: st.SearchStrategy[tree.Expression]) -> st.SearchStrategy[tree.Expression]:
    return st.one_of(
        st.builds(tree.Member, of, NAMES),
        st.builds(tree.BitOf, of, st.integers(0, 31)),
        st.builds(tree.Index, of, many(of, 1)),
        st.builds(tree.Dereference, of),
        st.builds(tree.Call, _CALLED, many(_arguments(of))),
    )


def _more(of: st.SearchStrategy[tree.Expression]) -> st.SearchStrategy[tree.Expression]:
    return st.one_of(
        st.builds(tree.Binary, st.sampled_from([sign for sign in RANKS if sign != "&"]), of, of),
        st.builds(tree.Unary, st.sampled_from(["-", "+", "NOT"]), of),
        _places(of),
    )


EXPRESSIONS: st.SearchStrategy[tree.Expression] = st.recursive(_LEAVES, _more, max_leaves=8)
_NAMED: st.SearchStrategy[tree.Expression] = NAMES.map(tree.Name)
_VARIABLES: st.SearchStrategy[tree.Expression] = st.recursive(
    _NAMED,
    lambda of: st.one_of(
        st.builds(tree.Member, of, NAMES),
        st.builds(tree.Index, of, many(EXPRESSIONS, 1, 2)),
        st.builds(tree.Dereference, of),
    ),
    max_leaves=3,
)
PLACES = st.one_of(_VARIABLES, st.builds(tree.BitOf, _VARIABLES, st.integers(0, 31)))

# ---- statements

_COMMENT = st.text(st.sampled_from("ab c\n*x"), max_size=8).map(lambda text: f"(* {text.replace('*', ':')} *)")
_REMARKS = st.just("") | _COMMENT
_COMMENTS = many(_COMMENT, 0, 1)
_EXTRAS = {"comments": _COMMENTS, "remark": _REMARKS, "is_spaced": st.booleans()}
_CALLS = st.builds(tree.Call, _VARIABLES, many(_arguments(EXPRESSIONS)))
_SIMPLE = st.one_of(
    st.builds(tree.Assign, PLACES, EXPRESSIONS, st.sampled_from(tree.AssignKind), **_EXTRAS),
    st.builds(tree.Assign, DIRECTS, EXPRESSIONS, others=many(PLACES), **_EXTRAS),
    st.builds(tree.CallStatement, _CALLS, **_EXTRAS),
    *(st.builds(kind, **_EXTRAS) for kind in (tree.Return, tree.Exit, tree.Continue, tree.Empty)),
    st.builds(tree.Jump, PLAIN_NAMES),
)
_LABELS = st.one_of(_NUMBERS, PLAIN_NAMES.map(tree.Name), st.builds(tree.Range, _NUMBERS, _NUMBERS))


def _compound(of: st.SearchStrategy[tree.AnyStatement]) -> st.SearchStrategy[tree.AnyStatement]:
    block = many(of)
    branches = many(st.builds(tree.Branch, EXPRESSIONS, block, remark=_REMARKS), 1, 2)
    cases = many(
        st.builds(
            tree.CaseBranch, many(_LABELS, 1, 2), block, comments=_COMMENTS, remark=_REMARKS, is_spaced=st.booleans()
        ),
        1,
        2,
    )
    return st.one_of(
        st.builds(tree.If, branches, st.none() | block, **_EXTRAS),
        st.builds(tree.Case, EXPRESSIONS, cases, st.none() | block, **_EXTRAS),
        st.builds(tree.For, PLACES, EXPRESSIONS, EXPRESSIONS, st.none() | EXPRESSIONS, block, **_EXTRAS),
        st.builds(tree.While, EXPRESSIONS, block, **_EXTRAS),
        st.builds(tree.Repeat, block, EXPRESSIONS, **_EXTRAS),
    )


STATEMENTS: st.SearchStrategy[tree.AnyStatement] = st.recursive(_SIMPLE, _compound, max_leaves=5)
ST_BODIES = st.builds(tree.StBody, many(STATEMENTS))

# ---- Instruction List

_OPERANDS = st.one_of(PLACES, LITERALS, DIRECTS)
_LABEL = st.just("") | PLAIN_NAMES
_IL_SIMPLE = st.one_of(
    st.builds(
        tree.IlInstruction,
        st.sampled_from(["LD", "ST", "AND"]),
        many(_OPERANDS, 1, 1),
        _LABEL,
        st.booleans(),
        **_EXTRAS,
    ),
    st.builds(tree.IlInstruction, st.sampled_from(["ADD", "MUL", "EQ"]), many(_OPERANDS, 1), _LABEL, **_EXTRAS),
    st.builds(tree.IlInstruction, st.sampled_from(["LIMIT", "INT_TO_REAL"]), many(_OPERANDS), **_EXTRAS),
    st.builds(tree.IlInstruction, st.just("NOT"), label=_LABEL, **_EXTRAS),
    st.builds(lambda name: tree.IlInstruction("JMP", (name,), is_conditional=True), PLAIN_NAMES.map(tree.Name)),
    st.builds(lambda call, no: tree.IlInstruction("CAL", (call,), "", no, True), _CALLS, st.booleans()),
    st.builds(lambda no: tree.IlInstruction("RET", (), "", no, True), st.booleans()),
)


def _deferring(of: st.SearchStrategy[tree.IlInstruction]) -> st.SearchStrategy[tree.IlInstruction]:
    load = st.builds(tree.IlInstruction, st.just("LD"), many(_OPERANDS, 1, 1), is_negated=st.booleans())
    deferred = st.builds(lambda first, rest: (first, *rest), load, many(of))
    return st.builds(tree.IlInstruction, st.sampled_from(sorted(BRACKETS)), label=_LABEL, deferred=deferred, **_EXTRAS)


INSTRUCTIONS: st.SearchStrategy[tree.IlInstruction] = st.recursive(_IL_SIMPLE, _deferring, max_leaves=4)
_LOADS = st.builds(tree.IlInstruction, st.just("LD"), many(_OPERANDS, 1, 1), _LABEL, st.booleans())
IL_BODIES = st.builds(lambda first, rest: tree.IlBody((first, *rest)), _LOADS, many(INSTRUCTIONS))

# ---- charts

_USES = st.one_of(
    st.builds(
        tree.ActionUse,
        PLAIN_NAMES,
        st.sampled_from(["N", "R", "S", "P", "P0", "P1"]),
        st.none(),
        many(PLAIN_NAMES, 0, 2),
    ),
    st.builds(
        tree.ActionUse, PLAIN_NAMES, st.sampled_from(["L", "D", "SD", "DS", "SL"]), EXPRESSIONS, many(PLAIN_NAMES, 0, 2)
    ),
)
_SECTIONS = st.none() | ST_BODIES | IL_BODIES
_STEPS = st.builds(
    tree.Step, PLAIN_NAMES, st.booleans(), many(_USES), _SECTIONS, _SECTIONS, _SECTIONS, comments=_COMMENTS
)
_ENDS = many(PLAIN_NAMES, 1, 2)
_TRANSITIONS = st.builds(
    tree.Transition, _ENDS, _ENDS, EXPRESSIONS, st.just("") | PLAIN_NAMES, st.integers(0, 9), comments=_COMMENTS
)
CHARTS = st.builds(tree.SfcBody, many(_STEPS, 1, 2), many(_TRANSITIONS, 0, 2))
BODIES = st.one_of(ST_BODIES, IL_BODIES, CHARTS, st.just(tree.NativeBody()))

# ---- declarations

_DIMENSIONS = many(st.builds(tree.Range, EXPRESSIONS, EXPRESSIONS), 1)
_NAMED_TYPES = st.one_of(
    st.sampled_from(["INT", "BOOL", "REAL", "TON"]).map(tree.NamedType), PLAIN_NAMES.map(tree.NamedType)
)
_SMALL_TYPES = st.one_of(
    _NAMED_TYPES,
    st.builds(tree.StringSpec, st.none() | EXPRESSIONS),
    st.builds(tree.SubrangeSpec, _NAMED_TYPES, EXPRESSIONS, EXPRESSIONS),
    st.builds(
        tree.EnumSpec,
        many(st.builds(tree.EnumValue, PLAIN_NAMES, st.none() | EXPRESSIONS, comments=_COMMENTS), 1),
        st.sampled_from(["", "UINT", "LWORD"]),
    ),
)


def _initials_of(of: st.SearchStrategy[tree.Initial]) -> st.SearchStrategy[tree.Initial]:
    repeated = st.builds(tree.Repeated, _NUMBERS, of)
    return st.one_of(
        st.builds(tree.ArrayInitial, many(of | repeated)),
        st.builds(tree.StructInitial, many(st.builds(tree.FieldInitial, PLAIN_NAMES, of), 1)),
    )


INITIALS: st.SearchStrategy[tree.Initial] = st.recursive(EXPRESSIONS, _initials_of, max_leaves=4)
_ARRAY_INITIALS = st.builds(tree.ArrayInitial, many(INITIALS))


def _variables_of(types: st.SearchStrategy[tree.TypeSpec]) -> st.SearchStrategy[tree.Variable]:
    """Variables; an array starts with a list, because a single value in its place is read as a list of one."""
    return types.flatmap(
        lambda spec: st.builds(
            tree.Variable,
            PLAIN_NAMES,
            st.just(spec),
            st.none() | (_ARRAY_INITIALS if isinstance(spec, tree.ArraySpec) else INITIALS),
            st.none() | DIRECTS,
            **_EXTRAS,
        )
    )


TYPES: st.SearchStrategy[tree.TypeSpec] = st.recursive(
    _SMALL_TYPES,
    lambda of: st.one_of(
        st.builds(tree.ArraySpec, _DIMENSIONS, of),
        st.builds(tree.OpenArraySpec, st.integers(1, 3), of),
        st.builds(tree.PointerSpec, of, st.booleans()),
        st.builds(tree.StructSpec, many(_variables_of(of)), st.booleans()),
    ),
    max_leaves=3,
)
_FLAGS = {
    "is_retain": st.booleans(),
    "is_persistent": st.booleans(),
    "is_constant": st.booleans(),
    "access": st.sampled_from(["", "PUBLIC", "PRIVATE"]),
}
_OF_OTHERS = (tree.Section.CONFIG, tree.Section.GENERIC)
"""Sections that a POU of edition 3 does not have."""
_SECTION_KINDS = st.sampled_from([section for section in tree.Section if section not in _OF_OTHERS])
VARIABLES = st.builds(tree.Variables, _SECTION_KINDS, many(_variables_of(TYPES)), comments=_COMMENTS, **_FLAGS)
_GLOBALS = st.builds(tree.Variables, st.just(tree.Section.GLOBAL), many(_variables_of(TYPES)), **_FLAGS)
_PATHS = st.builds("{}.{}".format, PLAIN_NAMES, PLAIN_NAMES)
_CONFIGS = st.builds(
    tree.Variables,
    st.just(tree.Section.CONFIG),
    many(st.builds(tree.Variable, _PATHS, _NAMED_TYPES, st.none(), DIRECTS)),
)
_ACTIONS = st.builds(tree.Action, PLAIN_NAMES, st.one_of(ST_BODIES, IL_BODIES, CHARTS), comments=_COMMENTS)


_METHODS = st.builds(
    tree.Method,
    PLAIN_NAMES,
    st.none() | TYPES.filter(lambda spec: not isinstance(spec, tree.StructSpec)),
    many(VARIABLES, 0, 1),
    st.one_of(ST_BODIES, IL_BODIES),
    st.sampled_from([(), ("PUBLIC",), ("PROTECTED", "FINAL")]),
    comments=_COMMENTS,
)


_ACCESSORS = st.builds(
    tree.Method,
    PLAIN_NAMES,
    TYPES.filter(lambda spec: not isinstance(spec, tree.StructSpec)),
    many(VARIABLES, 0, 1),
    st.one_of(ST_BODIES, IL_BODIES),
    st.sampled_from([(), ("PUBLIC",)]),
    st.sampled_from(["GET", "SET"]),
    comments=_COMMENTS,
)


def _pous_of(kind: tree.PouKind) -> st.SearchStrategy[tree.Pou]:
    result = TYPES.filter(lambda spec: not isinstance(spec, tree.StructSpec))
    return st.builds(
        tree.Pou,
        st.just(kind),
        PLAIN_NAMES,
        result if kind is tree.PouKind.FUNCTION else st.none(),
        many(VARIABLES, 0, 2),
        BODIES,
        many(_ACTIONS, 0, 1),
        many(_METHODS | _ACCESSORS, 0, 3),
        st.just("") | PLAIN_NAMES if kind.has_instances else st.just(""),
        comments=_COMMENTS,
    )


def _typed(spec: tree.TypeSpec) -> st.SearchStrategy[tree.TypeDeclaration]:
    initials = _ARRAY_INITIALS if isinstance(spec, tree.ArraySpec) else INITIALS
    return st.builds(tree.TypeDeclaration, PLAIN_NAMES, st.just(spec), st.none() | initials, comments=_COMMENTS)


_SETTING = st.none() | EXPRESSIONS
_CONFIGURATIONS = st.builds(
    tree.Configuration,
    PLAIN_NAMES,
    many(_GLOBALS, 0, 1),
    many(st.builds(tree.TaskDeclaration, PLAIN_NAMES, _SETTING, _SETTING, _SETTING)),
    many(st.builds(tree.ProgramInstance, PLAIN_NAMES, st.just("") | PLAIN_NAMES, PLAIN_NAMES)),
    st.just("") | PLAIN_NAMES,
)
_INTERFACES = st.builds(
    tree.Interface,
    PLAIN_NAMES,
    many(PLAIN_NAMES, 0, 2),
    many((_METHODS | _ACCESSORS).map(lambda method: replace(method, body=tree.StBody(()))), 0, 2),
    comments=_COMMENTS,
)
DECLARATIONS = st.one_of(
    _INTERFACES,
    st.sampled_from(tree.PouKind).flatmap(_pous_of),
    TYPES.flatmap(_typed),
    _GLOBALS,
    _CONFIGS,
    _CONFIGURATIONS,
)
UNITS = st.builds(tree.Unit, st.just("random.st"), many(DECLARATIONS, 0, 2), _COMMENTS)
