"""The programs in the READMEs work as they are printed there."""

import re
import textwrap
from pathlib import Path

import pytest
from conftest import ROOT, Engine, eventually

BLOCKS = [
    pytest.param(textwrap.dedent(block), id=f"{readme.parent.name}-{number}")
    for readme in (ROOT / "plugins/README.md", ROOT / "plugins/python/README.md")
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL))
]


@pytest.mark.parametrize("code", BLOCKS)
def test_a_program_in_a_readme_runs(code: str, engine: Engine, tmp_path: Path) -> None:
    engine.start(scenario="warehouse-1000.yaml")
    (tmp_path / "plugin.py").write_text(code.replace('"default"', repr(engine.name)))
    program = engine.script(tmp_path / "plugin.py", *(["--fleet", engine.name] if "parse_args" in code else []))
    eventually("a line of output", lambda: program.output.count("\n") >= 1 or program.child.poll())
    program.end()
    assert program.output.startswith("tick ") and program.errors == ""
