"""Scenes: the contents of the box, and what is run and measured."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

from . import _carom
from ._errors import SceneError
from ._html import escape
from ._plain import plain, word

__all__ = ["Scene"]

Entry = Mapping[str, Any]
Entries = Union[Entry, Sequence[Entry]]

# A larger scene is not built for its picture in a notebook (bodies).
_MOST_DRAWN = 20_000

_LISTS = ("molecule", "bumper", "wall", "gas", "stage", "measure")
_TABLES = ("start", "elasticity", "method", "run")


class Scene:
    """The contents of the box at the start, and what is run and measured.

    The keys are those of a scene file, which ``crates/book/src/keys.md`` lists with types, ranges and
    units. Values are checked when a :class:`Simulation` is built.

    Parameters
    ----------
    source : mapping, str or path, optional
        The tables of a scene as a mapping, the text of a scene file, or the path of one (a
        ``Path``, or a text that ends in ``.toml``). Keywords replace its entries.
    box : sequence of two float or mapping, optional
        Sides of the periodic box (length), or its table with other keys. Default: 1 by 1.
    seed, replica : int, optional
        Seed of all random numbers, and number of the replica. Default: 0.
    gas, molecule, bumper, wall : mapping or sequence of mappings, optional
        Entries ``[[gas]]``, ``[[molecule]]``, ``[[bumper]]`` and ``[[wall]]``. A gas or a molecule
        takes a :class:`Molecule` as ``molecule``; :meth:`Molecule.at` makes an entry ``molecule``.
    elasticity : float or mapping, optional
        Coefficient of restitution of all contacts, or the table ``[elasticity]``.
    start, method, run : mapping, optional
        Tables ``[start]``, ``[method]`` and ``[run]``.
    stage, measure : mapping or sequence of mappings, optional
        Entries ``[[stage]]`` and ``[[measure]]``, for :func:`run` and :func:`replicas`.

    Raises
    ------
    SceneError
        A key is unknown or missing, or has another type.

    Examples
    --------
    Examples of the members continue from this one.

    >>> import carom
    >>> scene = carom.Scene(gas={"radius": 0.01, "mass": 1, "energy": 1, "count": 100}, seed=7)
    >>> scene.tables["box"]["seed"]
    7
    >>> carom.Scene(scene.to_toml()) == scene
    True
    """

    __module__ = "carom"
    __slots__ = ("_snapshot", "_text")

    def __init__(
        self,
        source: Mapping[str, Any] | str | os.PathLike[str] | Scene | None = None,
        /,
        *,
        box: Sequence[float] | Mapping[str, Any] | None = None,
        seed: int | None = None,
        replica: int | None = None,
        gas: Entries | None = None,
        molecule: Entries | None = None,
        bumper: Entries | None = None,
        wall: Entries | None = None,
        start: Entry | None = None,
        elasticity: float | Entry | None = None,
        method: Entry | None = None,
        run: Entry | None = None,
        stage: Entries | None = None,
        measure: Entries | None = None,
    ) -> None:
        self._snapshot: str | None = None
        tables = self._read(source)
        of_box = box if isinstance(box, Mapping) else {"sides": box}
        bounds = {**of_box, "seed": seed, "replica": replica}
        given = {key: plain(value) for key, value in bounds.items() if value is not None}
        if given:
            old = tables.get("box", {})
            tables["box"] = {**(old if isinstance(old, dict) else {}), **given}
        lists = zip(_LISTS, (molecule, bumper, wall, gas, stage, measure))
        tables.update({key: plain(value) for key, value in lists if value is not None})
        settings = zip(_TABLES, (start, elasticity, method, run))
        tables.update({key: plain(value) for key, value in settings if value is not None})
        for key in _LISTS:
            if isinstance(tables.get(key), dict):
                tables[key] = [tables[key]]
        for key in ("gas", "molecule"):
            entries = tables.get(key)
            for entry in entries if isinstance(entries, list) else []:
                _use_molecule(entry)
        if gas is not None and box is None and isinstance(tables.get("box"), dict):
            # The new gas may set the sides of the box.
            entries = tables.get("gas")
            fits = any("count" in entry and "area_fraction" in entry for entry in entries or [])
            if fits:
                tables["box"] = {k: v for k, v in tables["box"].items() if k != "sides"}
        rules = tables.get("elasticity")
        if isinstance(rules, (int, float)) and not isinstance(rules, bool):
            tables["elasticity"] = {"default": rules}
        self._text = _carom.scene_of(tables)

    def _read(self, source: object) -> dict[Any, Any]:
        if source is None:
            return {}
        if isinstance(source, Scene):
            self._snapshot = source._snapshot
            return source.tables
        if isinstance(source, Mapping):
            return dict(plain(source))
        is_path = isinstance(source, os.PathLike)
        if is_path or (isinstance(source, str) and source.endswith(".toml") and "\n" not in source):
            text, self._snapshot = _carom.scene_of_file(source)  # type: ignore[arg-type]
            return _tables(text)
        if isinstance(source, str):
            if "\n" not in source and os.path.isdir(source):
                raise SceneError(f"{source!r} is a folder, not a scene file")
            return _tables(_carom.scene_of_text(source))
        raise TypeError(f"a scene is a mapping, a text or a path, not {source!r:.60}")

    @classmethod
    def from_toml(cls, text: str) -> Scene:
        """The scene of the text of a scene file.

        Examples
        --------
        >>> import carom
        >>> carom.Scene.from_toml("[box]\\nsides = [2.0, 1.0]").tables["box"]["sides"]
        [2.0, 1.0]
        """
        return cls._of(_carom.scene_of_text(word("text", text)), None)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Scene:
        """The scene of a file.

        Raises
        ------
        SceneError
            The file cannot be read, or is no scene.

        Examples
        --------
        >>> import carom, pathlib, tempfile
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "gas.toml"
        >>> _ = path.write_text("[[gas]]\\nradius = 0.01\\nmass = 1\\nenergy = 1\\ncount = 9")
        >>> len(carom.Simulation(carom.Scene.from_file(path)))
        9
        """
        return cls._of(*_carom.scene_of_file(path))

    @classmethod
    def _of(cls, text: str, snapshot: str | None) -> Scene:
        scene = cls.__new__(cls)
        scene._text, scene._snapshot = text, snapshot
        return scene

    def to_toml(self) -> str:
        """The text of a scene file, which the command ``carom`` runs.

        Examples
        --------
        >>> import carom
        >>> "[box]" in carom.Scene(box=(2, 1)).to_toml()
        True
        """
        return self._text

    @property
    def tables(self) -> dict[str, Any]:
        """All tables and entries with their defaults, as a new dictionary.

        Examples
        --------
        >>> scene.tables["gas"][0]["count"]
        100
        """
        return _tables(self._text)

    def replaced(self, **changes: Any) -> Scene:
        """This scene with other entries; the keywords are those of :class:`Scene`.

        Examples
        --------
        >>> import carom
        >>> carom.Scene(box=(2, 1)).replaced(seed=3).tables["box"]
        {'replica': 0, 'seed': 3, 'sides': [2.0, 1.0]}
        """
        return Scene(self, **changes)

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, Scene)
        return same and (self._text, self._snapshot) == (other._text, other._snapshot)  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash(self._text)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Scene._of, (self._text, self._snapshot))

    def __repr__(self) -> str:
        return f"carom.Scene({self._text!r})" if len(self._text) < 200 else f"<carom.Scene: {self._words()}>"

    def _words(self) -> str:
        tables = self.tables
        counts = [f"{len(tables[key])} × [[{key}]]" for key in _LISTS if tables.get(key)]
        sides = tables["box"]["sides"]
        return f"box {sides[0]:g} × {sides[1]:g}, " + (", ".join(counts) or "empty")

    def _repr_html_(self) -> str:
        text = f"<details><summary>{escape(self._words())}</summary><pre>{escape(self._text)}</pre></details>"
        counts = [entry.get("count") for entry in self.tables.get("gas", [])]
        if None in counts or sum(counts) > _MOST_DRAWN:
            return text
        try:
            return _carom.Core(self._text, self._snapshot).picture(480) + text
        except SceneError as error:
            return f"<p>{escape(str(error))}</p>{text}"


def _use_molecule(entry: Any) -> None:
    """Replaces the key ``molecule`` of an entry by the keys of its shape."""
    if isinstance(entry, dict) and isinstance(entry.get("molecule"), dict):
        shape = entry.pop("molecule")
        entry.update(shape)


def _tables(text: str) -> dict[str, Any]:
    return _carom.tables_of(text)
