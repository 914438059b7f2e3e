"""The library TcUnit as programs see it: its source text, with natives for what a suite does.

Source: the interface of TcUnit 1.3.2.  The asserts are methods of FB_TestSuite, which hand their values to a native
function for the type.  An instance of a suite has one byte, because everything else is in the `Session`.
"""

from typing import Final

from fieldrig_devices.iec.elementary import Elementary

NAME: Final = "TcUnit"
FILE: Final = "tcunit.st"
LIST: Final = "GVL_Param_TcUnit"
"""The name of the list of parameters, which is the first declaration of the text."""
SUITE: Final = "FB_TestSuite"
LEFT_OUT: Final = "TCUNIT_NATIVE_LEFT_OUT"
"""The function whose call is a fault: it stands for what does not compile."""
MARK: Final = "isSuite"
"""The variable that only instances of suites have."""

_E: Final = Elementary
BIT_STRINGS: Final = (_E.BYTE, _E.WORD, _E.DWORD, _E.LWORD)
INTEGERS: Final = (_E.SINT, _E.INT, _E.DINT, _E.LINT, _E.USINT, _E.UINT, _E.UDINT, _E.ULINT)
REALS: Final = (_E.REAL, _E.LREAL)
LISTED: Final = (_E.BOOL, *BIT_STRINGS, *INTEGERS)
"""The types of the arrays of one dimension without a tolerance."""
LONG_NAMES: Final = {"DATE_AND_TIME": _E.DT, "TIME_OF_DAY": _E.TOD}
SCALARS: Final = {
    **{kind.name: kind for kind in (*LISTED, _E.TIME, _E.LTIME, _E.DATE)},
    **LONG_NAMES,
}
"""The elementary types that have an assert of their own, by its name, without REAL and LREAL."""
TEXTS: Final = ("STRING", "WSTRING")
_SHORT_TEXT: Final = 80

PARAMETERS: Final = (
    "MaxNumberOfTestsForEachTestSuite",
    "MaxNumberOfAssertsForEachTestSuite",
    "LogExtendedResults",
    "TimeBetweenTestSuitesExecution",
)
"""The parameters that a run needs, whether the program names them or not."""
_PARAMETERS: Final = """
VAR_GLOBAL CONSTANT
    MaxNumberOfTestSuites : UINT := 1000;
    MaxNumberOfTestsForEachTestSuite : UINT := 100;
    MaxNumberOfAssertsForEachTestSuite : UINT := 1000;
    LogExtendedResults : BOOL := TRUE;
    xUnitEnablePublish : BOOL := FALSE;
    xUnitBufferSize : UDINT := 65535;
    xUnitFilePath : STRING(255) := '%TC_BOOTPRJPATH%tcunit_xunit_testresults.xml';
    AdsLogMessageFifoRingBufferSize : UINT := 2000;
    TimeBetweenTestSuitesExecution : TIME := T#0MS;
END_VAR
"""

_RUN: Final = """
FUNCTION {name}
{inputs}VAR suite : POINTER TO FB_TestSuite; END_VAR
TCUNIT_NATIVE_CYCLE({is_sequence});
suite := TCUNIT_NATIVE_FOLLOWING();
WHILE suite <> 0 DO
    suite^();
    suite := TCUNIT_NATIVE_FOLLOWING();
END_WHILE;
END_FUNCTION
"""

_FUNCTIONS: Final = """
FUNCTION TEST VAR_INPUT TestName : STRING(255); END_VAR {native} END_FUNCTION
FUNCTION TEST_ORDERED : BOOL VAR_INPUT TestName : STRING(255); END_VAR {native} END_FUNCTION
FUNCTION TEST_FINISHED : BOOL {native} END_FUNCTION
FUNCTION TEST_FINISHED_NAMED VAR_INPUT TestName : STRING(255); END_VAR {native} END_FUNCTION
FUNCTION IS_TEST_FINISHED : BOOL VAR_INPUT TestName : STRING(255); END_VAR {native} END_FUNCTION
FUNCTION TCUNIT_ADSLOGSTR
VAR_INPUT msgCtrlMask : DWORD; msgFmtStr : STRING(255); strArg : STRING(255); END_VAR
{native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_CYCLE VAR_INPUT isSequence : BOOL; END_VAR {native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_FOLLOWING : DWORD {native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_REGISTER VAR_INPUT suite : DWORD; END_VAR {native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_LEFT_OUT VAR_INPUT reason : STRING(255); END_VAR {native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_ARE_FINISHED : BOOL VAR_INPUT suite : DWORD; END_VAR {native} END_FUNCTION
FUNCTION TCUNIT_NATIVE_ANY
VAR_INPUT suite : DWORD; Expected : ANY; Actual : ANY; Message : STRING(255); END_VAR
{native} END_FUNCTION
FUNCTION_BLOCK FB_Test END_FUNCTION_BLOCK
FUNCTION F_CheckMemoryArea : E_TcMemoryArea VAR_INPUT pData : PVOID; nSize : UDINT; END_VAR {native} END_FUNCTION
"""

_SUITE_HEAD: Final = """
FUNCTION_BLOCK FB_TestSuite
VAR isSuite : BOOL := TRUE; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
TCUNIT_NATIVE_REGISTER(ADR(THIS^));
END_METHOD
METHOD AreAllTestsFinished : BOOL
AreAllTestsFinished := TCUNIT_NATIVE_ARE_FINISHED(ADR(THIS^));
END_METHOD
METHOD AssertTrue
VAR_INPUT Condition : BOOL; Message : STRING(255); END_VAR
TCUNIT_NATIVE_BOOL(ADR(THIS^), TRUE, Condition, Message);
END_METHOD
METHOD AssertFalse
VAR_INPUT Condition : BOOL; Message : STRING(255); END_VAR
TCUNIT_NATIVE_BOOL(ADR(THIS^), FALSE, Condition, Message);
END_METHOD
METHOD AssertEquals
VAR_INPUT Expected : ANY; Actual : ANY; Message : STRING(255); END_VAR
TCUNIT_NATIVE_ANY(ADR(THIS^), Expected, Actual, Message);
END_METHOD
"""


def native_name(kind: str, dimensions: int = 0) -> str:
    """Return the name of the native function behind the asserts of a type, or of arrays of it."""
    return f"TCUNIT_NATIVE_{kind}{f'_{dimensions}D' if dimensions else ''}"


def array_asserts() -> list[tuple[str, Elementary, int]]:
    """Return the names of the asserts of arrays, each with the type of the elements and the number of dimensions."""
    made = [(f"AssertArrayEquals_{kind.name}", kind, 1) for kind in (*LISTED, *REALS)]
    return [*made, *((f"AssertArray{n}dEquals_{kind.name}", kind, n) for n in (2, 3) for kind in REALS)]


def _scalar(name: str) -> tuple[str, str]:
    """Return the method and the native function of an assert for scalars."""
    spec = f"{name}(255)" if name in TEXTS else name
    delta, given = (f" Delta : {name};", ", Delta") if name in (kind.name for kind in REALS) else ("", "")
    inputs = f"Expected : {spec}; Actual : {spec};{delta} Message : STRING(255);"
    native = native_name(name)
    method = (
        f"METHOD AssertEquals_{name}\nVAR_INPUT {inputs} END_VAR\n"
        f"{native}(ADR(THIS^), Expected, Actual{given}, Message);\nEND_METHOD\n"
    )
    return method, f"FUNCTION {native} VAR_INPUT suite : DWORD; {inputs} END_VAR {{native}} END_FUNCTION\n"


def _array(name: str, kind: Elementary, dimensions: int) -> tuple[str, str]:
    """Return the same for arrays."""
    spec = f"ARRAY[{', '.join('*' * dimensions)}] OF {kind.name}"
    delta, given = (f"Delta : {kind.name}; ", ", Delta") if kind.is_real else ("", "")
    arrays = f"VAR_IN_OUT CONSTANT Expecteds : {spec}; Actuals : {spec}; END_VAR"
    native = native_name(kind.name, dimensions)
    method = (
        f"METHOD {name}\n{arrays}\nVAR_INPUT {delta}Message : STRING(255); END_VAR\n"
        f"{native}(ADR(THIS^), Expecteds, Actuals{given}, Message);\nEND_METHOD\n"
    )
    inputs = f"VAR_INPUT suite : DWORD; END_VAR {arrays} VAR_INPUT {delta}Message : STRING(255); END_VAR"
    return method, f"FUNCTION {native} {inputs} {{native}} END_FUNCTION\n"


def _write_protected(kind: str, spec: str) -> str:
    return (
        f"FUNCTION WRITE_PROTECTED_{kind}\nVAR_INPUT Ptr : POINTER TO {spec}; Value : {spec}; END_VAR\n"
        "Ptr^ := Value;\nEND_FUNCTION\n"
    )


def _written() -> str:
    kinds = [name for name in (*SCALARS, *(kind.name for kind in REALS)) if name != "LTIME"]
    texts = [(name, f"{name}({_SHORT_TEXT})") for name in TEXTS]
    return "\n".join(_write_protected(*pair) for pair in (*((kind, kind) for kind in kinds), *texts))


def text() -> str:
    """Return the source text of the library."""
    scalars = [_scalar(name) for name in (*SCALARS, *(kind.name for kind in REALS), *TEXTS)]
    arrays = [_array(*one) for one in array_asserts()]
    methods = "".join(method for method, _ in (*scalars, *arrays))
    natives = "".join(native for _, native in (*scalars, *arrays))
    runs = _RUN.format(name="RUN", inputs="", is_sequence="FALSE")
    runs += _RUN.format(name="RUN_IN_SEQUENCE", inputs="", is_sequence="TRUE")
    suite = f"{_SUITE_HEAD}{methods}END_FUNCTION_BLOCK\n"
    return f"{_PARAMETERS}{runs}{_FUNCTIONS}{natives}{suite}{_written()}"
