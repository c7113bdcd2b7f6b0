"""The examples of all docstrings, and that each public name has one."""

import doctest
import inspect

import carom
import pytest

# These are no functions and no classes: they have no docstring of their own.
WITHOUT = {"COLLISION", "__version__"}
PARSER = doctest.DocTestParser()


def documented():
    """Name, value, and the class of which it is a member."""
    yield "carom", carom, None
    for name in carom.__all__:
        value = getattr(carom, name)
        if name in WITHOUT:
            continue
        yield name, value, None
        for member, entry in vars(value).items() if inspect.isclass(value) else ():
            function = getattr(entry, "fget", None) or getattr(entry, "__func__", entry)
            if not member.startswith("_") and inspect.isfunction(function):
                yield f"{name}.{member}", function, value


def run(name, value, names):
    """Runs the examples of a docstring, which may use and add `names`."""
    test = PARSER.get_doctest(inspect.getdoc(value) or "", names, name, None, None)
    assert test.examples, f"{name} has no example"
    options = doctest.NORMALIZE_WHITESPACE
    result = doctest.DocTestRunner(optionflags=options).run(test, clear_globs=False)
    assert result.failed == 0, name
    return test.globs


@pytest.mark.parametrize(("name", "value", "owner"), [pytest.param(*entry, id=entry[0]) for entry in documented()])
def test_examples_give_what_they_show(name, value, owner):
    if (".plot" in name or ".to_pandas" in name) and not has_optional_packages():
        pytest.skip("no Matplotlib or pandas")
    for package in ("polars", "xarray"):
        if f".to_{package}" in name:
            pytest.importorskip(package)
    for member, package in {"to_ase": "ase", "to_freud": "freud", "to_gsd": "gsd.hoomd", "from_gsd": "gsd.hoomd"}.items():
        if name.endswith(member):
            pytest.importorskip(package)
    if name == "live" or name.startswith("LiveView"):
        pytest.importorskip("IPython")
    # The examples of members continue from that of their class.
    names = {} if owner is None else run(owner.__name__, owner, {})
    run(name, value, names)


def has_optional_packages():
    try:
        import matplotlib
        import pandas
    except ImportError:
        return False
    matplotlib.use("Agg")
    return pandas is not None
