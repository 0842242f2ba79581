"""Files and names from people who mean no good."""

from __future__ import annotations

import pickle
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from tt_precise.errors import InputError
from tt_precise.extremes.abuse.commands import Answer, here
from tt_precise.extremes.case import Observation, case, same, together
from tt_precise.scene import load_scene

TEXTS: dict[str, Callable[[], bytes]] = {
    "10 MB of keys": lambda: b"".join(b'k%d = "%d"\n' % (i, i) for i in range(600_000)),
    "100,000 brackets": lambda: b"a = " + b"[" * 49_000 + b"]" * 49_000,
    "20,000 tables in tables": lambda: b"a = " + b"{b = " * 19_000,
    "a key of 40,000 parts": lambda: b".".join([b"a"] * 40_000) + b" = 1",
    "an integer of 90,000 digits": lambda: b"a = " + b"9" * 90_000,
    "Latin-1": lambda: load_scene("reference").text.encode() + "# Kreisel f\xfcr".encode("latin-1"),
    "UTF-16": lambda: load_scene("reference").text.encode("utf-16"),
    "a null character": lambda: b'title = "\0"',
    "nothing": lambda: b"",
}
READERS: dict[str, list[str]] = {
    "run": [],
    "sweep": [],
    "thresholds": [],
    "events": [],
    "golden build": ["--folder", "golden"],
}


@case(
    "{reader}: a TOML file with {text}",
    expected="status 2 and one line",
    source="the contract of the command line",
    over={"reader": tuple(READERS), "text": tuple(TEXTS)},
    quick=True,
    control={"content": lambda: load_scene("reference").text.encode()},
)
def hostile_toml(reader: str, text: str, content: Callable[[], bytes] | None = None) -> Observation:
    """Within the time of a case: some of them take tomllib minutes, if they are let."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "a.toml"
        file.write_bytes((content or TEXTS[text])())
        options = [str(Path(place) / one) if one == "golden" else one for one in READERS[reader]]
        answer = here(*reader.split(), str(file), *options)
    return Observation(answer.told, answer.one_line)


NAMES = {
    "a file above": "../../etc/passwd",
    "an endless device": "/dev/zero",
    "this folder": ".",
    "the root": "/",
    "nothing": "",
    "a blank": " ",
    "a dash": "-",
    "two lines": "a\nb",
    "an escape sequence": "\x1b[31m",
    "a null character": "a\0b",
    "no Unicode": "\udcff.toml",
    "5000 letters": "a" * 5000,
    "a file name too long": "a" * 300 + ".toml",
    "an address": "file:///etc/passwd",
    "a command": "$(touch hacked)",
    "the folder above": "..",
}


@case(
    "as scene name {kind}",
    expected="status 2 and one line of every command that takes a scene",
    source="the contract of the command line",
    over={"kind": tuple(NAMES)},
    quick=True,
    control={"given": "reference"},
)
def hostile_name(kind: str, given: str | None = None) -> Observation:
    """Names of scenes are names of shipped ones or paths of files, and nothing else."""
    wanted = NAMES[kind] if given is None else given
    answers: list[Answer] = [
        here(*command, wanted)
        for command in (["run"], ["thresholds"], ["events"], ["golden", "verify"])
    ]
    wrong = [answer for answer in answers if not answer.one_line]
    return Observation((wrong or answers)[0].told, not wrong)


@case(
    "a scene file called {name}",
    expected="golden build refuses it in one line, and writes nothing outside its folder",
    source="the scene's name becomes the name of a folder",
    over={"name": ("...toml", "..toml", ".new-upright.toml", "a b.toml", "-x.toml")},
    quick=True,
    control={"renamed": "fine.toml"},
)
def hostile_file_name(name: str, renamed: str | None = None) -> Observation:
    """Path("...toml").stem is the folder above."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / (renamed or name)
        file.write_text(load_scene("upright").text.replace('until = "8"', 'until = "0.01"'))
        folder = Path(place) / "golden" / "data"
        answer = here("golden", "build", "--folder", str(folder), "--workers", "1", "--", str(file))
        beside = [one.name for one in folder.parent.glob("*") if one != folder]
        inside = [one.name for one in folder.glob("*")] if folder.exists() else []
    return together(Observation(answer.told, answer.one_line), same([*beside, *inside], []))


FORBIDDEN = (
    "pickle.find_class",
    "os.system",
    "subprocess.Popen",
    "os.exec",
    "os.posix_spawn",
    "exec",
)


class Payload:
    """What runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return print, ("unpickled",)


@case(
    "code in data files: {kind}",
    expected="refused, or read as the text that it is; no event of an execution in the audit log",
    source="sys.addaudithook tells of every unpickling, exec and new process (PEP 578)",
    over={"kind": ("CSV", "Parquet", "JSON", "TOML", "gzip", "pickle")},
    quick=True,
    control={"read": lambda path: pickle.loads(pickle.dumps(Payload()))},
)
def code_in_data(kind: str, read: Callable[[Path], Any] | None = None) -> Observation:
    """The files that commands take from others, with a payload in each."""
    payload = pickle.dumps(Payload())
    formula = "=cmd|' /C calc'!A0,@SUM(1),__import__('os').system('true')"
    contents = {
        "CSV": ("a.csv", f"t,kx,ky,kz,Lx,Ly,Lz\n{formula},0,0,0\n".encode()),
        "Parquet": ("a.parquet", b"PAR1" + payload + b"PAR1"),
        "JSON": ("manifest.json", b'{"py/object": "os.system", "py/reduce": ["true"]}'),
        "TOML": ("a.toml", b"title = \"{__import__('os').system('true')}\""),
        "gzip": ("a.csv.gz", payload),
        "pickle": ("a.csv", payload),
    }
    name, content = contents[kind]
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "x" / name
        path.parent.mkdir()
        path.write_bytes(content)
        _read(path)  # imports, which do execute code, are done here
        seen = _audited(lambda: (read or _read)(path))
    return same(seen, [])


def _read(path: Path) -> None:
    import tt_precise as tt

    with suppress(InputError):
        if path.suffix == ".toml":
            tt.load_scene(str(path))
        elif path.suffix == ".json":
            tt.golden.load(path.parent.name, folder=path.parent.parent)
        else:
            tt.check.conservation(path, "reference")


def _audited(function: Callable[[], Any]) -> list[str]:
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
