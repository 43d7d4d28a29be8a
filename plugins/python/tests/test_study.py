"""Studies as tables."""

from pathlib import Path

import pytest
from conftest import ROOT, binary

import regatta


@pytest.fixture(autouse=True)
def program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("REGATTA_PROGRAM", str(binary()))


def test_a_study_is_a_table(tmp_path: Path) -> None:
    result = regatta.study(
        ROOT / "graphs/square.yaml",
        [1, 2],
        minutes=10,
        seeds=(2, 2),
        vary={"speed_factor": [1.0, 0.5]},
        output=tmp_path / "study",
        arguments=["--reliefs", "0"],
    )
    table = result.to_pandas()
    assert list(table.robots) == [1, 2, 1, 2]
    assert list(table.variant) == ["speed factor 1.0"] * 2 + ["speed factor 0.5"] * 2
    fast, slow = table.orders_per_hour[:2], table.orders_per_hour[2:]
    assert fast[1] > 1.5 * fast[0] and slow[2] < fast[0]
    assert (table.runs == 2).all() and (table.stalled_runs == 0).all() and (table.contacts == 0).all()
    assert result.to_polars().shape == table.shape
    assert "orders an hour" in result.answers[0]
    assert (tmp_path / "study/index.html").is_file()


def test_targets_have_a_least_fleet(tmp_path: Path) -> None:
    day = tmp_path / "day.csv"
    day.write_text("time,stops\n" + "".join(f"0,{1 + place % 4}:none:60\n" for place in range(4)))
    result = regatta.study(
        ROOT / "graphs/square.yaml",
        [1, 2],
        seeds=(2, 2),
        orders=day,
        targets=["longest service < 500s", "1 orders/h"],
        arguments=["--resample", "none"],
    )
    table = result.to_pandas()
    # Two seeds may be too few to tell it of two robots.
    one, two = table["longest service < 500 s"]
    assert one == "met" and two in ("met", "open") and result.least == {"": 1}
    assert (table.late.isna()).all(), "no order has a deadline"


def test_a_study_that_fails_says_why(tmp_path: Path) -> None:
    with pytest.raises(regatta.StudyError, match=r"missing\.yaml"):
        regatta.study("missing.yaml", 2)
    with pytest.raises(regatta.StudyError, match="colour"):
        regatta.study(ROOT / "graphs/square.yaml", 2, vary={"colour": ["red"]})
