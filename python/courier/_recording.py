"""Recordings as NumPy arrays, Arrow and pandas tables."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Dict, List, Tuple, Union

import numpy as np

from . import _native

if TYPE_CHECKING:
    import pandas
    import pyarrow

Path = Union[str, "os.PathLike[str]"]


class Recording:
    """A recording in memory: what it says of itself, and its samples by column. It does not change.

    ``recording["q1s"]`` is a column as NumPy array of 64-bit floats, NaN where nothing was measured. It is the recording's own memory:
    nothing is copied, and it cannot be written to. Names and units of all columns are in docs/recording.md.
    """

    def __init__(self, path: Path) -> None:
        self._native = _native.Recording(os.fspath(path))

    @property
    def path(self) -> str:
        """Where it was read, as it was named."""
        return os.fspath(self._native.path)

    @property
    def columns(self) -> List[str]:
        """Columns that hold anything, ``run`` among them where motions have names, in the order of the file."""
        numbers = self._native.columns
        has_runs = any(self._native.run_names)
        return numbers[:1] + ["run"] * has_runs + numbers[1:]

    @property
    def meta(self) -> Dict[str, Any]:
        """What ``recording.toml`` says, a dictionary a table."""
        meta: Dict[str, Any] = json.loads(self._native.meta_json)
        return meta

    @property
    def toml(self) -> str:
        """The text of ``recording.toml``."""
        return self._native.toml

    @property
    def run_names(self) -> List[str]:
        """Names of the motions in the order of their first appearance; an empty name where there is none."""
        return self._native.run_names

    @property
    def run_numbers(self) -> "np.ndarray[Any, np.dtype[np.uint32]]":
        """Of each sample, the place of its motion in ``run_names``."""
        return np.asarray(self._native.run_numbers())

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, column: str) -> "np.ndarray[Any, np.dtype[Any]]":
        """A column; ``run`` is the name of each sample's motion.

        Raises KeyError for a column that holds nothing.
        """
        if column == "run":
            names: "np.ndarray[Any, np.dtype[Any]]" = np.asarray(self.run_names)[self.run_numbers]
            return names
        return np.asarray(self._native.column(column))

    def __contains__(self, column: object) -> bool:
        return column in self.columns

    def to_arrow(self) -> "pyarrow.Table":
        """All columns as Arrow table; a null is what was not measured. Columns without a null are not copied.

        The table's metadata hold ``recording.toml``: written by ``pyarrow.parquet.write_table`` it is a recording again.
        """
        import pyarrow

        def numbers(column: str) -> Any:
            values = self[column]
            missing = np.isnan(values)
            return pyarrow.array(values, mask=missing if missing.any() else None)

        def one(column: str) -> Any:
            if column == "run":
                names = pyarrow.array(self.run_names, pyarrow.string())
                return pyarrow.DictionaryArray.from_arrays(self.run_numbers.astype(np.int32), names)
            return numbers(column)

        columns = self.columns
        return pyarrow.table(
            [one(column) for column in columns], names=columns, metadata={"recording.toml": self.toml}
        )

    def to_pandas(self) -> "pandas.DataFrame":
        """All columns as pandas table; NaN is what was not measured, ``run`` is a categorical."""
        import pandas

        def one(column: str) -> Any:
            if column == "run":
                return pandas.Categorical.from_codes(self.run_numbers.astype(np.int32), pandas.Index(self.run_names))
            return self[column]

        table: "pandas.DataFrame" = pandas.DataFrame({column: one(column) for column in self.columns})
        return table

    def __reduce__(self) -> Tuple[Any, ...]:
        # Another process reads it again: the files are smaller than the memory, and are where it says.
        return (Recording, (self.path,))

    def __repr__(self) -> str:
        return f"<courier.Recording {self.path!r}: {len(self)} samples, {len(self.columns)} columns>"


def read(path: Path) -> Recording:
    """Reads and checks a recording: a folder with ``recording.toml`` and ``samples.csv``, or a Parquet file where this build has it.

    Raises :class:`courier.InputError` for the first thing that is wrong, by file, column and row. Warns of columns that it does not know.
    """
    return Recording(path)
