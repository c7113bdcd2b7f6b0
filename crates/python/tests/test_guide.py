"""The notebooks of the guide run, in order of their cells, and so do the listings of the book."""

import pathlib

import carom
import pytest

GUIDE = pathlib.Path(__file__).parents[1] / "guide"
ROOT = pathlib.Path(__file__).parents[3]
PAGES = ["README.md", "crates/book/src/python.md", "crates/python/README.md"]


@pytest.mark.parametrize("path", sorted(GUIDE.glob("*.py")), ids=lambda path: path.stem)
def test_the_cells_of_a_notebook_run(path, monkeypatch, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    text = path.read_text()
    assert text.startswith("# %% [markdown]\n# # ") and text.count("# %%\n") >= 5
    exec(compile(text, str(path), "exec"), {"__name__": "__main__"})


@pytest.mark.parametrize("page", PAGES)
def test_the_listings_of_a_page_run(page, monkeypatch, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    listings = [rest.split("```")[0] for rest in (ROOT / page).read_text().split("```python\n")[1:]]
    assert listings
    for listing in listings:
        exec(compile(listing, page, "exec"), {"__name__": "__main__"})


def test_there_are_three_notebooks():
    assert len(list(GUIDE.glob("*.py"))) == 3 and carom.__version__
