"""Several results in one; and the files of a result: a table, a summary and pictures under one name, checked before any
work and written together."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..base.errors import InputError
from ..base.files import as_json, check_target, make_folder, together, write_csv, write_text
from ..base.registry import Result

if TYPE_CHECKING:
    from . import plots

Figure: TypeAlias = "plots.Figure"  # by its name: matplotlib is imported when something is drawn
Check: TypeAlias = Callable[[Path, bool, Iterable[Path]], None]
PICTURES = (".png", ".svg")
SHOWN = 10  # curves that are printed line by line, and drawn


class Several(Result):
    """A result of several ``parts``."""

    def words(self) -> Sequence[str]:
        return [line for part in self.parts for line in part]


@dataclass(frozen=True, eq=False)
class Results(Several):
    """Results of one kind, with ``warnings`` of all of them; ``name``: of their list in the summary."""

    results: Sequence[Result]
    warnings: Sequence[str] = ()
    name: str = "results"

    def summary(self) -> dict[str, Any]:
        return {self.name: [one.summary() for one in self.results]}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [words for one in self.results if (words := one.words())]


@dataclass(frozen=True)
class Files:
    """Files of one result that differ in their endings: ``stem`` and each of ``endings``."""

    stem: Path
    endings: tuple[str, ...]

    def __getitem__(self, ending: str) -> Path:
        return self.stem.with_name(self.stem.name + ending)

    def __str__(self) -> str:
        if len(self.endings) > 1:
            return f"{self.stem}{{{','.join(self.endings)}}}"
        return str(self[self.endings[0]]) if self.endings else "nothing"

    def draw(self, figure: Callable[[], Figure]) -> Figure | None:
        """What ``figure`` draws, where a picture is to be written."""
        return figure() if set(PICTURES) & set(self.endings) else None

    def write(
        self,
        table: Mapping[str, Any] | None = None,
        summary: Mapping[str, Any] | None = None,
        figure: Figure | None = None,
        lines: Sequence[str] = (),
    ) -> None:
        """The columns of a table as CSV, a summary (with the ``lines`` of its records) as JSON, a figure as pictures,
        as far as they are given; all or none of them."""
        with together():
            if table is not None:
                write_csv(self[".csv"], table)
            if summary is not None:
                write_text(self[".json"], as_json(summary, lines))
            if figure is not None:
                from . import plots

                plots.save(figure, [self[ending] for ending in self.endings if ending in PICTURES])


@dataclass(frozen=True)
class Output:
    """Where and how a verb writes, as its options say; ``where``: -o, None where it was not given."""

    where: Path | None
    force: bool
    plots: bool
    json: bool

    def folder(self, default: Path) -> Path:
        """The folder to write into, made where -o names one that is not there; else ``default``."""
        if self.where is None:
            return default
        make_folder(self.where)
        return self.where

    def file(self, default: Path, inputs: Iterable[Path] = (), check: Check = check_target) -> Path:
        """The one file to write, after a ``check`` that it can and may be written; the name of a series, with
        ``check_series_target``, must not promise another format."""
        target = default if self.where is None else self.where
        check(target, self.force, inputs)
        return target

    def files(self, stem: Path, endings: Iterable[str], inputs: Iterable[Path] = ()) -> Files:
        """``stem`` with ``endings``, without pictures under --no-plots; checked, before any work, like one file."""
        files = Files(stem, tuple(ending for ending in endings if self.plots or ending not in PICTURES))
        for ending in files.endings:
            check_target(files[ending], self.force, inputs)
        return files

    def beside(self, path: Path, word: str = "") -> Path:
        """The stem of files that belong to ``path``, with a ``word`` behind its own: beside it, or in the folder of
        -o."""
        return (self.where or path.parent) / f"{path.stem}{word}"

    def each(self, stems: Sequence[Path], ends: Iterable[str], inputs: Iterable[Path], more: str = "") -> list[Files]:
        """The ``files`` of each of several ``stems``; InputError, with ``more`` to its remedy, where two would be the
        same."""
        places = list(map(os.path.realpath, stems))
        for i, stem in enumerate(stems):
            if places[i] in places[:i]:
                raise InputError(f"{stem}.csv: would be written twice; rename a file, or give each its own -o{more}")
        if self.where is not None:
            make_folder(self.where)
        return [self.files(stem, ends, inputs) for stem in stems]
