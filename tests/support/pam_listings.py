"""The 49 listings of the manual, as section 4 of its digest numbers them.

The surroundings that a listing leaves out are in `MACHINE`; its own statements are in a sequence, unless it declares
programs itself.
"""

from pam_programs import HEADER

MACHINE = (
    HEADER
    + """
NODES_GROUP NGR_Heads; NUMBER = 3; END
NODE NOD_Main; ADDRESS = 4; TYPE = ST1; END
NODE NOD_Second; ADDRESS = 5; TYPE = ST1; END
NODE NOD_Third; ADDRESS = 6; TYPE = ST1; END
NODE NOD_Axes; NUMBER = 3; ADDRESS = 1; TYPE = ST1; END
NODE NOD_ToolsIo; NUMBER = 3; ADDRESS = 41; TYPE = SMART_IO; END
NODE NOD_Desk; ADDRESS = 50; TYPE = SMART_IO; END
AXIS AXI_Main; NODE = NOD_Second; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 3600.0; ACCELERATION = 36000.0;
  DECELERATION = 72000.0; INITIAL_POSITION = 0.0; POSITION_PERIOD = 360.0; END
AXIS AXI_X; NODE = NOD_Third; PULSES_PER_UNIT = 1; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0;
  POSITION_PERIOD = 1; END
AXIS AXI_Axes; NODE = NOD_Axes; PULSES_PER_UNIT = 1; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0;
  POSITION_PERIOD = 1; END
BINARY_INPUT SBI_Stop; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_INPUT SBI_Emergency; NODE = NOD_Desk; ADDRESS = 102; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_OUTPUT SBO_Led1; NODE = NOD_Desk; ADDRESS = 201; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Each; NODE = NOD_Axes; ADDRESS = 201; ACTIVE = HIGH; END
ANALOG_OUTPUT SAO_Out; NODE = NOD_Desk; RANGE = -10 10; ADDRESS = 1; END
ENCODER ENC_Pos; NODE = NOD_Main; ADDRESS = 0; PULSES_PER_UNIT = 182.0444; POSITION_PERIOD = 10.0; END
INTERNAL FLAG_VAR IFV_1; INTERNAL FLAG_VAR IFV_2; INTERNAL FLAG_VAR IFV_3; INTERNAL WORD_VAR IWV_Mode;
INTERNAL REAL_VAR IRV_Sp; NUMBER = 3; END
INTERNAL REAL_VAR IRV_Ratio; COMMON REAL_VAR CRV_Value; COMMON FLAG_VAR CFV_FirstRun; COMMON WORD_VAR CWV_Count;
TMP_GENERATOR TMP_Master; TRAVEL_SPEED = 360.0; ACCELERATION = 36000.0; INITIAL_POSITION = 0.0;
  POSITION_PERIOD = 360.0; PERIOD = 0.001; ANTI_DELAY = YES; END
AMPLIFIER AMP_One; GAIN = 1; OFFSET = 0; GAIN_SLOPE = MAX; OFFSET_SLOPE = MAX; END
PROFILE PRO_Nb1; FILE = NB1; INPUT_AMPLITUDE = 360; OUTPUT_AMPLITUDE = 1; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END
CAM CAM_Example; PROFILE = PRO_Nb1; VALUE_PERIOD = 360; END
CONVERTER CNV_Main; DESTINATION = AXI_Main; MODE = POSITION; END
COMPARATOR CMP_Example; REFERENCE = 0; END
"""
)
DC_MOTOR = """
BINARY_OUTPUT SBO_Inc; NODE = NOD_ToolsIo; ADDRESS = 201; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Dec; NODE = NOD_ToolsIo; ADDRESS = 202; ACTIVE = HIGH; END
BINARY_INPUT SBI_Zero; NODE = NOD_ToolsIo; ADDRESS = 102; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
COUNTER_INPUT CNT_Pulses; NODE = {node}; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
DC_MOTOR DCM_Tools; INC = SBO_Inc; DEC = SBO_Dec; ZERO = SBI_Zero; ENCODER = CNT_Pulses; TIMEOUT = 500; {rest} = 2; END
"""
EXECUTED = (
    "TASK TSK_{0}; SPECS CYCLES = 1; END_SPECS SEQUENCE SEQ_a; END_SEQUENCE SEQUENCE SEQ_b; END_SEQUENCE END_TASK\n"
)


def task(statements: str, *, specs: str = "", tag: str = "", more: str = "", name: str = "TSK_Test") -> str:
    return (
        f"\nTASK {name}; SPECS CYCLES = 10; {specs} END_SPECS SEQUENCE SEQ_1{tag}; {statements} END_SEQUENCE\n"
        f"SEQUENCE SEQ_Other{tag}; END_SEQUENCE {more} END_TASK\n"
    )


MULTI = (
    "ROUTINES RGR_Main; ROUTINE RTN_Origin; CWV_Count <- 1; END_ROUTINE END_ROUTINES\n"
    "MULTI_COMPARATOR MUL_Example; TIME_ORIGIN_SLOPE = POSITIVE; TIME_ORIGIN_COMPARE_MODE = NEXT_PERIOD;"
    " TIME_ORIGIN_REFERENCE = 0.05; TIME_ORIGIN_ROUTINE = RTN_Origin; VALUE_PERIOD = 1.0;"
    " TRACE TRC_1; ROUTINE = NONE; END TRACE TRC_2; ROUTINE = NONE; END END\n"
    "ROUTINES RGR_Traces; ROUTINE RTN_Trace1; IF CWV_Count = 1 THEN CWV_Count <- 2;"
    " TRC_1 <- install_reference(POSITIVE, IMMEDIATE, 0.4, 0.005);"
    " ELSE IF CWV_Count = 2 THEN CWV_Count <- 1; CFV_FirstRun <- 1; END_IF END_IF END_ROUTINE END_ROUTINES\n"
    + task(
        "CFV_FirstRun <- 0; TRC_1:ROUTINE <- RTN_Trace1; MUL_Example <- learn; CNV_Main << MUL_Example << TMP_Master;"
        " TRC_1 <- install_reference(POSITIVE, IMMEDIATE, 0.2, 0.010); LOOP CONDITION (CFV_FirstRun = 1);"
        " MUL_Example <- execute; CFV_FirstRun <- 0; END_LOOP SBI_Stop;"
    )
)
DISTRIBUTED = "".join(
    f"SINK SNK_{number}; END CONVERTER CNV_{number}; DESTINATION = SNK_{number}; MODE = VALUE; END"
    f" DISTRIBUTOR DIS_{number}; DIVISOR = 5; SHIFT = {number - 2}; END\n"
    for number in (2, 3, 4)
)

# Each listing by its number: the text behind MACHINE; those of whole programs are in WHOLE.
LISTINGS = {
    4: task("IF NOD_Desk ? error THEN IF NOD_Desk ? error_code = 12 THEN IFV_1 <- set; END_IF END_IF"),
    5: "AXIS AXI_Leader; NODE = NOD_Main; PULSES_PER_UNIT = 11930464.7111; /* (2^32/360) */ TRAVEL_SPEED = 3600.0;"
    " ACCELERATION = 36000.0; DECELERATION = 36000.0; INITIAL_POSITION = 0.0; POSITION_PERIOD = 360.0; END",
    6: task(
        "AXI_Main:TRAVEL_SPEED <- (3.22); AXI_Axes[i]:ACCELERATION <- (IRV_Sp[i]);"
        " AXI_Axes[all]:DECELERATION <- (IRV_Sp[i] * 1.25 - 1);",
        specs="NUMBER = 3;",
        tag="[i]",
    ),
    7: "BINARY_INPUT SBI_A; NODE = NOD_Axes; ADDRESS = 210; ACTIVE = LOW; PERIOD = 20; DEBOUNCE = 1; END",
    8: "DIGITAL_INPUT SDI_1; NODE = NOD_ToolsIo; BITS = 5; ADDRESS = 208; ACTIVE = HIGH; PERIOD = 10;"
    " DEBOUNCE = 2; END",
    9: "COUNTER_INPUT CNT_1; NODE = NOD_ToolsIo; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END",
    10: "KEY_INPUT KEY_a; NODE = NOD_ToolsIo; MODE = ON_OFF; ADDRESS = 12; ACTIVE = HIGH; PERIOD = 50; END"
    " KEY_INPUT KEY_b; NODE = NOD_ToolsIo; MODE = AUTOREPEAT; DELAY = 1500; REPEAT = 500; ADDRESS = 18; ACTIVE = HIGH;"
    " PERIOD = 50; END KEY_INPUT KEY_c; NODE = NOD_ToolsIo; MODE = TOGGLE; ON BINARY_INPUT ADDRESS ="
    " 103; ACTIVE = HIGH;"
    " PERIOD = 20; DEBOUNCE = 2; END",
    11: task("SBO_Each[all] <- set; SBO_Led1 <- invert; SBO_Led1 <- reset;"),
    12: "DIGITAL_OUTPUT SDO_1; NODE = NOD_ToolsIo; BITS = 6; ADDRESS = 201; ACTIVE = HIGH; END"
    + task("SDO_1[all] <- 63;"),
    13: "ANALOG_OUTPUT SAO_1; NODE = NOD_ToolsIo; RANGE = -10000 10000; ADDRESS = 1; END" + task("SAO_1[all] <- 1245;"),
    14: "LED_OUTPUT LED_1; NODE = NOD_Desk; ADDRESS = 6; END"
    + task("LED_1 <- set; LED_1 <- blink; WAIT_TIME 5000; LED_1 <- no_blink;"),
    15: "D7SEG_OUTPUT D7S_1; NODE = NOD_Desk; DIGITS = 1; ADDRESS = 1; END"
    + task('D7S_1 <- display("P"); D7S_1 <- display(7, 1); D7S_1 <- display(8000/1000, 1); D7S_1 <- display(4660, 1);'),
    16: "PAM_ANALOG_OUTPUT PAO_0; UNITS_PER_VOLT = 1000.0; OFFSET = 0.0; ADDRESS = 0; END"
    " PAM_ANALOG_OUTPUT PAO_1; UNITS_PER_VOLT = 10000.0; OFFSET = 12500.0; ADDRESS = 1; END"
    " CONVERTER CNV_Probe; DESTINATION = PAO_0; MODE = VALUE; END"
    + task("CNV_Probe << CAM_Example << TMP_Master; PAO_0 <- 1245.38; PAO_1 <- - 12500; PAO_1 <- 0; PAO_1 <- 12500;"),
    17: DC_MOTOR.format(node="NOD_ToolsIo", rest="BREAKING"),
    18: "ENCODER ENC_Temp; NODE = NOD_Main; ADDRESS = 1273; PULSES_PER_UNIT = 16.0; POSITION_RANGE = 0.0 60.0; END"
    + task("CRV_Value <- ENC_Pos ? position; CWV_Count <- ENC_Temp ? value;"),
    20: "AXES_SET AXS_Table; AXIS = AXI_X; AXIS = AXI_Main; END" + task("AXS_Table <- power_on;"),
    21: "AXES_SET AXS_Example; AXIS = AXI_X SUBSET=1; AXIS = AXI_Main SUBSET=2; AXIS = AXI_Axes[all] SUBSET=4; END",
    22: "ZERO_POSITIONER ZEP_a; OBJECT = AXI_Main; SENSOR = SBI_Stop; FINE_SPEED = 720.0; FINE_EDGE = RISING;"
    " FINE_MOVE = 180.0; RESOLVER_OFFSET = 240.0; END ZERO_POSITIONER ZEP_b; OBJECT = AXI_Main; SENSOR = SBI_Stop;"
    " COARSE_SPEED = CURRENT; COARSE_EDGE = FALLING; COARSE_MOVE = NONE; FINE_SPEED = 720.0; FINE_EDGE = RISING;"
    " FINE_MOVE = 180.0; END"
    + task("AXI_Main <- travel_speed(720.0); ZEP_a <- start; CONDITION ZEP_a ? ready; SBO_Led1 <- set;"),
    23: "INTERNAL FLAG_VAR IFV_System; INTERNAL REAL_VAR IRV_Area; NUMBER = 8; END"
    " INTERNAL WORD_VAR IWV_Head; NODES_GROUP = NGR_Heads; END ; COMMON FLAG_VAR CFV_My; /* NUMBER = 1 */"
    " COMMON REAL_VAR CRV_Offset; NUMBER = 8; END COMMON WORD_VAR CWV_Loop; NODES_GROUP = NGR_Heads; END ;",
    24: "INTERNAL FLAG_VAR IFV_e; NUMBER = 3; END COMMON FLAG_VAR CFV_f; NUMBER = 3; END"
    " BOOLEAN BOL_1; EQUATION SBI_Stop * IFV_1 * (SBI_Emergency + CFV_FirstRun) ; END_BOOLEAN"
    " BOOLEAN BOL_2 [i]; EQUATION IFV_e[i] * CFV_f[i] * (CFV_f[i] + IFV_e[i]) ; END_BOOLEAN"
    " BOOLEAN BOL_3; EQUATION (IFV_e[i] * CFV_f[i])[all+] * (SBI_Stop + CFV_FirstRun) ; END_BOOLEAN"
    " BOOLEAN BOL_4; EQUATION IFV_e[all+] * CFV_f[all*] * !(SBI_Stop + CFV_FirstRun) ; END_BOOLEAN"
    " BOOLEAN BOL_5; EQUATION (AXI_Axes[i] ? ready)[all*] * !(NOD_Desk ? error) ; END_BOOLEAN"
    " BOOLEAN BOL_6[i]; LINKED_OUTPUT = SBO_Each; EQUATION (AXI_Axes[i] ? speed >= 123.5) * !(AXI_Axes[i] ? error);"
    " END_BOOLEAN BOOLEAN BOL_7[i]; LINKED_OUTPUT = SBO_Each; EQUATION IFV_e[i] + !SBI_Stop; END_BOOLEAN",
    25: "ROUTINES RGR_a; ROUTINE RTN_Send WITH IRV_Amplitude, IWV_Kind; IFV_1 <- set; SAO_Out <-"
    " IRV_Amplitude * IRV_Ratio;"
    " IWV_Mode <- IWV_Kind; IFV_2 <- set; END_ROUTINE END_ROUTINES"
    + task("CALL RTN_Send WITH IRV_Ratio/10, IWV_Mode ;"),
    26: "TASK TSK_First; SPECS PERIOD = 10; END_SPECS EVENTS ON_EVENT IFV_1 XEQ_SEQUENCE SEQ_a; ON_EVENT IFV_2"
    " XEQ_SEQUENCE SEQ_b; END_EVENTS SEQUENCE SEQ_a; END_SEQUENCE SEQUENCE SEQ_b; END_SEQUENCE POWERON IFV_3 <- set;"
    " END_POWERON END_TASK TASK TSK_Second; SPECS NUMBER = 3; PERIOD = 10; END_SPECS EVENTS ON_EVENT IRV_Sp[i] > 1"
    " XEQ_SEQUENCE SEQ_a[i]; END_EVENTS SEQUENCE SEQ_a[i]; END_SEQUENCE END_TASK",
    27: task(
        "IF SBI_Stop THEN XEQ_SEQUENCE SEQ_Other END_IF LOOP CFV_FirstRun <- set; WAIT_TIME 1000;"
        " CFV_FirstRun <- reset;"
        " END_LOOP SBI_Stop; IF SBI_Stop THEN IFV_1 <- set; ELSE IFV_1 <- reset; END_IF"
    ),
    28: EXECUTED.format("XEQ")
    + task("XEQ_TASK TSK_XEQ SEQUENCE SEQ_a; IFV_1 <- set;", name="TSK_1")
    + task("XEQ_TASK TSK_XEQ SEQUENCE SEQ_b WAIT;", name="TSK_2"),
    29: "ZERO_POSITIONER ZEP_a; OBJECT = AXI_Main; RESOLVER_OFFSET = 1; END"
    + task(
        "CONDITION IFV_1; ZEP_a <- start; CONDITION ZEP_a ? ready TIMEOUT 5000; IF TIMEOUT THEN ZEP_a <- stop;"
        " IFV_2 <- set; ELSE IFV_3 <- set; END_IF"
    ),
    30: "INTERNAL FLAG_VAR IFV_Ends; NUMBER = 20; END"
    + task("EXCEPTION IFV_Ends[i] ABORT_SEQUENCE; CONDITION DUPL_START;", specs="NUMBER = 20; DUPL = 10;", tag="[i]"),
    31: task(
        "WAIT_TIME 100; CASE CONDITION IFV_1 XEQ_SEQUENCE SEQ_1; CONDITION IFV_2 XEQ_SEQUENCE SEQ_Other;"
        " CONDITION IFV_3"
        " XEQ_SEQUENCE SEQ_Other; TIMEOUT 500 XEQ_SEQUENCE SEQ_Other; END_CASE IFV_1 <- set; // never reached\n"
    ),
    32: task("EXCEPTION SBI_Stop TIMEOUT 1000 SEQUENCE SEQ_Other;"),
    33: task("EXCEPTION SBI_Stop ENTRY Exit; IFV_1 <- set; EXCEPTION_ENTRY Exit; IFV_2 <- set;"),
    34: EXECUTED.format("Exception").replace("SPECS CYCLES = 1; END_SPECS", "")
    + task("EXCEPTION SBI_Stop TIMEOUT 1000 XEQ_TASK TSK_Exception SEQUENCE SEQ_a; IFV_1 <- set;")
    + task("EXCEPTION SBI_Stop XEQ_TASK TSK_Exception SEQUENCE SEQ_b WAIT;", name="TSK_b")
    + task("EXCEPTION SBI_Stop XEQ_TASK TSK_Exception SEQUENCE SEQ_b ABORT;", name="TSK_c"),
    35: task("EXCEPTION SBI_Stop ABORT_SEQUENCE; IFV_1 <- set; REMOVE_EXCEPTION IFV_2 <- set;"),
    36: task(
        "EXCEPTION SBI_Stop TIMEOUT 1000 ENTRY exit; IFV_1 <- set; EXCEPTION SBI_Emergency TIMEOUT ABORT_SEQUENCE;"
        " IFV_2 <- set; EXCEPTION_ENTRY exit; IF TIMEOUT THEN IFV_3 <- set; ELSE IFV_3 <- reset; END_IF"
    ),
    37: "SAMPLER SMP_a; SOURCE = ENC_Pos; MODE = POSITION; PERIOD = 0.01; END"
    + task(
        "CNV_Main << AMP_One << SMP_a; CONDITION CNV_Main ? ready; CNV_Main <- disactivate; CNV_Main <- deactivate;"
    ),
    38: "ROUTINES RGR_a; ROUTINE RTN_Apply; CAM_Example:PROFILE <- PRO_Nb1; END_ROUTINE ROUTINE RTN_Modify;"
    " PRO_Nb1:INPUT_AMPLITUDE <- 200; PRO_Nb1:INPUT_OFFSET <- 10; CAM_Example:PROFILE <- PRO_Nb1;"
    " END_ROUTINE END_ROUTINES"
    + task("CRV_Value <- PRO_Nb1:OUTPUT_AMPLITUDE; PRO_Nb1:OUTPUT_AMPLITUDE <- IRV_Ratio * 3;"),
    39: "ROUTINES RGR_a; ROUTINE RTN_Ref; IFV_1 <- set; END_ROUTINE END_ROUTINES"
    " COMPARATOR CMP_Leader; REFERENCE = 0.0; ROUTINE = RTN_Ref; REVERSE_ROUTINE = NONE; END"
    + task(
        "CMP_Leader:REFERENCE <- 1000.0; CONDITION CMP_Leader ? ready; SBO_Led1 <- set; CONDITION"
        " !(CMP_Leader ? ready);"
        " CMP_Leader:THROUGH_ZERO_REFERENCE <- 326.0; CRV_Value <- CMP_Leader ? value; CMP_Leader:ROUTINE <- RTN_Ref;"
    ),
    40: "CORRECTOR COR_a; CORRECTION_SLOPE = 3600.0; CORRECTION_LEVEL = 3600.0; CORRECTION_REFERENCE = INPUT;"
    " CORRECTION_MODE = ON_REQUEST; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Stop; VALUE_PERIOD = 360.0;"
    " DELAY_COMPENSATION = 0.00; END" + task("COR_a <- start_correction; COR_a <- start_correction (-180);"),
    41: "DERIVATOR DER_a; VALUE_PERIOD = 360.0; END" + task("IF (DER_a ? value) > 1250 THEN IFV_1 <- set; END_IF"),
    42: DISTRIBUTED
    + task("CNV_Main << CAM_Example << TMP_Master;" + "".join(f"CNV_{n} << DIS_{n} << TMP_Master;" for n in (2, 3, 4))),
    43: MULTI,
    44: "PHASER PHA_a; PHASE = 0.0; PHASE_SLOPE = MAX; STANDBY_VALUE = 0.0; VALUE_PERIOD = 90.0; END"
    + task("PHA_a <- start; PHA_a:PHASE <- 45; PHA_a <- stop; CONDITION PHA_a ? ready;"),
    45: "PMP_GENERATOR PMP_a; FIRST_TRAVEL_SPEED = 9000.0; LAST_TRAVEL_SPEED = 4500.0; ACCELERATION = 45000.0;"
    " JERK = 450000.0; POSITION = 0.0; POSITION_RANGE = 0.0 10000.0; PERIOD = 0.001; END"
    + task(
        "PMP_a <- relative_move(4500.0) ; PMP_a <- relative_move(4500.0 -2000.0) ; PMP_a <- relative_move(1.0, -2.0);"
    ),
    46: "PMP_GENERATOR PMP_a; FIRST_TRAVEL_SPEED = 1; LAST_TRAVEL_SPEED = 1; ACCELERATION = 1; JERK = 1;"
    " INITIAL_POSITION = 0.0; POSITION_PERIOD = 360; PERIOD = 0.001; ANTI_DELAY = YES; END"
    + task("PMP_a <- relative_move(4500.0 -2000.0) ;"),
    47: "SAMPLER SMP_Leader; SOURCE = ENC_Pos; MODE = POSITION; PERIOD = 0.01; END",
    48: "TMP_GENERATOR TMP_a; TRAVEL_SPEED = 50.0; ACCELERATION = 0.3; DECELERATION = 0.6; INITIAL_POSITION = 0.0;"
    " POSITION_PERIOD = 678; PERIOD = 0.001; END" + task("TMP_a:TRAVEL_SPEED <- 6.0; TMP_a <- relative_move(450);"),
    49: "PMP_GENERATOR PMP_a; FIRST_TRAVEL_SPEED = 1; LAST_TRAVEL_SPEED = 1; ACCELERATION = 1; JERK = 1;"
    " INITIAL_POSITION = 0.0; POSITION_PERIOD = 360; PERIOD = 0.001; END"
    + task(
        "PMP_a <- position (70.0) ; PMP_a <- absolute_move (12000.0) ; PMP_a <- absolute_move (12000.0, 8000.0) ;"
        " PMP_a <- relative_move (4500.0, -2000.0) ; TMP_Master <- position (70.0) ;"
    ),
}
WHOLE = {
    1: "APPLICATION NAME = my_applic V 1.00 ; BASIC_PAM_CYCLE = 3 ; // 1 ms cycle\nEND",
    2: HEADER
    + "".join(
        f"NODE NOD_{name}; ADDRESS = {address} ; TYPE = {kind} ; END\n"
        for name, address, kind in [("K", 1, "SMART_IO"), ("S", 17, "ST1"), ("V", 3, "SMART_IO"), ("W", 33, "ST1")]
    ),
    3: HEADER + "NODE NOD_K; NUMBER = 3; ADDRESS = 1; TYPE = SMART_IO; END NODE NOD_S; NUMBER = 3; ADDRESS = 17;"
    " TYPE = ST1; END",
    19: HEADER + "NODES_GROUP NGR_C; NUMBER = 3; END NODE NOD_K; NODES_GROUP = NGR_C; ADDRESS = 1; TYPE = SMART_IO; END"
    " NODE NOD_S; NODES_GROUP = NGR_C; ADDRESS = 63; TYPE = ST1; END",
}  # fmt: skip
ALL = {number: MACHINE + text for number, text in LISTINGS.items()} | WHOLE
