"""The notebooks of the guide run, in order of their cells."""

import pathlib

import carom
import pytest

GUIDE = pathlib.Path(__file__).parents[1] / "guide"


@pytest.mark.parametrize("path", sorted(GUIDE.glob("*.py")), ids=lambda path: path.stem)
def test_the_cells_of_a_notebook_run(path, monkeypatch, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.chdir(tmp_path)
    text = path.read_text()
    assert text.startswith("# %% [markdown]\n# # ") and text.count("# %%\n") >= 5
    exec(compile(text, str(path), "exec"), {"__name__": "__main__"})


def test_there_are_three_notebooks():
    assert len(list(GUIDE.glob("*.py"))) == 3 and carom.__version__
