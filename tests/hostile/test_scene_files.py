"""Files and names from people who mean no good: one line, status 2, and nothing executed."""

import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import tt_precise as tt
from tests.hostile.conftest import Commands
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

TEXTS: dict[str, Callable[[], bytes]] = {
    "10 MB of keys": lambda: b"".join(b'k%d = "%d"\n' % (i, i) for i in range(600_000)),
    "a key of 40,000 parts": lambda: b".".join([b"a"] * 40_000) + b" = 1",
    "Latin-1": lambda: load_scene("reference").text.encode() + "# Kreisel f\xfcr".encode("latin-1"),
    "UTF-16": lambda: load_scene("reference").text.encode("utf-16"),
    "nothing": lambda: b"",
}


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("reader", ["thresholds", "sweep"])
def test_a_hostile_toml_file_is_refused(
    commands: Commands, tmp_path: Path, reader: str, text: str
) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(TEXTS[text]())
    answer = commands.here(reader, str(file))
    assert answer.one_line, answer


NAMES = {
    "a file above": "../../etc/passwd", "an endless device": "/dev/zero", "this folder": ".",
    "the root": "/", "nothing": "", "a blank": " ", "a dash": "-", "two lines": "a\nb",
    "an escape sequence": "\x1b[31m", "a null character": "a\0b", "no Unicode": "\udcff.toml",
    "5000 letters": "a" * 5000, "a file name too long": "a" * 300 + ".toml",
    "an address": "file:///etc/passwd", "a command": "$(touch hacked)", "the folder above": "..",
}  # fmt: skip


@pytest.mark.parametrize(
    ("command", "kind"),
    [*(("run", kind) for kind in NAMES), ("thresholds", "a file above"), ("events", "two lines"),
     *(("golden verify", kind) for kind in ("the folder above", "the root", "nothing"))],
)  # fmt: skip
def test_a_hostile_scene_name_is_refused(commands: Commands, kind: str, command: str) -> None:
    """Names of scenes are names of shipped ones or paths of files, and nothing else."""
    answer = commands.here(*command.split(), NAMES[kind])
    assert answer.one_line, answer


@pytest.mark.parametrize("name", ["...toml", "..toml", ".new-upright.toml", "a b.toml", "-x.toml"])
def test_a_scene_s_name_cannot_lead_golden_data_elsewhere(
    commands: Commands, tmp_path: Path, name: str
) -> None:
    """The scene's name becomes the name of a folder; Path("...toml").stem is the folder above."""
    folder, file = tmp_path / "golden" / "data", tmp_path / name
    file.write_text(load_scene("upright").text.replace('until = "8"', 'until = "0.01"'))
    build = ["golden", "build", "--workers", "1", "--folder", str(folder), "--"]
    answer = commands.here(*build, str(file))
    assert answer.one_line, answer
    assert [path for path in folder.parent.glob("*") if path != folder] == []
    assert not folder.exists() or list(folder.glob("*")) == []


FORBIDDEN = (
    "pickle.find_class", "os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "exec",
)  # fmt: skip


class Payload:
    """What runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return print, ("unpickled",)


PAYLOAD = pickle.dumps(Payload())
FORMULA = "=cmd|' /C calc'!A0,@SUM(1),__import__('os').system('true')"
DATA = {
    "CSV": ("a.csv", f"t,kx,ky,kz,Lx,Ly,Lz\n{FORMULA},0,0,0\n".encode()),
    "Parquet": ("a.parquet", b"PAR1" + PAYLOAD + b"PAR1"),
    "JSON": ("manifest.json", b'{"py/object": "os.system", "py/reduce": ["true"]}'),
    "TOML": ("a.toml", b"title = \"{__import__('os').system('true')}\""),
    "gzip": ("a.csv.gz", PAYLOAD),
    "pickle": ("a.csv", PAYLOAD),
}


@pytest.mark.parametrize("kind", DATA)
def test_no_code_in_a_data_file_is_run(tmp_path: Path, kind: str) -> None:
    """No unpickling, exec or new process: ``sys.addaudithook`` would hear of it (PEP 578)."""
    name, content = DATA[kind]
    path = tmp_path / "x" / name
    path.parent.mkdir()
    path.write_bytes(content)
    read(path)  # imports, which do execute code, are done here
    assert audited(lambda: read(path)) == []
    # what is run is heard of
    assert audited(lambda: pickle.loads(PAYLOAD)) == ["pickle.find_class"]


def read(path: Path) -> None:
    """As the commands read the files that others hand them."""
    with suppress(InputError):
        if path.suffix == ".toml":
            load_scene(str(path))
        elif path.suffix == ".json":
            tt.golden.load(path.parent.name, folder=path.parent.parent)
        else:
            tt.check.conservation(path, "reference")


def audited(function: Callable[[], Any]) -> list[str]:
    """The forbidden events while ``function`` runs."""
    seen: list[str] = []
    watching = True

    def hook(event: str, arguments: Any) -> None:
        # a hook stays for the life of the process
        if watching and event in FORBIDDEN:
            seen.append(event)

    sys.addaudithook(hook)
    function()
    watching = False
    return seen
