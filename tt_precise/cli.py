"""The command line: find a command, run the command, and report an error in one line.

Commands stand in files of ``commands``, imported only when called. Exit status: 0 all checks pass,
1 a check failed, 2 unusable input, 70 a bug in tt-precise.
"""

from __future__ import annotations

import errno
import importlib
import sys

import click

from tt_precise._version import __version__
from tt_precise.runtime.terminal import Terminated, in_a_process_of_ours, raise_at_sigterm
from tt_precise.runtime.values import InputError, wrong_name

# The file of each command, and what the command does.
COMMANDS = {
    "run": ("run", "Integrate a scene."),
    "thresholds": ("events", "Determine lambda, its thresholds and asymptotic values in two ways."),
    "scene": ("scene", "Write, list or summarise scenes."),
    "events": ("events", "List the catalogue of events, or the events of a scene."),
    "golden": ("golden", "Make, verify, prove or list golden reference trajectories."),
    "check": ("check", "Check the conservation laws on a trajectory from any program."),
    "columns": ("check", "List the columns of a trajectory: names, units, frames, conventions."),
    "claims": ("claims", "Show the verdicts on the paper's claims."),
    "tradeoff": ("numerics", "Measure what a digit costs on a scene, with SciPy beside it."),
    "extremes": ("numerics", "Test numerical stability in extreme cases."),
    "sweep": ("sweep", "Integrate a scene from many starts, plot a sweep, or find a threshold."),
    "engines": ("check", "Test a physics engine at decreasing steps."),
    "report": ("claims", "Write the precision report."),
}
DONE, CHECK_FAILED, BAD_INPUT, BUG = 0, 1, 2, 70  # 70: EX_SOFTWARE of sysexits.h
INTERRUPTED, READER_GONE, TERMINATED = 130, 141, 143  # as shells report SIGINT, SIGPIPE, SIGTERM
# The errors of a system that has no more space, memory or open files.
EXHAUSTED = {errno.ENOSPC, errno.EDQUOT, errno.ENOMEM, errno.EMFILE}


class _Lazy(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            raise wrong_name("command", name, COMMANDS)
        module = importlib.import_module(f"tt_precise.commands.{COMMANDS[name][0]}")
        command: click.Command = getattr(module, f"{name}_command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, does) for name, (_, does) in COMMANDS.items()])


@click.group(cls=_Lazy, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, package_name="tt-precise")
def group() -> None:
    """Reference-grade verification of the dynamics of the Tippe Top."""


def main(argv: list[str] | None = None) -> int:
    """Run the command line with ``argv``; return the exit status."""
    try:
        status = group.main(args=argv, prog_name="tt-precise", standalone_mode=False)
    except click.exceptions.Exit as error:
        return error.exit_code
    except click.exceptions.Abort:
        return _complain("interrupted", INTERRUPTED)
    except Terminated:
        return _complain("terminated", TERMINATED)
    except SystemExit:  # click's way to say that the reader of a pipe (head, less) has gone
        return READER_GONE
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return BAD_INPUT
    except click.UsageError as error:
        hint = f" See `{error.ctx.command_path} --help`." if error.ctx else ""
        return _complain(f"{error.format_message()}{hint}", BAD_INPUT)
    except (InputError, MemoryError) as error:
        return _complain(str(error) or "out of memory, expected a smaller problem", BAD_INPUT)
    except Exception as error:
        if getattr(error, "errno", None) in EXHAUSTED:
            return _complain(error, BAD_INPUT)
        sys.excepthook(type(error), error, error.__traceback__)
        return _complain(f"a bug in tt-precise {__version__} ({type(error).__name__})", BUG)
    return status if isinstance(status, int) else DONE


def _complain(message: object, status: int) -> int:
    click.echo(f"tt-precise: {' '.join(str(message).split())}", err=True)
    return status


def entry() -> None:
    """Console entry point."""
    in_a_process_of_ours()
    raise_at_sigterm()
    sys.exit(main())
