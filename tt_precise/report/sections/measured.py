"""Tables that commands of their own measured and left in the report's folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tt_precise.report.document import Block, Section, Table, Text


@dataclass(frozen=True)
class Measured:
    """A CSV file in the report's folder, what it shows, and the command that makes it."""

    key: str
    title: str
    text: str
    command: str

    def section(self, folder: Path) -> Section:
        """The table, or the command that would make it."""
        file = folder / f"{self.key}.csv"
        blocks: list[Block] = [Text(self.text)]
        if not file.is_file():
            blocks.append(Text(f"Not measured yet: {self.command}."))
            return Section(self.key, self.title, blocks)
        import pandas

        table = pandas.read_csv(file, dtype=str, keep_default_na=False)
        rows = [tuple(row) for row in table.itertuples(index=False)]
        header = tuple(name.replace("_", " ") for name in table.columns)
        blocks.append(Text(f"Measured by {self.command}; not by the run that wrote this page."))
        blocks.append(Table(header, rows, name=f"{self.key}-table"))
        return Section(self.key, self.title, blocks)


ALL = (
    Measured(
        "faults",
        "What the checks catch",
        "Faults planted into the reference scene's equations, its integration and its files, each "
        "run through the conservation checks; healthy trajectories beside them.",
        "python -m tt_precise.measure.faults",
    ),
    Measured(
        "clients",
        "Other people's engines",
        "Tippe tops simulated by engines that nobody here wrote: drift of Jellett's integral "
        "against their step size, until the peg or the ground contact ends the single contact.",
        "python -m tt_precise.measure.clients",
    ),
)


def sections(folder: Path) -> list[Section]:
    """All of them, in order."""
    return [measured.section(folder) for measured in ALL]
