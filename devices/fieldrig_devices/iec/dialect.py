"""The language of source texts: that of EPAS-4, edition 3 of the standard, or what the tools of today accept.

Source: PacDrive manual 4.2 (digest 1.19, 2.2, 2.3 and section 4) for EPAS-4, which is a CoDeSys V2.3; IEC 61131-3:2013
for edition 3.  All of them have POINTER TO, ADR and ^, which the tools keep although the standard has REF_TO instead.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any, Final, Self

from fieldrig_devices.iec.elementary import UNSIGNED, Elementary


class Origin(Enum):
    """The origin of a rule.  A dialect is a set of origins, and what differs from them."""

    TODAY = "edition 3 of the standard, or most tools of today; both dialects of today have it"
    STANDARD = "edition 3 of the standard, and no tool of the CoDeSys family"
    TOOLS = "CODESYS V3 and TwinCAT"
    ANY_CODESYS = "CoDeSys V2.3, which EPAS-4 is, and its successors"


def _rule(origin: Origin, value: Any = True, *, otherwise: Any = False) -> Any:
    """Declare a rule that has `value` in the dialects of this origin."""
    return field(metadata={"origin": origin, "value": value, "otherwise": otherwise})


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Each permission that differs is one field, so a project can also mix them with `dataclasses.replace`."""

    name: str
    has_long_types: bool = _rule(Origin.TODAY)
    """LWORD, LINT and ULINT, with the size L of addresses (manual 691, X13), and edition 3's LTIME, LDATE, LTOD, LDT,
    CHAR and WCHAR."""
    has_wide_strings: bool = _rule(Origin.TODAY)
    """WSTRING, and its constants in double quotes."""
    has_power: bool = _rule(Origin.TODAY)
    """The operator ** (manual 1929: not supported)."""
    has_short_circuit: bool = _rule(Origin.TODAY)
    """AND_THEN and OR_ELSE."""
    has_continue: bool = _rule(Origin.TODAY)
    has_line_comments: bool = _rule(Origin.TODAY)
    """Comments from // to the end of the line, and from /* to */."""
    nests_comments: bool = _rule(Origin.TODAY)
    """(* (* *) *) is one comment (PD-362)."""
    reserves_configurations: bool = True
    """CONFIGURATION, RESOURCE and the words of charts are keywords; in a file of TwinCAT they may be names."""
    leaves_comments_open: bool = _rule(Origin.TOOLS)
    """A file whose comments do not nest up to its end is one of CoDeSys V2.3, where the first *) ends a comment."""
    has_conditional_code: bool = _rule(Origin.TOOLS)
    """`{IF defined (NAME)} ... {ELSE} ... {END_IF}` of CODESYS V3 and TwinCAT, and `{error 'text'}`."""
    has_enumeration_attributes: bool = _rule(Origin.TOOLS)
    """The attributes 'strict' and 'qualified_only' of CODESYS V3 and TwinCAT: such an enumeration takes its own values
    and their numbers alone, and these are known behind its name alone."""
    has_input_operators: bool = _rule(Origin.STANDARD)
    """In IL, inputs of the standard function blocks are operators: `CU counter` calls it with the accumulator as CU."""
    has_signed_long_times: bool = _rule(Origin.STANDARD)
    """LTIME#-5s; the LTIME of CODESYS and TwinCAT has no sign, and reaches twice as far."""
    has_jumps_in_st: bool = _rule(Origin.TODAY)
    """Labels and JMP in Structured Text.  No edition has them; today's tools do."""
    has_set_assignments: bool = _rule(Origin.TODAY)
    """`x S= y` and `x R= y` of today's tools."""
    has_references: bool = _rule(Origin.TODAY)
    """REFERENCE TO with REF= and __ISVALIDREF of today's tools, and the standard's REF_TO and REF."""
    has_unions: bool = _rule(Origin.TODAY)
    """TYPE name : UNION ... END_UNION of today's tools, whose components are at the same address."""
    has_methods: bool = _rule(Origin.TODAY)
    """METHOD and PROPERTY in function blocks and programs, with THIS^; EXTENDS of function blocks and structures, with
    SUPER^; INTERFACE, and IMPLEMENTS of function blocks."""
    has_classes: bool = _rule(Origin.STANDARD)
    """CLASS ... END_CLASS, with THIS and SUPER without ^.  Of the tools of today only those of the standard have it."""
    has_namespace_blocks: bool = _rule(Origin.STANDARD)
    """NAMESPACE ... END_NAMESPACE and USING.  Each name is known everywhere, with and without its namespace."""
    has_assignment_attempts: bool = _rule(Origin.STANDARD)
    """`a ?= b`: a variable of an interface refers to b if the instance implements the interface, else to NULL."""
    has_partial_access: bool = _rule(Origin.TODAY)
    """`w.%X3`, `w.%B1`, `d.%W0`: bits, bytes and words of a larger value (edition 3, 6.5.5)."""
    reads_locals: bool = _rule(Origin.TOOLS)
    """`x := inst.local`: variables of an instance can be read from outside, as CODESYS V3 allows."""
    writes_locals_of_its_kind: bool = _rule(Origin.TOOLS)
    """`other.count := 3` in a method, for a local variable of another instance of the same function block."""
    has_joined_words: bool = _rule(Origin.TOOLS)
    """FUNCTIONBLOCK for FUNCTION_BLOCK, which exports of CoDeSys V2.3 have."""
    indexes_pointers: bool = _rule(Origin.TOOLS)
    """`p[2]` is what is two elements behind the target of a pointer, and `s[0]` the first character of a string."""
    has_long_addresses: bool = _rule(Origin.TOOLS)
    """Pointers go into integers of 64 bits and back, `address : ULINT := ADR(x)`, as on the controllers of today."""
    has_characters_of_strings: bool = _rule(Origin.STANDARD)
    """`s[1]` is the first character of a string, a CHAR or WCHAR (edition 3, 6.4.2)."""
    has_static_variables: bool = _rule(Origin.TODAY)
    """VAR_STAT and VAR_INST, whose variables a function or method keeps between its calls."""
    fills_arrays: bool = _rule(Origin.TODAY)
    """An array may have fewer start values than elements; the others begin as usual (PD-361: all or none)."""
    has_open_arrays: bool = _rule(Origin.TODAY)
    """`ARRAY[*] OF INT` as an argument, with LOWER_BOUND and UPPER_BOUND (edition 3, 6.5.3)."""
    has_void_functions: bool = _rule(Origin.TODAY)
    """A FUNCTION without a type has no result, and is called for its effects (edition 3, 6.6.2)."""
    has_operator_calls: bool = _rule(Origin.STANDARD)
    """`AND(a, b, c)` and `MOD(a, b)`: keywords that are called like functions (edition 3, Std_Func_Name)."""
    has_enable: bool = _rule(Origin.STANDARD)
    """EN and ENO in calls of ST and IL, and ENO in bodies (edition 3, 6.6.1.5); today's tools draw them in networks."""
    has_edges: bool = _rule(Origin.STANDARD)
    """`VAR_INPUT start : BOOL R_EDGE;` (edition 3, 6.6.3.3)."""
    allows_time_fractions: bool = _rule(Origin.TODAY)
    """T#1.5s."""
    allows_negative_times: bool = _rule(Origin.STANDARD)
    """T#-5s, and a TIME with a sign (manual 2054: negative times are not defined; CODESYS has none either)."""
    allows_time_overflow: bool = _rule(Origin.TODAY)
    """T#2d_26h of manual line 731.  Otherwise only the highest unit may overflow (X9)."""
    allows_numbers_as_times: bool = False
    """A bare number as milliseconds, `PT := 300`.  No dialect allows it; a listing of the manual needs it (X29)."""
    mixes_integers: bool = _rule(Origin.ANY_CODESYS)
    """Integers and bit strings of the same size go into one another, and logic and arithmetic take both, as in CoDeSys
    V2.3.  Otherwise each value of the one type must be one of the other, and bit strings are no numbers."""
    computes_in_32_bits: bool = _rule(Origin.ANY_CODESYS)
    """Arithmetic with smaller integers has 32 bits, as on every 32-bit target of CoDeSys: `dint := int * int` keeps the
    whole product.  In edition 3 an operation has the type of its operands."""
    has_real_powers: bool = _rule(Origin.TOOLS)
    """EXPT of two integers is an LREAL where no integer is wanted, as in CODESYS V3 and TwinCAT."""
    rounds_halves_away: bool = _rule(Origin.TOOLS)
    """REAL_TO_INT(2.5) is 3 and that of -2.5 is -3, as CODESYS V3 and TwinCAT have it; otherwise the even neighbour."""
    has_chart_flags: bool = _rule(Origin.TOOLS)
    """Variables named SFCInit, SFCReset, SFCPause and so on, if the program declares them, steer its charts."""
    truncates_to_32_bits: bool = _rule(Origin.TOOLS)
    """TRUNC is a DINT where no integer is wanted, as in CODESYS V3 and TwinCAT; in CoDeSys V2.3 it is an INT."""
    allows_trailing_commas: bool = _rule(Origin.TODAY)
    """`Lamp(IN := a, PT := t,);`: a comma behind the last argument, which today's tools accept."""
    has_chained_assignments: bool = _rule(Origin.TOOLS)
    """`a := b := 3;` and `IF a := b = 3 THEN` of today's tools: an assignment is an expression, in brackets or as a
    condition."""
    allows_repeated_labels: bool = _rule(Origin.TOOLS, False, otherwise=True)
    """A label twice in a CASE, of which the first branch runs (edition 3, 7.3.3.3.3); CODESYS V3 and TwinCAT refuse it
    (C0216 to C0218)."""
    allows_empty_declarations: bool = _rule(Origin.TOOLS)
    """`a : INT;;`: a semicolon too many among declarations."""
    allows_open_addresses: bool = _rule(Origin.TOOLS)
    """`AT %I*` without an address in VAR_CONFIG is a variable without one, and inputs, outputs and components of
    structures may have AT, as in TwinCAT."""
    mixes_address_sizes: bool = _rule(Origin.TOOLS)
    """`AT %MB8 : REAL`: the address of the first byte of a variable of another size, also of a STRING."""
    has_local_instances: bool = _rule(Origin.TOOLS)
    """Functions and methods may have instances of function blocks, which get their start values in each call."""
    writes_parts_of_outputs: bool = _rule(Origin.TOOLS)
    """`inst.output.component := 3`: today's tools refuse only an assignment to the whole output."""
    has_name_spaces: bool = _rule(Origin.TOOLS)
    """Two named lists of global variables may have a variable of the same name, which is written `list.variable`."""
    has_constant_arguments: bool = _rule(Origin.TOOLS)
    """VAR_IN_OUT CONSTANT, to which constants and texts of any length may be passed, and which is only read;
    VAR_INPUT CONSTANT, which is an input; and VAR_OUTPUT CONSTANT, which others can read."""
    gives_open_arrays_as_addresses: bool = _rule(Origin.TOOLS)
    """An ARRAY[*] where a pointer is expected is its address, `MEMSET(destAddr := list, ...)`, as TwinCAT takes it."""
    has_any_inputs: bool = _rule(Origin.TOOLS)
    """`VAR_INPUT value : ANY`, which describes the variable that is passed; also ANY_NUM and so on."""
    has_system_names: bool = _rule(Origin.TOOLS)
    """Names that begin with two underscores, `__SYSTEM.TYPE_CLASS`, and two underscores between digits."""
    has_this_pointer: bool = _rule(Origin.TOOLS)
    """`p := THIS;`: THIS without ^ is a pointer to the instance."""
    has_windows_strings: bool = _rule(Origin.TOOLS)
    """A character of a STRING that Latin-1 does not have is its byte in Windows-1252, such as 80h for the euro sign."""
    writes_todays_texts: bool = _rule(Origin.TOOLS)
    """A DT becomes DT#2026-01-31-12:00:00 with its seconds, a TIME T#1h5s without units of 0, a large number 1.5E20."""
    has_heap: bool = _rule(Origin.TOOLS)
    """`__NEW` and `__DELETE`."""
    has_empty_arrays: bool = _rule(Origin.TOOLS)
    """`ARRAY[0..-1] OF INT` has no element, as `ARRAY[0..Count - 1]` with a constant Count of 0."""
    has_conditional_return: bool = _rule(Origin.TOOLS)
    """`RETURN (condition);` leaves the unit if the condition is TRUE."""
    has_exceptions: bool = _rule(Origin.TOOLS)
    """`__TRY ... __CATCH(code) ... __FINALLY ... __ENDTRY`: a program goes on after a fault of its own."""
    has_program_instances: bool = _rule(Origin.STANDARD)
    """Each PROGRAM of a configuration has its own variables; elsewhere a program exists once."""
    has_generic_constants: bool = _rule(Origin.TOOLS)
    """`VAR_GENERIC CONSTANT n : UDINT; END_VAR` in a function block, and `stack : Stack<10>;`."""
    has_bits: bool = _rule(Origin.TOOLS)
    """BIT: a component of a structure that has one bit of a byte; eight in a row have the same byte."""
    copies_blocks: bool = _rule(Origin.TOOLS)
    """`a := b` for instances of function blocks copies all variables; inputs and results may be instances too."""
    has_constructors: bool = _rule(Origin.TOOLS)
    """`motor : Motor(3);`: FB_init runs for each instance before the first cycle, with these arguments."""
    computes_starts: bool = _rule(Origin.TODAY)
    """Start values may be computed before the first cycle, from variables, references to them, and by functions."""
    has_calls_by_position: bool = _rule(Origin.TODAY)
    """`Lamp(a, T#5s);`: arguments of function blocks and programs, and outputs of functions, by their position."""
    allows_missing_inputs: bool = _rule(Origin.STANDARD)
    """`F(a := 1)`: a call of a function with names may leave out any input, which then has the start value of its
    declaration or type (edition 3, 6.6.1.4.2)."""
    has_address_levels: bool = _rule(Origin.TODAY)
    """`%QW2.5.7.1`: an address of several levels, of which the last one counts within the others (table 16)."""
    writes_inputs: bool = _rule(Origin.STANDARD)
    """A program may write variables at %I, as projects of Beremiz and OpenPLC that imitate their machine do."""
    allows_idle_tasks: bool = _rule(Origin.TODAY)
    """A task may name no program; it is left out (PD-033: it must)."""
    allows_changed_inputs: bool = _rule(Origin.TODAY)
    """A POU may change its own VAR_INPUT, as today's tools allow (manual table 4-6: it cannot)."""
    allows_calls_without_brackets: bool = _rule(Origin.ANY_CODESYS)
    """`Reset;` calls the action or program Reset, as in CoDeSys V2.3."""
    shares_names_with_types: bool = _rule(Origin.TODAY)
    """A global variable may have the name of a type or function block, `Pump : Pump;` (PD-357: it cannot)."""
    significant_characters: int = _rule(Origin.TODAY, 0, otherwise=32)
    """Names that agree in this many characters are the same name; 0 for all characters (PD-350)."""
    array_dimensions: int = 3
    """PD-361."""
    lowest_priority: int = _rule(Origin.TODAY, 65_535, otherwise=31)
    """The highest number of a task's priority: a UINT in the standard, 0 to 31 in EPAS-4 (PD-061)."""
    longest_string: int = _rule(Origin.TODAY, 32_767, otherwise=255)
    """The most characters of a STRING.  The functions for strings take and return at most 255 in any dialect."""
    has_documents: bool = _rule(Origin.TOOLS)
    """A STRING may have a million characters, such as a document of JSON in a program of TwinCAT."""
    has_empty_strings: bool = _rule(Origin.TOOLS)
    """STRING(0), which has its closing zero only; programs of TwinCAT have pointers to it, and empty constants."""
    has_typed_enumerations: bool = _rule(Origin.TODAY)
    """`(red, green) UINT` and `UINT (red, green)`: an enumeration may have another integer type than INT."""
    repeats_enumeration_values: bool = _rule(Origin.TODAY)
    """Two enumerations may have a value of the same name, of which the later one is written `Type.value`, and their
    numbers may have any order (manual 862 to 866, PD-359: they cannot)."""
    has_named_bits: bool = _rule(Origin.TOOLS)
    """`word.ready` is the bit with the number of the constant `ready`."""
    passes_alike: bool = _rule(Origin.TOOLS)
    """A `VAR_IN_OUT` of a bit string takes an unsigned integer of the same size, and the other way round."""
    passes_any_pointer: bool = _rule(Origin.TOOLS)
    """A `VAR_IN_OUT` of PVOID takes every pointer."""
    wraps_enumeration_values: bool = _rule(Origin.TOOLS)
    """A number of an enumeration that needs the sign bit of its type, `unknown := 65535`, is the negative number."""
    repeats_arguments: bool = _rule(Origin.TOOLS)
    """`Lamp(IN := a, PT := t, IN := b)`: of an argument that is given twice by its name, the last value counts."""
    opens_enumerations: bool = _rule(Origin.TOOLS)
    """A variable of an enumeration takes every number of its integer type, also in the text."""
    opens_subranges: bool = _rule(Origin.TOOLS)
    """At run time a variable of a subrange takes every number of its integer type: CODESYS V3 and TwinCAT compare with
    the limits in CheckRangeSigned and CheckRangeUnsigned alone, if the project has them."""
    allows_numbers_between: bool = _rule(Origin.TODAY)
    """At run time, a variable of an enumeration takes each number from its first to its last value (manual 846: the
    validity of the number is checked)."""
    bit_address_bytes: int = _rule(Origin.TODAY, 0, otherwise=4_096)
    """Single bits are addressed in the first bytes of an area only; 0 for the whole area."""

    @classmethod
    def of(cls, name: str, *origins: Origin, **differences: Any) -> Self:
        """Make a dialect with the rules of these origins, apart from the differences."""
        rules = {
            rule.name: rule.metadata["value" if rule.metadata["origin"] in origins else "otherwise"]
            for rule in fields(cls)
            if rule.metadata
        }
        return cls(name=name, **(rules | differences))

    @property
    def time(self) -> Elementary:
        """The TIME of the programs."""
        return Elementary.SIGNED_TIME if self.allows_negative_times else Elementary.TIME

    @property
    def long_time(self) -> Elementary:
        """The LTIME of the programs."""
        return self._long(Elementary.LTIME)

    def _long(self, kind: Elementary) -> Elementary:
        return kind if self.has_signed_long_times else UNSIGNED[kind]

    @property
    def durations(self) -> Mapping[Elementary, Elementary]:
        """The forms of TIME and of the long types in the programs."""
        return {Elementary.TIME: self.time, **{kind: self._long(kind) for kind in UNSIGNED}}

    def key(self, name: str) -> str:
        """Return what two spellings of the same name have in common."""
        folded = name.casefold()
        return folded[: self.significant_characters] if self.significant_characters else folded


EPAS_4: Final = Dialect.of("epas-4", Origin.ANY_CODESYS)
EDITION_3: Final = Dialect.of("edition-3", Origin.TODAY, Origin.STANDARD)
CODESYS: Final = Dialect.of("codesys", Origin.TODAY, Origin.ANY_CODESYS, Origin.TOOLS)
"""Programs and libraries of CoDeSys V2.3, CODESYS V3 and TwinCAT, which compute with bit strings."""
DIALECTS: Final[Mapping[str, Dialect]] = {dialect.name: dialect for dialect in (EPAS_4, EDITION_3, CODESYS)}
