"""Each instruction: its calls to the card, and its result out of range."""

import pytest
from arp_card import ArpBench, RecordedCard

from fieldrig_devices.arp.runtime.card import CamSwitch, Shown
from fieldrig_devices.languages.mistakes import CompileError


@pytest.mark.parametrize(
    ("line", "asked"),
    [
        ("VEL 1, 50", ("VEL", 1, 50_000)),
        ("ACC 2, 0", ("ACC", 2, 0)),
        ("DEC 1, 100", ("DEC", 1, 100_000)),
        ("HOME 2", ("HOME", 2)),
        ("PAC 1, -12.5", ("PAC", 1, -12_500)),
        ("PRC 2, V1 * 2", ("PRC", 2, 5_000)),
        ("PVC 1, 99.9", ("PVC", 1, 99_900)),
        ("STOP 2", ("STOP", 2)),
        ("PST 2, 1, V10", ("PST", 2, 1, 10)),
        ("PST 1, 2, V[V2]", ("PST", 1, 2, 40)),
        ("PID 1, 2, V50", ("PID", 1, 2, 50)),
        ("DAC 2, V1", ("DAC", 2, 2_500, 0)),
        ("DAC 1, -10, 0.01", ("DAC", 1, -10_000, 10)),
        ("CAM2 1, V1, 7, F[V2]", ("CAM", 2, CamSwitch(1, 2_500, 7_000, False, "F", 40))),
        ("CAM2", ("CAM off", 2)),
        ('MSG 500, "LENGTH: ####.#"', ("MSG", 500, "LENGTH: ####.#")),
        ("MSG 1, “A; B”", ("MSG", 1, "A; B")),
        ("TERM", ("TERM",)),
        ("TERM 6, 8", ("TERM", 6, 8)),
        ("TERM 4, 1, 1, 35", ("TERM", Shown(4, 1, 1, 35))),
        ("TERM 8, 16, 3, V2", ("TERM", Shown(8, 16, 3, 40))),
        ("TERM 5, 2, 2, 2, V100", ("TERM", Shown(5, 2, 2, 2, 100))),
        ("TERM 5, 2, 2, 2, V100, E", ("TERM", Shown(5, 2, 2, 2, 100, "E"))),
        ("TERM 5, 2, 2, 2, V[V2], p", ("TERM", Shown(5, 2, 2, 2, 40, "P"))),
        ("PRINT 0", ("PRINT", 0, None)),
        ("PRINT V2, V100", ("PRINT", 40, 100)),
    ],
)
def test_an_instruction_asks_the_card(line: str, asked: tuple[object, ...]) -> None:
    card = RecordedCard()
    card.V[1], card.V[2] = 2_500, 40_000
    ArpBench(line, card).run()
    assert (card.asked, card.warnings) == ([asked], [])


@pytest.mark.manual("ARP-047")
@pytest.mark.parametrize(
    "line",
    [
        "VEL 1, 100.001", "ACC 1, -0.001", "DEC 2, 101", "PVC 1, -1", "PAC 1, 1000.001", "PAC 1, -0.001",
        "DAC 1, 10.001", "DAC 1, -10.001", "DAC 1, 0, 0.009", "DAC 1, 0, 10.001", "PID 1, 1, V977", "PID 1, 1, V[V3]",
        "STIM 1, 0.009, F1", "STIM 1, 100.001, F1", "STIM 1, 1, F[V3]", "STIM 1, 1, F[V4]", "CAM1 1, 0, 1, O[V3]",
        "CAM1 1, 0, 1, F[V4]", "TERM 0, 1", "TERM 1, 1, 1, V3", "TERM 1, 1, 1, 1, V[V3]", "PRINT 1, V[V3]",
        "WAIT 0", "WAIT 100.001",
        "V1 == V[V3]", "V[V3] == 1", "F[V3] == HI", "O[V3] == HI", "V1 == I[V3]", "V[V5] == 1", "V1 == SQR(V5)",
    ],
)  # fmt: skip
def test_out_of_range_is_w03_and_nothing_happens(line: str) -> None:
    card = RecordedCard()
    card.parameters[1, 5], card.parameters[1, 6] = 1_000_000, 0
    card.V[1], card.V[3], card.V[4], card.V[5] = 0, 1_001_000, 260_000, -1
    variables, flags = list(card.V), list(card.F)
    ArpBench(line, card).run()
    assert card.warnings == [203]
    assert (card.asked, card.V, card.F, sum(card.O)) == ([], variables, flags, 0)


@pytest.mark.manual("ARP-047", "ARP-092", "ARP-093", "ARP-095", "ARP-097", "ARP-107", "ARP-109", "ARP-113", "ARP-116")
@pytest.mark.parametrize(
    "line",
    [
        "VEL 1, 0", "VEL 1, 100", "ACC 2, 0", "ACC 2, 100", "DEC 1, 0", "DEC 1, 100", "PVC 1, 0", "PVC 1, 100",
        "PAC 1, -500", "PAC 1, 1000", "DAC 1, -10", "DAC 2, 10", "DAC 1, 0, 0.010", "DAC 1, 0, 10", "PID 1, 1, V[V4]",
        "PID 2, 2, V976", "WAIT 0.001", "WAIT 100", "STIM 1, 0.01, F1", "STIM 6, 100, F256", "PRINT 0", "PRINT 500",
        "PRINT 1, V[V4]", "PRINT 1, V[V5]", "TERM 1, 1, 1, V4, V[V4]", "TERM 8, 16, 3, 500, V1000",
    ],
)  # fmt: skip
def test_the_limits_themselves_are_in_range(line: str) -> None:
    """Manual 5.6 to 5.11, with the ranges that its instructions have there."""
    card = RecordedCard()
    card.parameters[1, 5], card.parameters[1, 6] = 1_000_000, -500_000
    card.V[4], card.V[5] = 1_000, 1_000_000
    ArpBench(line, card).run()
    assert card.warnings == []
    assert card.asked or line.startswith(("WAIT", "STIM"))


def test_a_text_off_the_screen_is_w03_and_shown_as_far_as_it_fits() -> None:
    bench = ArpBench("TERM 2, 22, 3, 2, V100").run()
    assert bench.card.warnings == [203]
    assert bench.card.asked == [("TERM", Shown(2, 22, 3, 2, 100))]


@pytest.mark.manual("ARP-048")
def test_error_and_warning_are_read_as_numbers() -> None:
    bench = ArpBench("V1 == ERROR\nV2 == WARNING\nV3 == 1 / 0\nV4 == WARNING")
    bench.card.error_codes.append(113)
    bench.run()
    assert bench.card.V[1:5] == [113_000, 0, 0, 201_000]


def test_system_variables_of_the_axes() -> None:
    bench = ArpBench("V1 == @POS1\nV2 == #VEL2\nV3 == #LQOSP1\nV4 == #LQOSN2\n@POS2 == V06\n@POS2 += 1")
    bench.card.positions[1], bench.card.speeds[2], bench.card.V[6] = 1_234, -5, 7_000
    bench.card.latches[1, "rising"], bench.card.latches[2, "falling"] = 11, 22
    bench.run()
    assert bench.card.V[1:5] == [1_234, -5, 11, 22]
    assert bench.card.positions[2] == 8_000


@pytest.mark.manual("ARP-058")
def test_parameters_are_read_and_those_of_the_axes_written() -> None:
    bench = ArpBench("V1 == @PAR[16]\nV2 == @Par1[07]\n@par2[04] == 1\n@PAR1[8] *= 2")
    bench.card.general[16] = 20_000
    bench.card.parameters[1, 7], bench.card.parameters[1, 8] = 5_000, 100
    bench.run()
    assert (bench.card.V[1], bench.card.V[2]) == (20_000, 5_000)
    assert (bench.card.parameters[2, 4], bench.card.parameters[1, 8]) == (1_000, 200)


@pytest.mark.manual("ARP-059")
@pytest.mark.parametrize(("word", "first"), [(k, 32 * k - 31) for k in range(1, 11)])
def test_a_flag_word_is_its_32_flags(word: int, first: int) -> None:
    bench = ArpBench(f"V1 == @FLAG{word}")
    bench.card.F[first] = bench.card.F[first + 31] = 1
    assert bench.run().card.V[1] == -(2**31) + 1
    writable = ArpBench(f"@FLAG{word} == HFFFFFFFF").run().card.F
    assert sum(writable) == (32 if word <= 8 else 7)
    assert all(32 * word - 31 <= flag <= 32 * word for flag, bit in enumerate(writable) if bit)


@pytest.mark.manual("ARP-060")
@pytest.mark.parametrize("block", [1, 2, 3])
def test_words_of_outputs_and_inputs(block: int) -> None:
    bench = ArpBench(f"@OUT{block} == @OUT{block} | H80000002\nV1 == @OUT{block}\nV2 == #INP{block}")
    bench.card.O[100 * block + 1] = bench.card.I[100 * block + 8] = bench.card.I[100 * block + 32] = 1
    bench.run()
    assert (bench.card.V[1], bench.card.V[2]) == (-(2**31) + 3, -(2**31) + 0x80)
    assert [n for n, bit in enumerate(bench.card.O) if bit] == [100 * block + n for n in (1, 2, 32)]


def test_there_are_a_thousand_variables() -> None:
    assert ArpBench("V1000 == 1\nV1 == V[1000]").run().card.V[1] == 1_000


@pytest.mark.manual("ARP-062")
def test_the_index_is_the_whole_part() -> None:
    bench = ArpBench("V[V1] == 7\nF[V1] == HI\nO[V2] == F[V1]\nV3 == O[V2]")
    bench.card.V[1], bench.card.V[2] = 50_999, 332_001
    bench.run()
    assert (bench.card.V[50], bench.card.F[50], bench.card.O[332], bench.card.V[3]) == (7_000, 1, 1, 1_000)


@pytest.mark.manual("ARP-062")
@pytest.mark.parametrize(
    ("letter", "first", "last"), [("V", 1, 1000), ("F", 1, 217), ("O", 101, 132), ("O", 201, 232), ("O", 301, 332)]
)
def test_the_first_and_the_last_one_can_be_indexed(letter: str, first: int, last: int) -> None:
    raw_1 = "H1" if letter == "V" else "HI"
    bench = ArpBench(f"V900 == {first}\n{letter}[V900] == {raw_1}\nV900 == {last}\n{letter}[V900] == {raw_1}")
    values = getattr(bench.run(10).card, letter)
    assert (values[first], values[last], bench.card.warnings) == (1, 1, [])


@pytest.mark.manual("ARP-062")
@pytest.mark.parametrize(
    ("letter", "number"),
    [("V", 0), ("V", 1001), ("F", 0), ("F", 321), ("O", 100), ("O", 133), ("O", 333), ("I", 100), ("I", 133)],
)
def test_an_index_out_of_range_reads_0_is_not_written_and_is_w03(letter: str, number: int) -> None:
    """Digest 2, as the manual does not mention it."""
    bench = ArpBench(f"V1 == {number}\nV2 == 7\nV2 == {letter}[V1]").run(10)
    assert (bench.card.V[2], bench.card.warnings) == (0, [203])
    if letter != "I":
        bench = ArpBench(f"{letter}[V999] == 1")
        bench.card.V[999] = number * 1000
        before = list(getattr(bench.card, letter))
        bench.run(10)
        assert (getattr(bench.card, letter), bench.card.warnings) == (before, [203])


@pytest.mark.manual("ARP-062", "ARP-065")
def test_a_flag_that_only_the_system_writes_keeps_its_value() -> None:
    bench = ArpBench("F[V1] == HI\nF[V2] == HI")
    bench.card.V[1], bench.card.V[2] = 260_000, 262_000
    bench.run()
    assert (bench.card.F[260], bench.card.F[262], bench.card.warnings) == (0, 1, [])


@pytest.mark.manual("ARP-111")
@pytest.mark.parametrize("target", ["F1", "F256", "F262", "O101", "O332", "F[V1]", "O[V2]"])
def test_set_and_res(target: str) -> None:
    bench = ArpBench(f"SET {target}\nV3 == {target}\nRES {target}\nV4 == {target}")
    bench.card.V[1], bench.card.V[2] = 5_000, 205_000
    bench.run()
    assert bench.card.V[3:5] == [1_000, 0]


@pytest.mark.manual("ARP-080")
@pytest.mark.parametrize(
    ("line", "raw"),
    [
        ("V1 += 2", 7_000), ("V1 -= 2", 3_000), ("V1 *= 2", 10_000), ("V1 /= 2", 2_500), ("V1 \\= 2", 2_500),
        ("V1 %= 2", 1_000), ("V1 &= H0F", 8), ("V1 |= H0F", 5_007), ("V1 ^= H0F", 5_000 ^ 15), ("V1 <<= 2", 20_000),
        ("V1 >>= 2", 1_250), ("V1 == !V1", -5_001), ("V1 == -V1", -5_000), ("V1 == +V1", 5_000),
    ],
)  # fmt: skip
def test_assignments_with_an_operation(line: str, raw: int) -> None:
    bench = ArpBench(line)
    bench.card.V[1] = 5_000
    assert bench.run().card.V[1] == raw


@pytest.mark.manual("ARP-080")
@pytest.mark.parametrize(
    ("line", "bit"),
    [
        ("F1 == !I123", 1), ("F1 == F2", 1), ("F1 == F2 & F3", 0), ("F1 == F2 | F3", 1), ("F1 == F2 ^ HI", 0),
        ("F1 == !(F2 & F3)", 1), ("F1 &= LO", 0), ("F1 |= F2", 1), ("F1 ^= F2", 0), ("F1 == 1", 1), ("F1 == 0", 0),
    ],
)  # fmt: skip
def test_assignments_of_bits(line: str, bit: int) -> None:
    bench = ArpBench(line)
    bench.card.F[1], bench.card.F[2] = 1, 1
    assert bench.run().card.F[1] == bit


@pytest.mark.manual("ARP-080")
@pytest.mark.parametrize(
    "line", ["F1 == F2 & V1", "F1 == V1 | F2", "F1 ^= F2 ^ 2", "O101 == !(V1 & F2)", "F1 &= F2 + 0"]
)
def test_an_operation_on_a_bit_and_a_number_gives_a_number(line: str) -> None:
    with pytest.raises(CompileError, match="a number cannot be assigned to one bit"):
        ArpBench(line)


@pytest.mark.manual("ARP-085")
@pytest.mark.parametrize(
    ("condition", "is_true"),
    [
        ("V1 = 5", True), ("V1 <> 5", False), ("V1 < 5", False), ("V1 <= 5", True), ("V1 > 4.999", True),
        ("V1 >= 5.001", False), ("5 = V1", True), ("V1 = V2 + 3", True), ("V1 * 2 > V2 * 4", True), ("F2 = HI", True),
        ("F2 = LO", False), ("F2 = ON", True), ("F3 = OFF", True), ("F2 & F3 = HI", False), ("F2 | F3 = HI", True),
        ("(I101 & F2) = LO", True), ("!F3 = HI", True), ("F2 = F3", False), ("F2 <> F3", True), ("F2 > F3", True),
        ("F2 = 1", True), ("V1 = H1388", True), ("V1 = F2 * 5", True), ("HI = F2", True), ("I[V3] = LO", True),
        ("V4 = H0005", True), ("V4 = 5", False), ("!(F2 & HI) = LO", True), ("!(F3 & HI) = HI", True),
        ("!(LO | F3) = HI", True),
    ],
)  # fmt: skip
def test_conditions(condition: str, is_true: bool) -> None:
    bench = ArpBench(f"IF {condition}, SET O101\nIF {condition}, THERE\nSET O102\nTHERE:\nSET O103")
    bench.card.V[1], bench.card.V[2], bench.card.V[3], bench.card.V[4], bench.card.F[2] = 5_000, 2_000, 101_000, 5, 1
    bench.run()
    assert (bench.card.O[101], bench.card.O[102], bench.card.O[103]) == (int(is_true), int(not is_true), 1)


def test_an_if_within_an_if_and_a_call_in_it() -> None:
    bench = ArpBench("BEG M\nIF F1 = HI, IF F2 = HI, CALL S\nSET O102\nEND\nBEG S\nSET O101\nEND")
    bench.card.F[1] = 1
    assert (bench.run().card.O[101], bench.card.O[102]) == (0, 1)
    bench.card.F[2] = 1
    bench.program.start()
    assert bench.run().card.O[101] == 1


@pytest.mark.manual("ARP-109")
def test_a_timer_that_is_started_again_forgets_its_flag() -> None:
    bench = ArpBench("STIM 1, 0.01, F1\nSTIM 2, 100, F2\nSTIM 1\nWAIT 1")
    assert bench.run(200).card.F[1] == 0


@pytest.mark.manual("ARP-110")
def test_a_timer_never_started_reads_0() -> None:
    assert ArpBench("V1 == TIM 6").run().card.V[1] == 0


@pytest.mark.manual("ARP-108")
def test_six_timers_run_at_the_same_time() -> None:
    starts = "\n".join(f"STIM {n}\nWAIT 0.01" for n in range(1, 7))
    reads = "\n".join(f"V{n} == TIM {n}" for n in range(1, 7))
    assert ArpBench(f"{starts}\n{reads}").run(100).card.V[1:7] == [60, 50, 40, 30, 20, 10]
