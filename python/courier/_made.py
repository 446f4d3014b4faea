"""How an answer is made of the command's JSON, and a table of an answer."""

from __future__ import annotations

import dataclasses
import json
from operator import attrgetter
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    List,
    Optional,
    Sequence,
    Tuple,
    Type,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

if TYPE_CHECKING:
    import pandas

_T = TypeVar("_T")

# Of a field that is not of the JSON: it is set once the rest is made.
BESIDE: Dict[str, Any] = {"beside": True}


class Answer:
    """What a command answered. ``str(answer)`` is the text that the command prints."""

    _json = ""
    _text = ""
    # Which of its lists is the main table, where no method says otherwise.
    _main = ""

    def to_json(self) -> str:
        """The JSON that the command prints with ``--json``, to the letter."""
        return self._json

    def __str__(self) -> str:
        return self._text

    def _rows(self) -> Sequence[Any]:
        rows: Sequence[Any] = attrgetter(self._main)(self)
        return rows

    def to_pandas(self) -> "pandas.DataFrame":
        """The answer's main table; :func:`courier.table` makes one of any list in it."""
        return table(self._rows())


def made(cls: Type[_T], text: str, words: str = "", **beside: Any) -> _T:
    """An answer of a class by its JSON, with the text of the command and what is beside the JSON."""
    answer = _of(cls, json.loads(text), beside)
    object.__setattr__(answer, "_json", text)
    object.__setattr__(answer, "_text", words)
    return answer


_KNOWN: Dict[Any, List[Tuple[str, str, Any]]] = {}


def _fields(cls: Any) -> List[Tuple[str, str, Any]]:
    """Names of a class's fields, their keys in the JSON, and what they are annotated with."""
    if cls not in _KNOWN:
        hints = get_type_hints(cls)
        fields = [one for one in dataclasses.fields(cls) if not one.metadata.get("beside")]
        _KNOWN[cls] = [(one.name, one.metadata.get("key", one.name), hints[one.name]) for one in fields]
    return _KNOWN[cls]


def _of(cls: Type[_T], value: Dict[str, Any], beside: Optional[Dict[str, Any]] = None) -> _T:
    given = {name: _value(hint, value[key]) for name, key, hint in _fields(cls) if key in value}
    return cls(**given, **(beside or {}))


def _value(hint: Any, value: Any) -> Any:
    """A value of the JSON as what its field is annotated with."""
    arguments = get_args(hint)
    if get_origin(hint) is Union:
        return None if value is None else _value(arguments[0], value)
    if get_origin(hint) is tuple:
        each = arguments[:1] * len(value) if arguments[-1] is Ellipsis else arguments
        return tuple(_value(one, part) for one, part in zip(each, value))
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return _of(hint, value)
    # JSON has no number for what is not finite.
    return float("nan") if hint is float and value is None else value


def table(rows: Sequence[Any]) -> "pandas.DataFrame":
    """A pandas table of dataclasses of one kind, such as ``diagnosis.effects``: a row each.

    Pairs of numbers become two columns, ``…_low`` and ``…_high``; lists of words are joined by commas; what is no cell is left out.
    """
    import pandas

    rows_of_cells = [row if isinstance(row, dict) else cells_of(row) for row in rows]
    made: "pandas.DataFrame" = pandas.DataFrame(rows_of_cells)
    return made


def cells_of(row: Any) -> Dict[str, Any]:
    """What of a dataclass stands in a table, by column."""
    cells: Dict[str, Any] = {}
    for name, _, _ in _fields(type(row)):
        value = getattr(row, name)
        if isinstance(value, tuple):
            if len(value) == 2 and all(isinstance(part, float) for part in value):
                cells[name + "_low"], cells[name + "_high"] = value
            elif all(isinstance(part, str) for part in value):
                cells[name] = ", ".join(value)
        elif not dataclasses.is_dataclass(value):
            cells[name] = value
    return cells
