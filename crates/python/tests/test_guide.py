"""The notebooks of the guide run, in order of their cells, and so do the listings of the book."""

import json
import pathlib
import subprocess
import sys

import carom
import pytest

GUIDE = pathlib.Path(__file__).parents[1] / "guide"
ROOT = pathlib.Path(__file__).parents[3]
PAGES = ["README.md", "crates/book/src/python.md", "crates/python/README.md"]


def code_cells(path):
    """The sources of the code cells of a notebook, in their order."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert notebook["cells"][0]["cell_type"] == "markdown" and notebook["cells"][0]["source"][0].startswith("# ")
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids)
    found = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    # What a notebook shows depends on the machine, and is not stored.
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in found)
    return ["".join(cell["source"]) for cell in found]


@pytest.mark.parametrize("path", sorted(GUIDE.glob("*.ipynb")), ids=lambda path: path.stem)
def test_the_cells_of_a_notebook_run(path, monkeypatch, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    cells, names = code_cells(path), {"__name__": "__main__"}
    assert len(cells) >= 5
    for number, source in enumerate(cells):
        exec(compile(source, f"{path.name}, code cell {number}", "exec"), names)


def test_the_notebooks_are_those_of_their_text():
    checked = subprocess.run([sys.executable, str(ROOT / ".ci" / "python-notebooks"), "--check"],
                             capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr


@pytest.mark.parametrize("page", PAGES)
def test_the_listings_of_a_page_run(page, monkeypatch, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    listings = [rest.split("```")[0] for rest in (ROOT / page).read_text().split("```python\n")[1:]]
    assert listings
    for listing in listings:
        exec(compile(listing, page, "exec"), {"__name__": "__main__"})


def test_there_are_three_notebooks():
    assert len(list(GUIDE.glob("*.py"))) == len(list(GUIDE.glob("*.ipynb"))) == 3 and carom.__version__
