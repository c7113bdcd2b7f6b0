"""Pieces of HTML for notebooks: everything is inside the page, nothing is loaded."""

from __future__ import annotations

import math

__all__ = ["Html", "escape", "frame", "rows", "with_error"]


def escape(text: str) -> str:
    """Text for HTML, also inside an attribute."""
    for character, name in (("&", "amp"), ("<", "lt"), (">", "gt"), ('"', "quot"), ("'", "#x27")):
        text = text.replace(character, f"&{name};")
    return text


class Html:
    """HTML that a notebook displays; ``str`` gives its text.

    Examples
    --------
    >>> from carom import Html
    >>> str(Html("<b>gas</b>"))
    '<b>gas</b>'
    """

    __module__ = "carom"

    def __init__(self, text: str) -> None:
        self._text = text

    def __str__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        return self._text


# The moving picture of a page in a frame: the controls stay in sight below a picture of any shape.
# The foot of a page names files of a run folder.
_IN_A_FRAME = """<style>
footer, h2 { display: none }
main { padding: .6rem .8rem }
h1 { font-size: 1.05rem; margin: 0 }
.animation { margin: .6rem 0 0 }
.animation .views > div { max-width: none }
.animation canvas { max-height: calc(100vh - 11.5rem); object-fit: contain; object-position: left; border: 0 }
@media (max-width: 36rem) { .animation .controls { gap: .3rem } }
</style></head>"""


def frame(page: str, height: int) -> str:
    """A complete page inside a notebook, apart from the styles of the notebook."""
    page = page.replace("</head>", _IN_A_FRAME, 1)
    return (
        f'<iframe srcdoc="{escape(page)}" width="100%" height="{height}" '
        'style="border:0" sandbox="allow-scripts"></iframe>'
    )


def rows(head: list[str], body: list[list[str]]) -> str:
    """A table of escaped cells."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    lines = ("".join(f"<td>{escape(cell)}</td>" for cell in line) for line in body)
    return f"<table><tr>{top}</tr>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>"


def with_error(value: float, error: float | None) -> str:
    """A value to the digits that its standard error justifies."""
    if error is None or not math.isfinite(error) or error <= 1e-12 * abs(value):
        return f"{value:.6g}"
    decimals = min(max(1 - math.floor(math.log10(error)), 0), 12)
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"
