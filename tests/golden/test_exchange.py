"""Golden data that are built anew while somebody reads them: old or new, never some of each."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.golden.test_seal import flip_last_digit, reseal
from tt_precise.golden import load, store
from tt_precise.golden.store import EVENTS, FILES, SCENE, TRAJECTORY
from tt_precise.runtime.errors import InputError

NAME = "contact-lost"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return shutil.copytree(store.home() / NAME, tmp_path / NAME)


def files(place: Path) -> dict[str, str]:
    return {file: (place / file).read_text() for file in FILES}


@pytest.fixture
def other(tmp_path: Path) -> dict[str, str]:
    """Files of another build, whose digits are not the same."""
    place = shutil.copytree(store.home() / NAME, tmp_path / "another" / NAME)
    flip_last_digit(place)
    reseal(place)
    return files(place)


def exchanging_before(
    monkeypatch: pytest.MonkeyPatch, file: str, exchange: Callable[[], None]
) -> None:
    """Let ``exchange`` happen just before ``file`` is read."""
    text = store._text

    def read(path: Path) -> str:
        if path.name == file:
            exchange()
        return text(path)

    monkeypatch.setattr(store, "_text", read)


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS, SCENE])
def test_data_exchanged_while_they_are_read_are_read_again(
    place: Path, other: dict[str, str], monkeypatch: pytest.MonkeyPatch, file: str
) -> None:
    """The manifest of one build and the table of another would be refused, or worse, taken."""
    todo, old = [other], files(place)

    def exchange() -> None:
        if todo:
            store.replace_folder(place, todo.pop())

    exchanging_before(monkeypatch, file, exchange)
    stored = store.read(NAME, place.parent)
    assert todo == []
    monkeypatch.undo()
    assert files(place) == other != old
    assert stored == store.read(NAME, place.parent)


def test_data_exchanged_all_the_time_are_refused(
    place: Path, other: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    exchanging_before(monkeypatch, TRAJECTORY, lambda: store.replace_folder(place, other))
    with pytest.raises(InputError, match="exchanged again and again"):
        load(NAME, folder=place.parent)


def test_damage_is_reported_at_once(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[str] = []
    exchanging_before(monkeypatch, SCENE, lambda: looks.append("look"))
    (place / EVENTS).write_bytes(b"\xff")
    with pytest.raises(InputError, match="UTF-8"):
        store.read(NAME, place.parent)
    assert looks == []
