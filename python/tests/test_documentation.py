"""The code of docs/python.md, and the notebook."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/python.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("code", [code for code in BLOCKS if "def test_" not in code])
def test_code_of_the_page(code, monkeypatch):
    monkeypatch.chdir(ROOT)
    exec(compile(code, "docs/python.md", "exec"), {"__name__": "page"})


def test_test_of_the_page(pytester):
    (code,) = [code for code in BLOCKS if "def test_" in code]
    pytester.makepyfile(code)
    options = ["--canvass-bus=sim:kuebler-sendix-58x8", "--canvass-select=301/boot-up/every-time"]
    assert pytester.runpytest_subprocess(*options).parseoutcomes() == {"passed": 2}


def test_notebook(monkeypatch):
    notebook = nbformat.read(ROOT / "docs/examples/encoder.ipynb", as_version=4)
    client = NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(ROOT / "docs/examples")}})
    client.execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in outputs), "the plot"
    assert any("EMCY 4310h" in output.get("text", "") for output in outputs), "the diagnosis"
