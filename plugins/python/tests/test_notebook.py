"""The notebook of the examples: its cells are run in order, as a notebook does, without showing plots."""

import json
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from conftest import EXAMPLES, ROOT, binary


def test_the_notebook_runs_and_its_plots_have_contents(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    monkeypatch.setenv("REGATTA_PROGRAM", str(binary()))
    monkeypatch.chdir(ROOT)
    shown: list[int] = []

    def show() -> None:
        shown.append(sum(len(axes.get_children()) for axes in plt.gcf().axes))
        plt.close("all")

    monkeypatch.setattr(plt, "show", show)
    notebook = json.loads((EXAMPLES / "first_hour.ipynb").read_text(encoding="utf-8"))
    cells: dict[str, Any] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"first_hour.ipynb, {cell['id']}", "exec"), cells)
    assert len(shown) == 3 and min(shown) > 10, shown
    assert cells["edge"] in cells["closures"].edges(cells["run"].frame.run_id)
    assert len(cells["table"]) == 3 and (cells["table"]["orders_per_hour"] > 0).all()
