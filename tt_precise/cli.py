"""The command line: find a command, run the command, and report an error in one line.

Each command is one file in ``commands`` and is imported only when called, so that ``--help``
and ``check`` start fast. Exit status: 0 all checks pass, 1 a check failed, 2 unusable input, 70 a
bug in tt-precise.
"""

from __future__ import annotations

import errno
import importlib
import os
import sys

import click

from tt_precise._version import __version__
from tt_precise.commands.options import Group
from tt_precise.runtime.process import Terminated, end_within, in_a_process_of_ours, raising_signals
from tt_precise.runtime.terminal import open_closed_streams
from tt_precise.runtime.values import InputError, wrong_name

COMMANDS = {
    "run": "Integrate a scene.",
    "thresholds": "Determine lambda, its thresholds and asymptotic values, each in two ways.",
    "scene": "Write, list or summarise scenes.",
    "events": "List the catalogue of events, or the events of a scene.",
    "golden": "Make, verify, prove or list golden reference trajectories.",
    "check": "Check the conservation laws on a trajectory from any program.",
    "columns": "List the columns of a trajectory: names, units, frames, conventions.",
    "claims": "Show the verdicts on the paper's claims.",
    "tradeoff": "Measure what a digit costs on a scene, with SciPy beside it.",
    "extremes": "Test numerical stability in extreme cases.",
    "sweep": "Integrate a scene from many starts, or plot a sweep.",
    "engines": "Test physics engines: the installed ones, or your own.",
    "report": "Write the precision report.",
}

# What people try as commands, and what does that.
MEANT = {
    "plot": "run SCENE --plot top.png", "animate": "run SCENE --animate top.html",
    "drift": "run SCENE --plot drift.png --columns drift:lambda,drift:E", "list": "scene list",
    "scenes": "scene list", "new": "scene new top.toml", "find": "sweep find SCENE omega_3=20:260",
    "threshold": "sweep find SCENE omega_3=20:260", "map": "sweep plot", "help": "COMMAND --help",
    "spread": 'in Python tt.integrate(scene, sensitivity=["mu"]).sensitivity.spread({"mu": "5 %"})',
}  # fmt: skip

# What people look for among the options, and where it is.
ELSEWHERE = {
    **dict.fromkeys(
        ("mu", "friction", "theta", "omega_3", "spin", "mass", "radius", "alpha", "m", "R", "set"),
        "It stands in the scene's file: `tt-precise scene new top.toml`.",
    ),
    "plot": "`tt-precise sweep plot RESULT` and `tt-precise run SCENE --plot top.png` draw.",
}

DONE, CHECK_FAILED, BAD_INPUT, BUG = 0, 1, 2, 70  # 70: EX_SOFTWARE of sysexits.h
INTERRUPTED, READER_GONE, TERMINATED = 130, 141, 143  # as shells report SIGINT, SIGPIPE, SIGTERM
LEAVING_S = 2.0
# what the system refuses anybody: space, memory, processes, open files
EXHAUSTED = {
    errno.ENOSPC, errno.EDQUOT, errno.ENOMEM, errno.EAGAIN, errno.EMFILE, errno.ENFILE,
    errno.ENAMETOOLONG,
}  # fmt: skip


class _Lazy(Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            if args[0] in MEANT:
                raise InputError(f"command: got {args[0]!r}, expected {MEANT[args[0]]}")
            raise wrong_name("command", args[0], COMMANDS)
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module = importlib.import_module(f"tt_precise.commands.{name}")
        command: click.Command = module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, package_name="tt-precise")
def group() -> None:
    """Reference-grade verification of the dynamics of the Tippe Top."""


def main(argv: list[str] | None = None) -> int:
    """Run the command line with ``argv``; returns the exit status."""
    try:
        status = group.main(args=argv, prog_name="tt-precise", standalone_mode=False)
    except click.exceptions.Exit as left:
        return left.exit_code
    except click.exceptions.Abort:
        return _complain("interrupted", INTERRUPTED)
    except Terminated:
        return _complain("terminated", TERMINATED)
    except click.exceptions.NoArgsIsHelpError as help_text:
        click.echo(help_text.format_message(), err=True)
        return BAD_INPUT
    except click.UsageError as error:
        return _complain(_with_advice(error), BAD_INPUT)
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except InputError as error:
        return _complain(str(error), BAD_INPUT)
    except OSError as error:
        if error.errno not in EXHAUSTED:
            return _bug(error)
        place = f"{error.filename}: " if error.filename else ""
        return _complain(
            f"{place}{error.strerror}; expected free space, a higher limit or a shorter name",
            BAD_INPUT,
        )
    except MemoryError:
        return _complain("out of memory; expected a smaller problem, or more memory", BAD_INPUT)
    except Exception as error:
        return _bug(error)
    except SystemExit:
        # click's way to say that the reader (head, less) has gone; as nobody has read whether all
        # checks pass, the status must not say so
        return READER_GONE
    return status if isinstance(status, int) else DONE


def _with_advice(error: click.UsageError) -> str:
    """The message with the help text of the parameter that it is about, or the way to the help."""
    message = error.format_message()
    if error.ctx is None:
        return message
    name = getattr(error, "option_name", None)
    given = getattr(error, "param", None)
    for parameter in error.ctx.command.params:
        text = getattr(parameter, "help", None)
        if text and (parameter is given or name in parameter.opts):
            return f"{message} {text}"
    said = ""
    if "extra argument" in error.message:
        said = ": lists are written with commas, without spaces."
        if "=" in error.message:
            said = ": numbers are varied with --vary NAME=FIRST:LAST:COUNT."
    elif isinstance(error, click.NoSuchOption):
        place = ELSEWHERE.get(error.option_name.lstrip("-").replace("-", "_"), "")
        if place:  # what click proposes is alike in letters only
            message, said = f"No such option '{error.option_name}'.", f" {place}"
    return f"{message}{said} See `{error.ctx.command_path} --help`."


def _complain(message: object, status: int) -> int:
    click.echo(f"tt-precise: {' '.join(str(message).split())}", err=True)
    return status


def _bug(error: BaseException) -> int:
    import traceback

    click.echo("".join(traceback.format_exception(error)), err=True)
    return _complain(
        f"this is a bug in tt-precise {__version__} ({type(error).__name__}), and nothing was "
        "checked; please report it with the lines above",
        BUG,
    )


def entry() -> None:
    """Console entry point."""
    open_closed_streams()
    in_a_process_of_ours()
    with raising_signals():
        status = main()
    try:
        sys.stdout.flush()
    except OSError:
        # reported already; without this, Python would try again when it ends, and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    # all is done and printed: threads that are left, such as those of a dask client whose
    # scheduler has gone, must not keep the process
    end_within(LEAVING_S, status)
    sys.exit(status)


if __name__ == "__main__":
    entry()
