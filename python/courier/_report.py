"""The report's page, and a model, as files and in a notebook."""

from __future__ import annotations

import html
import os
import pathlib
from dataclasses import dataclass, field
from typing import Union

Path = Union[str, "os.PathLike[str]"]

_HEIGHT_PX = 720


@dataclass(frozen=True)
class Report:
    """The page that ``courier diagnose --report`` writes. A notebook shows it; it needs no network."""

    html: str = field(repr=False)

    def save(self, path: Path) -> None:
        """Writes the page to ``path``; what is there is replaced."""
        pathlib.Path(path).write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.html)
        style = f"width: 100%; height: {_HEIGHT_PX}px; border: 0"
        return f'<iframe title="report of courier diagnose" style="{style}" srcdoc="{page}"></iframe>'


@dataclass(frozen=True)
class Model:
    """What a diagnosis found, for :func:`courier.check`: the text of the file that ``courier diagnose --model`` writes."""

    text: str = field(repr=False)
    name: str

    def save(self, path: Path) -> None:
        """Writes the file, for the command or for later; what is there is replaced."""
        pathlib.Path(path).write_text(self.text, encoding="utf-8")
