"""The nodes that devices offer, without a bus: points, methods, and the variables of a real program."""

import pytest

from fieldrig.clock import VirtualClock
from fieldrig.device import Point
from fieldrig.testing import RecordedLink
from fieldrig_bus.opcua import codec
from fieldrig_bus.opcua import message as opc
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.runtime import Runtime, Start
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.opcua.face import OpcUaFace
from fieldrig_devices.opcua.methods import Method, MethodsTree
from fieldrig_devices.opcua.points import PointsTree
from fieldrig_devices.opcua.symbols import SymbolsTree
from fieldrig_devices.opcua.tree import NodeTree, Trees, UnknownNodeError

PROGRAM = """
TYPE Colour : (red, green := 5); END_TYPE
TYPE Axis : STRUCT speed : REAL; (* in mm/s *) END_STRUCT END_TYPE
FUNCTION_BLOCK Belt VAR_INPUT position : DINT := 7; END_VAR VAR axes : ARRAY[1..2] OF Axis; END_VAR END_FUNCTION_BLOCK
VAR_GLOBAL grid : ARRAY[0..1, 5..6] OF INT; END_VAR
VAR_GLOBAL CONSTANT highest : INT := 3; END_VAR
PROGRAM PLC_PRG
VAR belt : Belt; wait : TIME := T#1s500ms; name : STRING(10) := 'abc'; small : INT(0..10); colour : Colour;
    values : ARRAY[1..3] OF INT := 1, 2, 3; (* the last three *) END_VAR
belt.position := belt.position;
END_PROGRAM
"""


@pytest.fixture
def tree() -> SymbolsTree:
    host = StandaloneHost(VirtualClock())
    compiled = compile_project([SourceFile("plc.st", PROGRAM)], host)
    runtime = Runtime(compiled, host)
    runtime.initialise(Start.COLD)
    return SymbolsTree(compiled.symbols, runtime)


def paths(tree: NodeTree, path: str) -> list[str]:
    return [node.path for node in tree.children(path)]


def test_programs_and_their_parts_have_the_paths_of_the_source(tree: SymbolsTree) -> None:
    assert set(paths(tree, "")) >= {"PLC_PRG", "grid", "highest"}
    assert set(paths(tree, "PLC_PRG")) == {
        f"PLC_PRG.{name}" for name in ("belt", "wait", "name", "small", "colour", "values")
    }
    assert paths(tree, "PLC_PRG.belt.axes") == ["PLC_PRG.belt.axes[1]", "PLC_PRG.belt.axes[2]"]
    assert paths(tree, "PLC_PRG.belt.axes[2]") == ["PLC_PRG.belt.axes[2].speed"]
    assert tree.find("plc_prg.BELT.position") == opc.Node(
        "PLC_PRG.belt.position", "PLC_PRG.belt", "position", opc.Kind.VARIABLE, "DINT", is_writable=True
    )


def test_every_node_is_a_child_of_its_parent(tree: SymbolsTree) -> None:
    waiting, seen = [""], 0
    while waiting:
        path = waiting.pop()
        for node in tree.children(path):
            assert (node.parent, tree.find(node.path)) == (path, node)
            assert bool(tree.children(node.path)) is node.has_children
            waiting.append(node.path)
            seen += 1
    assert seen > 20


def test_types_ranges_choices_units_and_comments(tree: SymbolsTree) -> None:
    def node(path: str) -> opc.Node:
        found = tree.find(path)
        assert found is not None
        return found

    assert (node("PLC_PRG.wait").type, node("PLC_PRG.wait").unit) == ("TIME", "ms")
    assert (node("PLC_PRG.small").low, node("PLC_PRG.small").high) == (0, 10)
    assert node("PLC_PRG.colour").choices == (("red", 0), ("green", 5))
    assert (node("PLC_PRG.values").type, node("PLC_PRG.values").length) == ("INT", 3)
    assert node("PLC_PRG.values").about == "the last three"
    assert (node("grid").kind, node("grid[1]").length) == (opc.Kind.OBJECT, 2)
    assert not node("highest").is_writable


def test_values_are_read_and_written(tree: SymbolsTree) -> None:
    assert [tree.read(f"PLC_PRG.{name}") for name in ("wait", "name", "values", "belt.position")] == [
        1_500, "abc", [1, 2, 3], 7,
    ]  # fmt: skip
    tree.write("PLC_PRG.values", [4, 5, 6])
    tree.write("PLC_PRG.values[2]", 9)
    tree.write("grid[1,6]", -1)
    assert (tree.read("PLC_PRG.values"), tree.read("grid[1]")) == ([4, 9, 6], [0, -1])


def test_what_can_t_be_written_is_refused(tree: SymbolsTree) -> None:
    wrong: list[tuple[str, opc.AnyValue]] = [("PLC_PRG.values", [1]), ("PLC_PRG.small", 11), ("highest", 4)]
    for path, value in wrong:
        with pytest.raises(ValueError, match="expected"):
            tree.write(path, value)
    with pytest.raises(TypeError):
        tree.write("PLC_PRG.values", 1)
    for path in ("PLC_PRG", "PLC_PRG.none", "PLC_PRG.values[4]", ""):
        with pytest.raises(UnknownNodeError):
            tree.read(path)


# ---- points and methods


def test_the_parts_of_a_key_are_objects() -> None:
    points = {
        "a.b.c": Point(lambda: 1),
        "a.b": Point(lambda: "x", lambda _: None, "mm", "text"),
        "d": Point(lambda: 2.0),
    }
    tree = PointsTree(lambda: points)
    assert (paths(tree, ""), paths(tree, "a"), paths(tree, "a.b")) == (["a", "d"], ["a.b"], ["a.b.c"])
    assert tree.find("a") == opc.Node("a", "", "a", opc.Kind.OBJECT, has_children=True)
    assert tree.find("a.b") == opc.Node("a.b", "a", "b", opc.Kind.VARIABLE, "STRING", None, True, True, "mm", "text")
    assert tree.find("e") is None


@pytest.mark.parametrize(
    ("value", "name"), [(True, "BOOL"), (1, "DINT"), (2**31, "LINT"), (1.0, "LREAL"), ("x", "STRING")]
)
def test_a_point_has_the_type_of_its_value(value: bool | int | float | str, name: str) -> None:
    found = PointsTree(lambda: {"x": Point(lambda: value)}).find("x")
    assert found is not None
    assert found.type == name


# ---- the face


class FaceBench:
    def __init__(self) -> None:
        self.link = RecordedLink[opc.OpcUaMessage]()
        self.value: object = 1

        def write(value: object) -> None:
            if value == 13:
                raise ValueError("expected another number")
            self.value = value

        points = {f"p{number}": Point(lambda: 0) for number in range(opc.MOST_NODES + 5)}
        points["x"] = Point(lambda: 1, write)
        methods = MethodsTree({"go": Method("go", lambda: None), "halt": Method("halt", self.halt)})
        self.face = OpcUaFace("io", "an IO", self.link, lambda: Trees([PointsTree(lambda: points), methods]))

    def halt(self) -> None:
        raise ValueError("it does not run")

    def ask(self, request: opc.OpcUaMessage) -> opc.OpcUaMessage:
        self.link.deliver(request)
        [answer] = self.link.take()
        return answer


def test_each_offer_has_its_own_generation() -> None:
    bench = FaceBench()
    bench.face.offer()
    bench.face.offer()
    assert bench.link.take() == [opc.Offer("io", "an IO", 1), opc.Offer("io", "an IO", 2)]


def test_many_children_come_in_parts() -> None:
    bench = FaceBench()
    first, second = (bench.ask(opc.Browse("io", 1, "", start)) for start in (0, opc.MOST_NODES))
    assert isinstance(first, opc.Nodes)
    assert isinstance(second, opc.Nodes)
    assert (len(first.nodes), first.is_complete, len(second.nodes), second.is_complete) == (
        opc.MOST_NODES,
        False,
        8,
        True,
    )


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (opc.Write("io", 1, "x", 2), opc.Status.GOOD),
        (opc.Write("io", 1, "x", 13), opc.Status.OUT_OF_RANGE),
        (opc.Write("io", 1, "x", [1]), opc.Status.TYPE_MISMATCH),
        (opc.Write("io", 1, "p1", 2), opc.Status.NOT_WRITABLE),
        (opc.Write("io", 1, "go()", 2), opc.Status.NOT_WRITABLE),
        (opc.Write("io", 1, "none", 2), opc.Status.UNKNOWN),
        (opc.Call("io", 1, "go()"), opc.Status.GOOD),
        (opc.Call("io", 1, "halt()"), opc.Status.REFUSED),
        (opc.Call("io", 1, "x"), opc.Status.UNKNOWN),
    ],
)
def test_a_request_has_its_status(request_: opc.OpcUaMessage, status: opc.Status) -> None:
    answer = FaceBench().ask(request_)
    assert isinstance(answer, opc.Outcomes)
    assert (answer.exchange, [outcome.status for outcome in answer.outcomes]) == (1, [status])


def test_values_come_in_the_order_of_the_paths() -> None:
    assert FaceBench().ask(opc.Read("io", 4, ("x", "none", "p1"))) == opc.Outcomes(
        4, (opc.Outcome(opc.Status.GOOD, 1), opc.Outcome(opc.Status.UNKNOWN), opc.Outcome(opc.Status.GOOD, 0))
    )
    assert FaceBench().ask(opc.Find("io", 5, "none")) == opc.Nodes(5, ())


# ---- what is too large for one message


def face_of(*trees: NodeTree) -> RecordedLink[opc.OpcUaMessage]:
    link = RecordedLink[opc.OpcUaMessage]()
    OpcUaFace("io", "an IO", link, lambda: Trees(trees))
    return link


def answers(link: RecordedLink[opc.OpcUaMessage], request: opc.OpcUaMessage) -> opc.OpcUaMessage:
    link.deliver(request)
    [answer] = link.take()
    codec.check_sent(answer)
    return answer


@pytest.mark.long
def test_long_comments_are_cut_and_many_names_of_an_enumeration_come_in_parts() -> None:
    names = ", ".join(f"value_{number}_{'x' * 20}" for number in range(1_000))
    text = (
        f"TYPE Wide : ({names}); END_TYPE VAR_GLOBAL "
        + "".join(f"v{number} : Wide; " for number in range(99))
        + f"last : INT; (* {'c' * 5_000} *) END_VAR PROGRAM PLC_PRG last := 1; END_PROGRAM"
    )
    host = StandaloneHost(VirtualClock())
    compiled = compile_project([SourceFile("plc.st", text)], host)
    link = face_of(SymbolsTree(compiled.symbols, Runtime(compiled, host)))
    found, is_complete = list[opc.Node](), False
    while not is_complete:
        answer = answers(link, opc.Browse("io", 1, "", len(found)))
        assert isinstance(answer, opc.Nodes)
        assert answer.nodes
        found += answer.nodes
        is_complete = answer.is_complete
    assert [node.path for node in found if node.path != "PLC_PRG"] == [*(f"v{n}" for n in range(99)), "last"]
    assert {len(node.choices) for node in found} == {0, 1_000}
    [comment] = [node.about for node in found if node.path == "last"]
    assert comment == "c" * opc.LONGEST_TEXT


def test_large_values_come_in_parts_and_one_that_fits_into_no_message_is_refused() -> None:
    half, whole = "x" * 500_000, "x" * 2_000_000
    link = face_of(PointsTree(lambda: {"half": Point(lambda: half), "whole": Point(lambda: whole)}))
    answer = answers(link, opc.Read("io", 1, ("half", "half", "half", "whole")))
    assert answer == opc.Outcomes(1, (opc.Outcome(opc.Status.GOOD, half),) * 2)
    assert answers(link, opc.Read("io", 2, ("whole", "half"))) == opc.Outcomes(
        2, (opc.Outcome(opc.Status.TOO_LARGE), opc.Outcome(opc.Status.GOOD, half))
    )


def test_the_reason_of_a_refusal_has_an_end() -> None:
    def refuse(value: object) -> None:
        raise ValueError(f"expected something else than {value}")

    link = face_of(PointsTree(lambda: {"x": Point(lambda: "", refuse)}))
    answer = answers(link, opc.Write("io", 1, "x", "y" * 100_000))
    assert isinstance(answer, opc.Outcomes)
    assert [(outcome.status, len(outcome.text)) for outcome in answer.outcomes] == [
        (opc.Status.OUT_OF_RANGE, opc.LONGEST_TEXT)
    ]


def test_a_path_that_no_node_id_can_have_is_no_node() -> None:
    types = "TYPE T0 : STRUCT last : INT; END_STRUCT END_TYPE "
    names = [f"{'n' * 120}{number}" for number in range(1, 39)]
    for number, name in enumerate(names, 1):
        types += f"TYPE T{number} : STRUCT {name} : T{number - 1}; END_STRUCT END_TYPE "
    text = f"{types} VAR_GLOBAL deep : T{len(names)}; END_VAR PROGRAM PLC_PRG ; END_PROGRAM"
    host = StandaloneHost(VirtualClock())
    compiled = compile_project([SourceFile("plc.st", text)], host)
    tree = SymbolsTree(compiled.symbols, Runtime(compiled, host))
    link, path, depth = face_of(tree), "deep", 0
    while nodes := getattr(answers(link, opc.Browse("io", 1, path)), "nodes", ()):
        [node] = nodes
        path, depth = node.path, depth + 1
    assert 0 < depth < len(names)
    assert opc.LONGEST_PATH - 123 < len(path) <= opc.LONGEST_PATH
    assert tree.find(".".join(["deep", *reversed(names), "last"])) is None
