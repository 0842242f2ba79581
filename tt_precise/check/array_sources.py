"""Arrays as blocks of rows: Parquet files, DataFrames, mappings of columns."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy

from tt_precise.check.blocks import Block, RowSource
from tt_precise.check.cells import column_of, numbers_of
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent

BLOCK_ROWS = 16_384


class ParquetSource(RowSource):
    """A Parquet file, read a batch of rows at a time."""

    def __init__(self, path: Path, rename: Mapping[str, str]):
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise InputError(
                f"{path}: reading Parquet needs pyarrow; pip install 'tt-precise[parquet]'"
            ) from None
        self._failures = (pyarrow.ArrowException, OSError)
        try:
            self._file = pyarrow.parquet.ParquetFile(path)
        except self._failures as error:
            raise self._refused(str(path), error) from None
        self._theirs = list(self._file.schema_arrow.names)
        super().__init__(str(path), self._theirs, rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        """The columns as arrays, batch by batch."""
        every = (*wanted, *also)
        theirs = [self._theirs[self.names.index(name)] for name in every]
        total, done = self._file.metadata.num_rows, 0
        batches = self._file.iter_batches(BLOCK_ROWS, columns=theirs)
        while True:
            try:
                batch = next(batches, None)
            except self._failures as error:
                raise self._refused(self.where, error) from None
            if batch is None:
                return
            given = {
                ours: column_of(batch.column(name), ours, self.where)
                for ours, name in zip(every, theirs, strict=True)
            }
            yield _block(given, wanted, self.where, done)
            done += len(batch)
            progress(done / total)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @staticmethod
    def _refused(where: str, error: Exception) -> InputError:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        return InputError(f"{where}: {reason}; expected a Parquet file")


class ColumnSource(RowSource):
    """Columns in memory; ``column(name)`` gives one of those called ``names``.

    ``where`` is what messages call them.
    """

    def __init__(
        self,
        names: Sequence[Hashable],
        column: Callable[[Hashable], object],
        rename: Mapping[str, str],
        where: str = "the table",
    ):
        self._theirs, self._column = list(names), column
        super().__init__(where, [str(name) for name in names], rename)

    def blocks(
        self, wanted: Sequence[str], also: Sequence[str] = (), progress: Progress = silent
    ) -> Iterator[Block]:
        """The columns as arrays, block by block."""
        given = {}
        for name in (*wanted, *also):
            theirs = self._theirs[self.names.index(name)]
            given[name] = column_of(self._column(theirs), name, self.where)
        lengths = {name: len(column) for name, column in given.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{self.where}: columns of different length: {lengths}")
        for first in range(0, lengths["t"], BLOCK_ROWS):
            part = {name: column[first : first + BLOCK_ROWS] for name, column in given.items()}
            yield _block(part, wanted, self.where, first)


def _block(
    given: Mapping[str, numpy.ndarray], wanted: Sequence[str], where: str, first: int
) -> Block:
    return Block(
        {
            name: numbers_of(column, name, where, first, strict=name in wanted)
            for name, column in given.items()
        },
        lambda row: f"row {first + row}",
        lambda row, names: [given[name][row] for name in names],
    )
