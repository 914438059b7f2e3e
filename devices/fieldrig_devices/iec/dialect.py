"""The language of source texts: that of EPAS-4, edition 3 of the standard, or what the tools of today accept.

Source: PacDrive manual 4.2 (digest 1.19, 2.2, 2.3 and section 4) for EPAS-4, which is a CoDeSys V2.3; IEC 61131-3:2013
for edition 3.  Each permission that differs is one field, so a project can also mix them with `dataclasses.replace`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from fieldrig_devices.iec.elementary import Elementary


@dataclass(frozen=True, slots=True)
class Dialect:
    """The defaults are those of EPAS-4."""

    name: str
    has_long_types: bool = False
    """LWORD, LINT and ULINT, with the size L of addresses (manual 691, X13), and edition 3's LTIME, LDATE, LTOD, LDT,
    CHAR and WCHAR."""
    has_wide_strings: bool = False
    """WSTRING, and its constants in double quotes."""
    has_power: bool = False
    """The operator ** (manual 1929: not supported)."""
    has_short_circuit: bool = False
    """AND_THEN and OR_ELSE."""
    has_continue: bool = False
    has_line_comments: bool = False
    """Comments from // to the end of the line, and from /* to */."""
    nests_comments: bool = False
    """(* (* *) *) is one comment (PD-362)."""
    leaves_comments_open: bool = False
    """A file whose comments do not nest up to its end is one of CoDeSys V2.3, where the first *) ends a comment."""
    has_jumps_in_st: bool = False
    """Labels and JMP in Structured Text.  No edition has them; today's tools do."""
    has_set_assignments: bool = False
    """`x S= y` and `x R= y` of today's tools."""
    has_pointers: bool = True
    """POINTER TO, ADR and ^.  The standard has REF_TO instead; today's tools keep pointers, so both dialects do."""
    has_references: bool = False
    """REFERENCE TO with REF= and __ISVALIDREF of today's tools, and the standard's REF_TO and REF."""
    has_unions: bool = False
    """TYPE name : UNION ... END_UNION of today's tools, whose components are at the same address."""
    has_methods: bool = False
    """METHOD and PROPERTY in function blocks and programs, with THIS^; EXTENDS of function blocks and structures, with
    SUPER^; INTERFACE, and IMPLEMENTS of function blocks."""
    has_classes: bool = False
    """CLASS ... END_CLASS, with THIS and SUPER without ^.  Of the tools of today only those of the standard have it."""
    has_namespace_blocks: bool = False
    """NAMESPACE ... END_NAMESPACE and USING.  Each name is known everywhere, with and without its namespace."""
    has_assignment_attempts: bool = False
    """`a ?= b`: a variable of an interface refers to b if the instance implements the interface, else to NULL."""
    has_partial_access: bool = False
    """`w.%X3`, `w.%B1`, `d.%W0`: bits, bytes and words of a larger value (edition 3, 6.5.5)."""
    reads_locals: bool = False
    """`x := inst.local`: variables of an instance can be read from outside, as CODESYS V3 allows."""
    indexes_pointers: bool = False
    """`p[2]` is what is two elements behind the target of a pointer, and `s[0]` the first character of a string."""
    has_characters_of_strings: bool = False
    """`s[1]` is the first character of a string, a CHAR or WCHAR (edition 3, 6.4.2)."""
    has_static_variables: bool = False
    """VAR_STAT and VAR_INST, whose variables a function or method keeps between its calls."""
    fills_arrays: bool = False
    """An array may have fewer start values than elements; the others begin as usual (PD-361: all or none)."""
    has_open_arrays: bool = False
    """`ARRAY[*] OF INT` as an argument, with LOWER_BOUND and UPPER_BOUND (edition 3, 6.5.3)."""
    has_void_functions: bool = False
    """A FUNCTION without a type has no result, and is called for its effects (edition 3, 6.6.2)."""
    has_operator_calls: bool = False
    """`AND(a, b, c)` and `MOD(a, b)`: keywords that are called like functions (edition 3, Std_Func_Name)."""
    has_enable: bool = False
    """EN and ENO in calls of ST and IL, and ENO in bodies (edition 3, 6.6.1.5); today's tools draw them in networks."""
    has_edges: bool = False
    """`VAR_INPUT start : BOOL R_EDGE;` (edition 3, 6.6.3.3)."""
    allows_time_fractions: bool = False
    """T#1.5s."""
    allows_negative_times: bool = False
    """T#-5s, and a TIME with a sign (manual 2054: negative times are not defined; CODESYS has none either)."""

    allows_time_overflow: bool = False
    """T#2d_26h of manual line 731.  Otherwise only the highest unit may overflow (X9)."""
    allows_numbers_as_times: bool = False
    """A bare number as milliseconds, `PT := 300` (X29)."""
    mixes_integers: bool = True
    """Integers and bit strings of the same size go into one another, and logic and arithmetic take both, as in CoDeSys
    V2.3.  Otherwise each value of the one type must be one of the other, and bit strings are no numbers."""
    computes_in_32_bits: bool = True
    """Arithmetic with smaller integers has 32 bits, as on every 32-bit target of CoDeSys: `dint := int * int` keeps the
    whole product.  In edition 3 an operation has the type of its operands."""
    has_real_powers: bool = False
    """EXPT of two integers is an LREAL where no integer is wanted, as in CODESYS V3 and TwinCAT."""
    allows_trailing_commas: bool = False
    """`Lamp(IN := a, PT := t,);`: a comma behind the last argument, which today's tools accept."""
    has_chained_assignments: bool = False
    """`a := b := 3;` of today's tools."""
    allows_empty_declarations: bool = False
    """`a : INT;;`: a semicolon too many among declarations."""
    allows_open_addresses: bool = False
    """`AT %I*` without an address in VAR_CONFIG is a variable without one, and inputs, outputs and components of
    structures may have AT, as in TwinCAT."""
    mixes_address_sizes: bool = False
    """`AT %MB8 : REAL`: the address of the first byte of a variable of another size, also of a STRING."""
    has_local_instances: bool = False
    """Functions and methods may have instances of function blocks, which get their start values in each call."""
    writes_parts_of_outputs: bool = False
    """`inst.output.component := 3`: today's tools refuse only an assignment to the whole output."""
    has_name_spaces: bool = False
    """Two named lists of global variables may have a variable of the same name, which is written `list.variable`."""
    has_constant_arguments: bool = False
    """VAR_IN_OUT CONSTANT, to which constants and texts of any length may be passed, and which is only read; and
    VAR_INPUT CONSTANT, which is an input."""
    has_constructors: bool = False
    """`motor : Motor(3);`: FB_init runs for each instance before the first cycle, with these arguments."""
    computes_starts: bool = False
    """Start values may be computed before the first cycle, from variables, references to them, and by functions."""
    has_calls_by_position: bool = False
    """`Lamp(a, T#5s);`: arguments of function blocks and programs, and outputs of functions, by their position."""
    allows_missing_inputs: bool = False
    """`F(a := 1)`: a call of a function with names may leave out any input, which then has the start value of its
    declaration or type (edition 3, 6.6.1.4.2)."""
    has_address_levels: bool = False
    """`%QW2.5.7.1`: an address of several levels, of which the last one counts within the others (table 16)."""
    allows_idle_tasks: bool = False
    """A task may name no program; it is left out (PD-033: it must)."""
    allows_changed_inputs: bool = False
    """A POU may change its own VAR_INPUT, as today's tools allow (manual table 4-6: it cannot)."""
    allows_calls_without_brackets: bool = True
    """`Reset;` calls the action or program Reset, as in CoDeSys V2.3."""
    shares_names_with_types: bool = False
    """A global variable may have the name of a type or function block, `Pump : Pump;` (PD-357: it cannot)."""
    significant_characters: int = 32
    """Names that agree in this many characters are the same name; 0 for all characters (PD-350)."""
    array_dimensions: int = 3
    """PD-361."""
    longest_string: int = 255
    """The most characters of a STRING.  The functions for strings take and return at most 255 in any dialect."""
    has_typed_enumerations: bool = False
    """`(red, green) UINT` and `UINT (red, green)`: an enumeration may have another integer type than INT."""
    repeats_enumeration_values: bool = False
    """Two enumerations may have a value of the same name, of which the later one is written `Type.value`, and their
    numbers may have any order (manual 862 to 866, PD-359: they cannot)."""
    allows_numbers_between: bool = False
    """At run time, a variable of an enumeration takes each number from its first to its last value (manual 846: the
    validity of the number is checked)."""
    bit_address_bytes: int = 4_096
    """Single bits are addressed in the first bytes of an area only; 0 for the whole area."""

    @property
    def time(self) -> Elementary:
        """The TIME of the programs."""
        return Elementary.SIGNED_TIME if self.allows_negative_times else Elementary.TIME

    def key(self, name: str) -> str:
        """Return what two spellings of the same name have in common."""
        folded = name.casefold()
        return folded[: self.significant_characters] if self.significant_characters else folded


EPAS_4: Final = Dialect("epas-4")
EDITION_3: Final = Dialect(
    "edition-3",
    has_long_types=True,
    has_wide_strings=True,
    has_power=True,
    has_short_circuit=True,
    has_continue=True,
    has_line_comments=True,
    nests_comments=True,
    has_jumps_in_st=True,
    has_set_assignments=True,
    has_references=True,
    has_unions=True,
    has_methods=True,
    has_classes=True,
    has_namespace_blocks=True,
    has_assignment_attempts=True,
    has_partial_access=True,
    has_characters_of_strings=True,
    has_static_variables=True,
    fills_arrays=True,
    has_open_arrays=True,
    has_void_functions=True,
    has_operator_calls=True,
    has_enable=True,
    has_edges=True,
    allows_time_fractions=True,
    allows_negative_times=True,
    allows_time_overflow=True,
    mixes_integers=False,
    computes_in_32_bits=False,
    allows_trailing_commas=True,
    computes_starts=True,
    has_calls_by_position=True,
    allows_missing_inputs=True,
    has_address_levels=True,
    allows_changed_inputs=True,
    allows_calls_without_brackets=False,
    shares_names_with_types=True,
    longest_string=32_767,
    has_typed_enumerations=True,
    repeats_enumeration_values=True,
    allows_numbers_between=True,
    significant_characters=0,
    bit_address_bytes=0,
)
CODESYS: Final = replace(
    EDITION_3,
    name="codesys",
    has_classes=False,
    has_namespace_blocks=False,
    has_assignment_attempts=False,
    has_characters_of_strings=False,
    has_operator_calls=False,
    has_enable=False,
    has_edges=False,
    reads_locals=True,
    indexes_pointers=True,
    mixes_integers=True,
    computes_in_32_bits=True,
    has_real_powers=True,
    has_chained_assignments=True,
    allows_empty_declarations=True,
    allows_open_addresses=True,
    mixes_address_sizes=True,
    has_local_instances=True,
    writes_parts_of_outputs=True,
    has_name_spaces=True,
    has_constant_arguments=True,
    has_constructors=True,
    allows_negative_times=False,
    leaves_comments_open=True,
    allows_missing_inputs=False,
    allows_idle_tasks=True,
    allows_calls_without_brackets=True,
)
"""Programs and libraries of CoDeSys V2.3, CODESYS V3 and TwinCAT, which compute with bit strings."""
DIALECTS: Final[Mapping[str, Dialect]] = {dialect.name: dialect for dialect in (EPAS_4, EDITION_3, CODESYS)}
