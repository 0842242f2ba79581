"""Tables that commands of their own measured and left in the report's folder."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise.report.document import Block, Figure, PageTable, Section, Text
from tt_precise.report.figures import measured as pictures
from tt_precise.runtime.records import of_its_form

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class MeasuredFile:
    """A CSV file in the report's folder, what it shows, and the command that makes it."""

    key: str
    title: str
    text: str
    command: str
    reading: Callable[[pandas.DataFrame], str] | None = None  # what the table says, in a sentence
    picture: Callable[[pandas.DataFrame], Figure] | None = None

    def section(self, folder: Path) -> Section:
        """The table, or the command that would make it."""
        file = folder / f"{self.key}.csv"
        blocks: list[Block] = [Text(self.text)]
        if not file.is_file():
            blocks.append(Text(f"Not measured yet: `{self.command}`."))
            return Section(self.key, self.title, blocks)
        with of_its_form(file, f"what `{self.command}` writes"):
            return Section(self.key, self.title, [*blocks, *self._shown(file)])

    def _shown(self, file: Path) -> list[Block]:
        import pandas

        table = pandas.read_csv(file, dtype=str, keep_default_na=False)
        blocks: list[Block] = []
        rows = [tuple(row) for row in table.itertuples(index=False)]
        header = tuple(name.replace("_", " ") for name in table.columns)
        if self.picture:
            blocks.append(self.picture(table))
        if self.reading:
            blocks.append(Text(self.reading(table), emphasis=True))
        blocks.append(Text(f"Measured by `{self.command}`; not by the run that wrote this page."))
        blocks.append(
            PageTable(header, rows, "All that was measured.", name=f"{self.key}-table", folded=True)
        )
        return blocks


LIMIT = 1e-6  # what the paper states for lambda


def jellett_alone(table: pandas.DataFrame) -> str:
    """How many of the dropped terms lambda alone would show at the paper's limit."""
    dropped = table[table["kind"] == "dropped term"]
    by_jellett = sum(float(drift or "nan") > LIMIT for drift in dropped["jellett"])
    caught = int((dropped[f"at_{LIMIT:.0e}"] == "True").sum())
    return (
        f"Conservation is not correctness: of {len(dropped)} terms of the equations, dropped one "
        f"at a time, lambda alone shows {by_jellett} at {LIMIT:.0e}; all checks together show "
        f"{caught}."
    )


ALL = (
    MeasuredFile(
        "faults",
        "What the checks catch",
        "Faults planted into the reference scene's equations, its integration and its files, each "
        "run through the conservation checks; healthy trajectories beside them.",
        "python -m benchmarks.planted_faults",
        jellett_alone,
        pictures.faults,
    ),
)
