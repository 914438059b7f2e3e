"""The listings of the manual (digest 2.1): each is read without a mistake, and printing it changes its layout only."""

import re

import pytest

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.iec.tree import PouKind, Section

DECLARATIONS = {
    "PD-L01": "str:STRING(35):='This is a string';",
    "PD-L02": """arr1 : ARRAY [1..5] OF INT := 1,2,3,4,5;
arr2 : ARRAY [1..2,3..4] OF INT := 1,3(7);
      (* short for 1,7,7,7 *)
arr3 : ARRAY [1..2,2..3,3..4] OF INT := 2(0),4(4),2,3;
      (* short for 0,0,4,4,4,4,2,3 *)""",
    "PD-L03": "Cardgame: ARRAY [1..13, 1..4] OF INT;",
    "PD-L04": "pt:POINTER TO INT;\nvar_int1:INT := 5;\nvar_int2:INT;",
    "PD-L05": "TrafficLights: (red, yellow, green:=10); (*red has the\n  initial value 0, yellow 1, green 10 *)",
    "PD-L09": """a : INT := 13;
b : STRING := 'this is a string';
c : REAL := 1.1;
d : myStruct :=
  (
    state := TRUE,
    inputValue := 2.5
  );
e : ARRAY[1..10] OF INT :=
  1, 2, 2(4), 5, 6, 7, 8, 9,10;""",
    "PD-L21": "CMD_TMR : TON;",
}
STATEMENTS = {
    "PD-L04": "pt := ADR(var_int1);\nvar_int2:= pt^; (* var_int2 is now 5 *)",
    "PD-L05": "FOR i:= red TO green DO\n  i := i + 1;\nEND_FOR;",
    "PD-L17": "IF value < 7 THEN\n  WHILE value < 8 DO\n    value := value + 1;\n  END_WHILE;\nEND_IF;",
    "PD-L18": """A:=B; CV := CV + 1; C:=SIN(X);
CMD_TMR(IN := %IX5, PT := 300); A:=CMD_TMR.Q;
D:=B*B; IF D<0.0 THEN C:=A; ELSIF D=0.0 THEN C:=B; ELSE C:=D; END_IF;
CASE INT1 OF 1:BOOL1 := TRUE; 2:BOOL2 := TRUE; ELSE BOOL1 := FALSE; BOOL2 := FALSE; END_CASE;
J:=101; FOR I:=1 TO 100 BY 2 DO IF ARR[I] = 70 THEN J:=I; EXIT; END_IF; END_FOR;
J:=1; WHILE J<= 100 AND ARR[J] <> 70 DO J:=J+2; END_WHILE;
J:=1; REPEAT J:=J+2; UNTIL J= 101 OR ARR[J] = 70 END_REPEAT;
;
RETURN;""",
    "PD-L20": "WHILE Counter<>0 DO\n  Var1:=Var1*2;\n  Counter:=Counter-1;\nEND_WHILE\n\nErg:=Var1;",
    "PD-L22": "IF COUNTER > 10 THEN\n    RETURN;\nEND_IF;",
    "PD-L23": """CASE INT1 OF
1, 5:BOOL1 := TRUE;
   BOOL3 := FALSE;
2: BOOL2 := FALSE;
   BOOL3 := TRUE;
ELSE
   BOOL1 := NOT BOOL1;
   BOOL2 := BOOL1 OR BOOL2;
END_CASE;""",
    "PD-L24": "FOR counter:=1 TO 5 BY 1 DO\n  Var1:=Var1*2;\nEND_FOR;\nErg:=Var1;",
    "PD-L25": "REPEAT\n  Var1 := Var1*2;\n  counter := counter-1;\nUNTIL\n  counter=0\nEND_REPEAT",
    "PD-L28": "var1 := INDEXOF(baustein2);\npt := ADR(pt^) + SIZEOF(INT);",
    "PD-L29": "Var1 := NOT 2#1001_0011;",
    "PD-L37": "str:=BOOL_TO_STRING(TRUE);\n(* -> result is 'TRUE' *)\nt:=BOOL_TO_TIME(TRUE);\n(* -> result is T#1ms *)",
    "PD-L49": "Result := Fct(7) + 3;",
    "PD-L50": "Procedure(r_MC_4:=Axis_10);\nControllerEnableSet(r_MC_4.logAdr);(* enable for MC-4\n*)",
    "PD-L52": """CASE IState OF
   1: (* Initialisierung *)
       IEndWaitTime:=PacDriveM.Timer1+IWaitTime;

       IState:=IState+1;

   2: (* Ausgang HIGH setzen *)
       IF PacDriveM.Timer1 > IEndWaitTime THEN
           O_bBetriebsanzeigeH1.Value:= TRUE;
           IEndWaitTime:=PacDriveM.Timer1+IWaitTime;
           IState:=IState+1;
       END_IF;

   3: (* Ausgang LOW setzen *)
       IF PacDriveM.Timer1 > IEndWaitTime THEN
           O_bBetriebsanzeigeH1.Value:= FALSE;
           IEndWaitTime:=PacDriveM.Timer1+IWaitTime;
           IState:=2;
       END_IF;
END_CASE;""",
    "PD-L54": """(* load profiles*)
StartCamId:=ProfilLoad('modisin');
ProfilSetLambda(StartCamId, 1.0);
(* -> dwell -> velocity *)

CyclicCamId:=ProfilLoad('straight');
(* -> velocity -> velocity *)""",
    "PD-L56": """CASE g_lState_1 OF
4: (* prepare start cam*)
  bCamReset:=TRUE;
  g_lState_1:=g_lState_1+1;
5: (* start start cam*)
  CAM(lAxisId:= _ConveyerBelt, lEncId:=
  _MasterEncoder,
  lProfilId:= StartCamId, lrXOffset:= 0.0,
  lrYOffset:= 0.0, lrXFactor:= g_lrPartLength,
  lrYFactor:= lrYFactor1,lrXLimMin:= 0.0,
  lrXLimMax:= g_lrPartLength,bXLimMinOn:= TRUE,
  bXLimMaxOn:= TRUE, iXSetposMode:= ABSOLUTE,
lrXSetposPos:= 0.0, iYSetposMode:= ABSOLUTE,
lrYSetposPos:= 0.0, bReset:= bCamReset);
bCamReset:=FALSE;
IF (CAM.lResult = 0) THEN
  Schlz_DC:=0;
  bCamReset:=TRUE;
  g_lState_1:=g_lState_1+1;
END_IF;
(* cyclic cam ----- *)
(* 1st cycle must have different position manipulation! *)
6:(* start cyclic cam *)
  ;
END_CASE;""",
    "PD-L57": """RUN_STRING:='Start';
    IF (YVAL < 0) THEN
      YVAL := YVAL + OFFSET;
    BOTTOM := YVAL + OFFSET;
    END_IF;
    """,
    "PD-L13": """    LD    17
    ST    lint  (* comment *)
    GE    5
    JMPC  next
    LD    idword
    EQ    instruct.sdword
    STN   test
next:""",
    "PD-L14": """LD TRUE (* load TRUE into accumulator *)
ANDN BOOL1 (* execute AND with negated value of variable BOOL1 *)
JMPC marke (* if result was TRUE, jump to mark *)
LDN BOOL2 (* save negated value of *)
ST ERG (* BOOL2 in ERG *)
marke: LD BOOL2 (* save value of *)
ST ERG (* BOOL2 in ERG *)""",
    "PD-L16": "LD 2\nMUL ( 2\nADD 3\n) ST Erg",
    "PD-L19": "Loop:\n\nLD Counter\nEQ 0\nJMPC end\n\nLD Var1\nMUL 2\nST Var1\n\nJMP Loop\n\nend:\nLD Var1\nST Erg",
    "PD-L27": "LD 7\nADD 2,4,7\nST var1",
    "PD-L33": "LD 0\nMUX 30,40,50,60,70,80\nST Var1 (* result is 30 *)",
    "PD-L35": "LD var1\nADR\nST var2\nman_fun1",
    "PD-L36": "CAL INST(PAR1 := 0, PAR2 := TRUE)",
    "PD-L40": "LD 2.7\nREAL_TO_INT\nGE %MW8",
}
UNITS = {
    "PD-L07": """TYPE Polygonzug:
STRUCT
  Start:ARRAY [1..2] OF INT;
  Point1:ARRAY [1..2] OF INT;
  End:ARRAY [1..2] OF INT;
END_STRUCT
END_TYPE""",
    "PD-L08": "TYPE message:STRING[50];\nEND_TYPE;",
    "PD-L11": """FUNCTION_BLOCK Counter
(* Declaration part*)
VAR_INPUT
  iMode : INT; (* 0 = Reset, 1 = Count *)
END_VAR
VAR_OUTPUT
  iCounter : INT; (*actual counter value*)
END_VAR
(* Instruction part*)
IF iMode = 0 THEN
  iCounter:= 0; (*Reset*)
ELSIF iMode = 1 THEN
  iCounter:= iCounter + 1;
END_IF;
END_FUNCTION_BLOCK""",
    "PD-L12": """PROGRAM Main
(* Declaration part*)
VAR
    counter_1 : Counter; (* instance of FB counter *)
    iActCount : INT;
END_VAR
(* Instruction part*)
IF bfirstCycle THEN
    counter_1(iMode := 0);
    (* -> Call of FB counter with reset mode *)
ELSE
    counter_1(iMode := 1);
    (* -> Call of FB counter with counter mode*)
END_IF
iActCount := counter_1.iCounter;
    (* -> access to output variable of counter_1*)
END_PROGRAM""",
}
FILES = {
    **{f"{row} declared": f"PROGRAM p\nVAR\n{text}\nEND_VAR\nEND_PROGRAM" for row, text in DECLARATIONS.items()},
    **{row: f"PROGRAM p\n{text}\nEND_PROGRAM" for row, text in STATEMENTS.items()},
    **UNITS,
}


@pytest.mark.parametrize("row", FILES)
def test_a_listing_survives_printing(row: str) -> None:
    unit, mistakes = parse(FILES[row], f"{row}.st")
    assert mistakes == []
    printed = print_unit(unit)
    again, mistakes = parse(printed, f"{row}.st")
    assert mistakes == []
    assert again == unit
    assert print_unit(again) == printed
    assert words(printed) == words(FILES[row])


def words(text: str) -> str:
    """A text without blanks, capitals, semicolons and the two ways to write a length, and its comments in order."""
    comments = re.findall(r"\(\*.*?\*\)", text, re.DOTALL)
    rest = re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL)
    rest = re.sub(r"\[(\d+)\]", r"(\1)", rest)
    rest = re.sub(r"\((CAM\.lResult = 0|YVAL < 0)\)", r"\1", rest)
    return re.sub(r"[\s;]", "", rest).upper() + "".join(comments)


def test_a_state_machine_is_printed_with_its_comments_at_their_places() -> None:
    unit, _ = parse(FILES["PD-L52"], "lamp.st")
    assert print_unit(unit).splitlines()[1:11] == [
        "CASE IState OF",
        "    1: (* Initialisierung *)",
        "        IEndWaitTime := PacDriveM.Timer1 + IWaitTime;",
        "",
        "        IState := IState + 1;",
        "",
        "    2: (* Ausgang HIGH setzen *)",
        "        IF PacDriveM.Timer1 > IEndWaitTime THEN",
        "            O_bBetriebsanzeigeH1.Value := TRUE;",
        "            IEndWaitTime := PacDriveM.Timer1 + IWaitTime;",
    ]


def test_instruction_list_is_printed_as_the_manual_writes_it() -> None:
    unit, _ = parse(FILES["PD-L16"], "il.st")
    assert print_unit(unit).splitlines()[1:-1] == ["    LD 2", "    MUL ( 2", "        ADD 3", "    )", "    ST Erg"]


def test_a_pou_has_its_parts() -> None:
    unit, _ = parse(FILES["PD-L11"], "counter.st")
    pou = unit.declarations[0]
    assert isinstance(pou, tree.Pou)
    assert (pou.kind, pou.name, pou.result) == (PouKind.FUNCTION_BLOCK, "Counter", None)
    assert [block.section for block in pou.blocks] == [Section.INPUT, Section.OUTPUT]
    assert pou.blocks[0].variables == (tree.Variable("iMode", tree.NamedType("INT")),)
    assert pou.blocks[0].variables[0].remark == "(* 0 = Reset, 1 = Count *)"
    assert pou.blocks[0].comments == ("(* Declaration part*)",)
    assert isinstance(pou.body, tree.StBody)
    assert [type(statement) for statement in pou.body.statements] == [tree.If]
    assert pou.body.statements[0].comments == ("(* Instruction part*)",)


def number(value: int) -> tree.Literal:
    return tree.Literal(tree.LiteralKind.INTEGER, value)


def test_start_values_of_an_array_are_a_list_with_repetitions() -> None:
    unit, _ = parse("VAR_GLOBAL a : ARRAY [1..2,3..4] OF INT := 1,3(7); END_VAR", "a.st")
    block = unit.declarations[0]
    assert isinstance(block, tree.Variables)
    dimensions = (tree.Range(number(1), number(2)), tree.Range(number(3), number(4)))
    assert block.variables[0].type == tree.ArraySpec(dimensions, tree.NamedType("INT"))
    assert block.variables[0].initial == tree.ArrayInitial((number(1), tree.Repeated(number(3), number(7))))


@pytest.mark.manual("PD-366")
def test_a_block_is_called_with_named_inputs() -> None:
    unit, _ = parse("PROGRAM p CMD_TMR(IN := a, PT := 300); A := CMD_TMR.Q; END_PROGRAM", "p.st")
    pou = unit.declarations[0]
    assert isinstance(pou, tree.Pou)
    arguments = (tree.Argument(tree.Name("a"), "IN"), tree.Argument(number(300), "PT"))
    assert pou.body == tree.StBody(
        (
            tree.CallStatement(tree.Call(tree.Name("CMD_TMR"), arguments)),
            tree.Assign(tree.Name("A"), tree.Member(tree.Name("CMD_TMR"), "Q")),
        )
    )


def test_a_configuration_has_tasks_and_programs() -> None:
    text = """
CONFIGURATION conveyor
    VAR_GLOBAL g : INT; END_VAR
    RESOURCE PLC ON MAx4
        TASK fast(INTERVAL := T#10ms, PRIORITY := 3);
        TASK event(SINGLE := g_start, PRIORITY := 1);
        TASK free(PRIORITY := 31);
        PROGRAM belt WITH fast : CONVEYOR;
    END_RESOURCE
    VAR_CONFIG belt.lamp AT %QX0.3 : BOOL; END_VAR
END_CONFIGURATION
"""
    unit, mistakes = parse(text, "c.st")
    assert mistakes == []
    interval = tree.Literal(tree.LiteralKind.TIME, 10)
    lamp = tree.Variable("belt.lamp", tree.NamedType("BOOL"), None, tree.Direct("Q", "X", (0, 3)))
    assert unit.declarations == (
        tree.Configuration(
            "conveyor",
            (
                tree.Variables(Section.GLOBAL, (tree.Variable("g", tree.NamedType("INT")),)),
                tree.Variables(Section.CONFIG, (lamp,)),
            ),
            (
                tree.TaskDeclaration("fast", number(3), interval),
                tree.TaskDeclaration("event", number(1), single=tree.Name("g_start")),
                tree.TaskDeclaration("free", number(31)),
            ),
            (tree.ProgramInstance("belt", "fast", "CONVEYOR"),),
            "PLC",
            "MAx4",
        ),
    )


# A body, and the class of its tree.
LANGUAGES = [
    ("x := 1;", tree.StBody),
    ("LD x", tree.IlBody),
    ("LD", tree.IlBody),
    ("LD := 5;", tree.StBody),
    ("LD(a);", tree.StBody),
    ("S.x := 5;", tree.StBody),
    ("start: LD x", tree.IlBody),
    ("CAL x", tree.IlBody),
    ("NOT", tree.IlBody),
    ("INITIAL_STEP a: END_STEP", tree.SfcBody),
    ("STEP a: END_STEP", tree.SfcBody),
    ("Step := 5;", tree.StBody),
    ("{native}", tree.NativeBody),
    ("{attribute 'hide'} x := 1;", tree.StBody),
    ("", tree.StBody),
]


@pytest.mark.parametrize(("body", "expected"), LANGUAGES)
def test_the_first_line_shows_the_language_of_a_body(body: str, expected: type) -> None:
    unit, _ = parse(f"PROGRAM p\n{body}\nEND_PROGRAM", "p.st")
    pou = unit.declarations[0]
    assert isinstance(pou, tree.Pou)
    assert type(pou.body) is expected
