"""`/metrics`, read by Prometheus' own parser."""

from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import PageBench, bearer, page_of
from prometheus_client.parser import text_string_to_metric_families

from fieldrig_page.metrics import _of_bus

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"

pytestmark = pytest.mark.long


async def figures(page: PageBench) -> dict[tuple[str, frozenset[tuple[str, str]]], float]:
    answer = await page.request("GET", "/metrics", headers=bearer("look"))
    assert answer.status == 200
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    families = text_string_to_metric_families(answer.body.decode())
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in families
        for sample in family.samples
    }


def labels(**given: str) -> frozenset[tuple[str, str]]:
    return frozenset(given.items())


@in_loop
async def test_figures_of_rig_processes_and_buses_are_there() -> None:
    async with page_of(LAB) as page:
        await page.ask("rig/step", {"ns": 1_000_000_000})
        found = await figures(page)
        assert found["fieldrig_up", labels()] == 1
        assert found["fieldrig_virtual_time_seconds", labels()] == 1
        assert found["fieldrig_process_ready", labels(process="lab")] == 1
        assert found["fieldrig_process_memory_bytes", labels(process="lab")] > 1e6
        assert found["fieldrig_bus_frames", labels(bus="can0")] > 0
        assert 0 <= found["fieldrig_bus_load_ratio", labels(bus="can0")] <= 1
        assert found["fieldrig_bus_tec", labels(bus="can0", member="io")] == 0


def test_what_a_ring_counts_of_a_member_has_the_member_as_a_label() -> None:
    statistics = {
        "late": 5.0,
        "late.film": 3.0,
        "film.tec": 1.0,
        "socketcand:1.tec": 2.0,
        "load_percent": 50.0,
        "trip_p50_us": 250.0,
    }
    found = {(sample.name, sample.labels): sample.value for sample in _of_bus("ring", statistics, {"film"})}
    bus, film = ("bus", "ring"), ("member", "film")
    assert found == {
        ("bus_late", (bus,)): 5.0,
        ("bus_member_late", (bus, film)): 3.0,
        ("bus_tec", (bus, film)): 1.0,
        ("bus_tec", (bus, ("member", "socketcand:1"))): 2.0,
        ("bus_load_ratio", (bus,)): 0.5,
        ("bus_trip_p50_seconds", (bus,)): 0.00025,
    }


def test_no_figure_of_a_bus_has_another_unit_than_a_base_unit() -> None:
    """Prometheus has seconds, bytes and ratios (prometheus.io/docs/practices/naming, "Base units")."""
    given = {"load_percent": 25.0, "trip_p99_us": 5.0, "gap_ms": 2.0, "jitter_ns": 7.0, "frames": 3.0}
    found = {sample.name: sample.value for sample in _of_bus("ring", given, ())}
    assert found == {
        "bus_load_ratio": 0.25,
        "bus_trip_p99_seconds": 5e-6,
        "bus_gap_seconds": 0.002,
        "bus_jitter_seconds": 7e-9,
        "bus_frames": 3.0,
    }


@in_loop
async def test_an_injected_fault_is_counted_while_it_acts() -> None:
    async with page_of(LAB) as page:
        await page.ask("bus/can0/add_fault", {"fault": {"what": "drop"}})
        await page.ask("rig/step", {"ns": 1})
        assert (await figures(page))["fieldrig_faults_active", labels(part="can0")] == 1
