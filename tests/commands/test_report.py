"""``tt-precise report``: where it writes, and what it opens."""

from pathlib import Path

import pytest

from tests.conftest import Said
from tt_precise.report import build


def test_the_command_names_and_opens_the_page_that_it_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: Said
) -> None:
    page = tmp_path / "out" / f"{build.NAME}.html"
    opened: list[str] = []

    def opens(address: str) -> bool:
        opened.append(address)
        return True

    def written(folder: Path, command: str, progress: object) -> list[Path]:
        assert command == f"tt-precise report --out {folder}"
        page.parent.mkdir(exist_ok=True)
        page.write_text("a page", "utf-8")
        return [page]

    monkeypatch.setattr(build, "build", written)
    monkeypatch.setattr("webbrowser.open", opens)
    assert str(page) in said("report --open --out", page.parent)
    assert opened == [page.resolve().as_uri()]
