"""The examples of all docstrings, and that each public name has one."""

import doctest
import inspect

import carom
import pytest

# Attributes of a dataclass or of an array need no example of their own.
WITHOUT = {"COLLISION", "__version__", "Column", "MoleculeError", "MeasureError", "EditError",
           "CheckpointError", "RunError", "BusyError", "FirstContact"}


def documented():
    yield "carom", carom
    for name in carom.__all__:
        value = getattr(carom, name)
        if not callable(value):
            continue
        yield name, value
        for member, entry in vars(value).items() if inspect.isclass(value) else ():
            function = getattr(entry, "fget", None) or getattr(entry, "__func__", entry)
            if not member.startswith("_") and inspect.isfunction(function):
                yield f"{name}.{member}", function


@pytest.mark.parametrize(("name", "value"), list(documented()), ids=lambda entry: str(entry)[:40])
def test_examples_give_what_they_show(name, value):
    text = inspect.getdoc(value)
    assert text, f"{name} has no docstring"
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    if not test.examples and "." not in name and name not in WITHOUT:
        pytest.fail(f"{name} has no example")
    result = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test)
    assert result.failed == 0, name
