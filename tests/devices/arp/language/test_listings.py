"""The listings of the manual, with the marks of its text removed, run on a recorded card (digest chapter 19)."""

import pytest
from arp_card import ArpBench, RecordedCard
from arp_listings import EXAMPLE2, EXEMPLE1, TEST_PID

from fieldrig_devices.arp.language.compiler import Compiled
from fieldrig_devices.arp.runtime.card import CamSwitch
from fieldrig_devices.arp.runtime.program import ProgramState


@pytest.mark.manual("ARP-120")
def test_exemple1_arms_its_cams_and_events_once() -> None:
    bench = ArpBench(EXEMPLE1).run(5)
    assert bench.card.parameters[1, 4] == bench.card.parameters[2, 4] == 0
    assert bench.card.asked == [
        ("CAM", 1, CamSwitch(1, 5_000_000, 15_000_000, False, "O", 101)),
        ("CAM", 2, CamSwitch(1, 15_000_000, 5_000_000, False, "O", 102)),
    ]
    bench.card.positions[1] = 1_234_567
    bench.run()
    assert bench.card.V[1] == 1_234_567


@pytest.mark.manual("ARP-087")
def test_exemple1_serves_the_position_while_its_flag_is_high() -> None:
    bench = ArpBench(EXEMPLE1).run(2)
    bench.card.positions[1] = 5_000_001
    assert bench.run(3).card.O[103] == 0  # F2 is low
    bench.card.F[2] = 1
    bench.run()
    assert (bench.card.O[103], bench.card.F[2]) == (1, 0)


@pytest.mark.manual("ARP-087")
def test_exemple1_serves_the_rising_edge_of_f4() -> None:
    bench = ArpBench(EXEMPLE1).run(2)
    bench.card.F[3] = 1
    assert bench.run(3).card.O[104] == 0
    bench.card.F[4] = 1
    bench.run()
    assert (bench.card.O[104], bench.card.F[3]) == (1, 0)


def test_example2_follows_the_flags_of_its_axes_for_ever() -> None:
    bench = ArpBench(EXAMPLE2)
    card = bench.run(1_000).card
    assert (card.parameters[2, 4], card.parameters[1, 4], card.V[10]) == (1_000, 2_000, 0)  # still in wait 1
    bench.run(5)
    assert card.V[10:17] == [3_000, 0, 0, 5_000_000, 5_000_000, 10_000_000, 0]
    assert card.asked == [("PST", 2, 1, 10)]
    card.F[261] = 1
    bench.run(2_000)
    assert len(card.asked) == 1  # the master has not arrived yet
    card.F[292] = 1
    for _ in range(3):
        assert bench.run(1_001).card.asked[-1] == ("PAC", 2, 10_000_000)
        assert bench.run(1_001).card.asked[-1] == ("PAC", 2, 0)
    assert bench.program.state is ProgramState.RUNNING


@pytest.mark.manual("ARP-086")
def test_test_pid_shows_the_tension_on_an_analog_output() -> None:
    card = RecordedCard(channels={1: 123_456})
    card.V[68] = 400_000
    ArpBench(TEST_PID, card).run(1)
    assert card.parameters[2, 4] == 3_000
    assert card.asked[:2] == [("PID", 1, 2, 50), ("DAC", 1, 8_000, 0)]
    assert card.V[10:12] == [123_456, 8_000]
    card.V[68] = -333
    assert ArpBench(TEST_PID, card).run().card.asked[-1] == ("DAC", 1, -6, 0)


@pytest.mark.manual("ARP-083")
def test_a01_the_output_is_set_when_the_counter_passes_100() -> None:
    bench = ArpBench("""\
L00:
    IF V1 > 100, L01     ; jumps to L01 if the condition is verified
    V1 += 1
    GOTO L00
L01:
    SET O101
    GOTO L00""")
    bench.run(1, budget=3 * 101)
    assert (bench.card.V[1], bench.card.O[101]) == (101_000, 0)
    assert bench.run(1, budget=2).card.O[101] == 1


@pytest.mark.manual("ARP-062")
def test_a02_variables_address_variables() -> None:
    bench = ArpBench("V1 == V100\nV2 == (V100 + V101) / V5\nV1 == 50\nV10 == V[V1]")
    bench.card.V[100], bench.card.V[101], bench.card.V[5], bench.card.V[50] = 7_000, 2_000, 4_000, 12_345
    bench.run()
    assert (bench.card.V[2], bench.card.V[1], bench.card.V[10]) == (2_250, 50_000, 12_345)


def test_a03_flags_from_inputs_and_flags() -> None:
    bench = ArpBench("If F10 = lo, set F101\nF112 == I102\nF23 == F[V2]")
    bench.card.I[102], bench.card.V[2], bench.card.F[77] = 1, 77_000, 1
    bench.run()
    assert (bench.card.F[101], bench.card.F[112], bench.card.F[23]) == (1, 1, 1)


@pytest.mark.manual("ARP-062")
def test_a04_every_line_of_the_valid_list() -> None:
    bench = ArpBench("""\
V1 == 55                ;assignment with constant
V3 == V2                ;assignment through variable
V4 == V[V10]            ;index assignment through V10
PAC 1, V3
WAIT V11
V[V1] == 0              ;indexed variables zeroing
F[V1] == lo
F100 == I[V12]
O[V20] == F20""")
    card = bench.card
    card.V[2], card.V[10], card.V[11], card.V[12], card.V[20] = 9_000, 2_000, 3, 101_000, 104_000
    card.V[55], card.F[55], card.I[101], card.F[20] = 1, 1, 1, 1
    bench.run(5)
    assert (card.V[3], card.V[4], card.asked) == (9_000, 9_000, [("PAC", 1, 9_000)])
    assert (card.V[55], card.F[55], card.F[100], card.O[104]) == (0, 0, 1, 1)


@pytest.mark.manual("ARP-077")
@pytest.mark.manual("ARP-084")
def test_a05_subprograms_run_in_the_order_of_their_calls() -> None:
    bench = ArpBench("""\
BEG PROG1
CALL SUB01
CALL SUB02
V3 == V1
END
BEG SUB02
V1 == V1 * 10 + 2
END
BEG SUB01
V1 == V1 * 10 + 1
END""").run()
    assert bench.card.V[3] == 12_000
    assert bench.program.state is ProgramState.ENDED


@pytest.mark.manual("ARP-085")
@pytest.mark.parametrize(("v100", "v5", "i101", "f10"), [(1, 99_999, 0, 0), (0, 100_000, 1, 1), (1, 0, 1, 0)])
def test_a06_four_forms_of_if(v100: int, v5: int, i101: int, f10: int) -> None:
    bench = ArpBench("""\
BEG MAIN
IF V100 = V9, V1 == 0
IF V5 < 100, CALL SBR01
IF I101 = LO, V10 == 10
IF (I101 & F10) = HI, SET O101
END
BEG SBR01
V2 == 1
END""")
    card = bench.card
    card.V[1], card.V[100], card.V[5], card.I[101], card.F[10] = 5, v100, v5, i101, f10
    bench.run()
    assert card.V[1] == (0 if v100 == 0 else 5)
    assert card.V[2] == (1_000 if v5 < 100_000 else 0)
    assert card.V[10] == (10_000 if not i101 else 0)
    assert card.O[101] == (i101 & f10)


@pytest.mark.manual("ARP-076")
@pytest.mark.manual("ARP-111")
def test_a07_a_loop_waits_for_an_input() -> None:
    bench = ArpBench("BEGINNING:\nHOME 1\nRES O101\nLOOP:\nIF I101 = LO, LOOP\nSET O102")
    bench.card.O[101] = 1
    bench.run(10)
    assert (bench.card.O[101], bench.card.O[102], bench.card.asked) == (0, 0, [("HOME", 1)])
    bench.card.I[101] = 1
    assert bench.run().card.O[102] == 1


@pytest.mark.manual("ARP-078")
@pytest.mark.manual("ARP-086")
def test_a08_three_spellings_are_one_symbol() -> None:
    bench = ArpBench("""\
QUOTA1 EQU V100
VEL1   EQU V22
Vel1   EQU V22
VEL1   equ v22
TAGLIO EQU O101
beg Main
quota1 == vEL1 + 1
SET taglio
end""")
    bench.card.V[22] = 5_000
    bench.run()
    assert (bench.card.V[100], bench.card.O[101]) == (6_000, 1)
    compiled = bench.program.compiled
    assert isinstance(compiled, Compiled)
    assert [note.line for note in compiled.notes] == [3, 4]


@pytest.mark.manual("ARP-086")
def test_each_kind_of_resource_has_a_symbolic_name() -> None:
    bench = ArpBench("""\
FAST EQU @PAR1[7]
READY EQU F30
START EQU I101
LAST EQU NEWEST
NEWEST EQU V1
FIRST EQU V[POINTER]
POINTER EQU V2
BEG MAIN
LAST == FAST
READY == START
FIRST == 7
END""")
    bench.card.parameters[1, 7] = 55_500
    bench.card.I[101] = 1
    bench.card.V[2] = 40_000
    bench.run()
    assert (bench.card.V[1], bench.card.F[30], bench.card.V[40]) == (55_500, 1, 7_000)


@pytest.mark.manual("ARP-053")
@pytest.mark.manual("ARP-059")
@pytest.mark.manual("ARP-079")
def test_a09_words_and_masks() -> None:
    bench = ArpBench("""\
V1 == @FLAG1
V2 == V1 & H00FF
V3 == @FLAG1 & HFFFFFF00
V4 == H1388
V5 == 1000.000
V6 == h1000""")
    for flag in (1, 3, 9, 32):
        bench.card.F[flag] = 1
    bench.run()
    assert bench.card.V[1] == -(2**31) + 0x105
    assert bench.card.V[2] == 5
    assert bench.card.V[3] == -(2**31) + 0x100
    assert bench.card.V[4:7] == [5_000, 1_000_000, 4_096]
    assert bench.card.warnings == []


@pytest.mark.manual("ARP-079")
@pytest.mark.parametrize(
    ("literal", "raw"),
    [
        ("1000.000", 1_000_000),
        ("-12.5", -12_500),
        ("H1000", 4_096),  # "equal to the decimal 4096", as a raw value
        ("h1000", 4_096),
        ("PIG", 3_142),
        ("HI", 1_000),
        ("ON", 1_000),
        ("LO", 0),
        ("OFF", 0),
    ],
)
def test_literals_and_constants_have_the_values_of_the_manual(literal: str, raw: int) -> None:
    bench = ArpBench(f"V1 == 7\nV1 == {literal}\nV2 == {literal} + 1").run()
    assert bench.card.V[1:3] == [raw, raw + 1_000]


@pytest.mark.manual("ARP-079")
@pytest.mark.parametrize(("literal", "bit"), [("HI", 1), ("ON", 1), ("LO", 0), ("OFF", 0)])
def test_constants_are_levels_of_flags_and_outputs(literal: str, bit: int) -> None:
    bench = ArpBench(f"F1 == {literal}\nO101 == {literal}")
    bench.card.F[1] = bench.card.O[101] = 1 - bit
    bench.run()
    assert (bench.card.F[1], bench.card.O[101]) == (bit, bit)


def test_a10_analog_inputs_and_outputs() -> None:
    bench = ArpBench("V001 == ADC 2\nDAC 1, 5, 2\nDAC 2, V001\nDAC 1, -10")
    bench.card.channels[2] = 2_500
    bench.run()
    assert bench.card.V[1] == 2_500
    assert bench.card.asked == [("DAC", 1, 5_000, 2_000), ("DAC", 2, 2_500, 0), ("DAC", 1, -10_000, 0)]


@pytest.mark.manual("ARP-109")
def test_a11_the_flag_of_a_timer_goes_low_and_after_5_s_high() -> None:
    bench = ArpBench("STIM 1, 5, F1\nLOOP:\nGOTO LOOP")
    bench.card.F[1] = 1
    bench.run(5_000)
    assert bench.card.F[1] == 0
    assert bench.run(1).card.F[1] == 1


@pytest.mark.manual("ARP-108")
@pytest.mark.manual("ARP-110")
def test_a12_a_loop_leaves_after_one_second() -> None:
    bench = ArpBench("STIM 2\nLINEA:\nV1 == TIM 2\nIF V1 < 1, LINEA\nSET O101")
    bench.run(1_000)
    assert (bench.card.O[101], bench.card.V[1]) == (0, 999)
    assert bench.run(1).card.O[101] == 1


def test_a13_six_cams_one_inverted_and_off_again() -> None:
    bench = ArpBench("""\
X2 EQU V2
X3 EQU V3
beg M
cam1 1, X2, X3, O101
cam6 1, X3, X2, !O106
cam3 2, -1.5, V[V9], F9
cam1
end""")
    bench.card.V[2], bench.card.V[3], bench.card.V[9] = 20_000, 30_000, 3_000
    assert bench.run().card.asked == [
        ("CAM", 1, CamSwitch(1, 20_000, 30_000, False, "O", 101)),
        ("CAM", 6, CamSwitch(1, 30_000, 20_000, True, "O", 106)),
        ("CAM", 3, CamSwitch(2, -1_500, 30_000, False, "F", 9)),
        ("CAM off", 1),
    ]


def test_a17_the_table_of_a_cam_is_filled_through_an_index() -> None:
    bench = ArpBench("""\
V1 == 11
LOOP:
V[V1] == V2
V2 += 500
V1 += 1
IF V1 < 23, LOOP
V10 == 6
PST 2, 1, V10""")
    bench.run(5)
    assert bench.card.V[10:23] == [6_000, *range(0, 6_000_000, 500_000)]
    assert bench.card.asked == [("PST", 2, 1, 10)]


@pytest.mark.manual("ARP-098")
def test_a21_a_second_move_holds_the_program_on_its_line() -> None:
    bench = ArpBench("PAC 1, 100\nPAC 1, 200\nSET O101")
    bench.run()
    assert bench.program.state is ProgramState.ENDED  # this card never reports motion
    bench.card.asked.clear()
    bench.card.O[101] = 0
    bench.card.F[263] = 1
    bench.program.start()
    bench.run(50)
    assert (bench.card.asked, bench.program.place.line) == ([], 2)
    bench.card.F[263] = 0
    bench.run()
    assert (bench.card.asked, bench.card.O[101]) == ([("PAC", 1, 100_000), ("PAC", 1, 200_000)], 1)


def test_a22_counts_per_unit_of_the_example() -> None:
    assert ArpBench("V1 == 2000 * 4 / (1000 / 12)").run().card.V[1] == 96_000  # 83.333 rounds the quotient to 96.000
