"""Whole runs that nobody watches."""

import pytest
from conftest import ROOT, binary

import regatta


@pytest.fixture(autouse=True)
def program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_PROGRAM", str(binary()))


def test_a_run_repeats_and_has_figures() -> None:
    first, second = (regatta.run(ROOT / "graphs/warehouse-charging.yaml", 600, robots=10) for _ in range(2))
    assert first.digest == second.digest
    assert (first.robots, first.sim_time_secs, first.findings) == (10, 600.0, {})
    assert first.orders_finished > 20
    assert first.service_p50_secs is not None and first.service_p99_secs is not None
    assert 0 < first.service_p50_secs < first.service_p99_secs
    other = regatta.run(ROOT / "graphs/warehouse-charging.yaml", 600, robots=11)
    assert other.digest != first.digest


def test_a_run_that_fails_says_why() -> None:
    with pytest.raises(regatta.RunError, match=r"missing\.yaml"):
        regatta.run("missing.yaml", 10)
