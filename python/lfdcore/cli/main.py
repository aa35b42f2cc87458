"""lfdcore: the command tree and what every command shares."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

import typer

from lfdcore import __version__
from lfdcore.cli import collaborate, convert, demo, drive, info, joystick, learn, node, predict, study, track

app = typer.Typer(
    name="lfdcore",
    help="Assistive robots that learn from a few demonstrations.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
app.command("demo")(demo.demo)
app.command("info")(info.info)
app.command("convert")(convert.convert)
app.command("predict")(predict.predict)
app.command("node", cls=node.NodeCommand)(node.node)
app.command("track")(track.track)
app.command("drive")(drive.drive)
app.command("collaborate")(collaborate.collaborate)
app.add_typer(joystick.app, name="joystick")
app.add_typer(learn.app, name="learn")
app.add_typer(study.app, name="study")


@app.callback(invoke_without_command=True)
def version(show: bool = typer.Option(False, "--version", help="Print the version and stop.")) -> None:
    """Assistive robots that learn from a few demonstrations."""
    if show:
        typer.echo(__version__)
        raise typer.Exit


EXTRAS = {
    "scipy": "study",
    "matplotlib": "study",
    "joblib": "study",
    "torch": "train",
    "onnx": "train",
    "sklearn": "train",
}
"""What is not installed by default, and the extra that brings it"""

INTERRUPTED = 130
"""Exit code after Ctrl-C, as of every program that SIGINT ends"""


def _fail(message: str, code: int = 1) -> NoReturn:
    print(f"lfdcore: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(code)


def main() -> None:
    """Runs a command: exit code 2 for wrong use, 1 for a failure with one clear line, 130 after Ctrl-C."""
    from lfdcore.errors import DataError, DeviceError, ModelError

    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda got, _: sys.exit(128 + got))  # as an exception it ends workers and closes files
    try:
        app()
    except (ValueError, DataError, DeviceError, ModelError) as error:
        _fail(str(error))
    except ModuleNotFoundError as missing:
        extra = EXTRAS.get((missing.name or "").split(".")[0])
        if extra is None:
            raise
        _fail(f"this needs {missing.name}: install lfdcore with the extra '{extra}'")
    except OSError as error:
        _fail(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except MemoryError:
        _fail("out of memory")
    except KeyboardInterrupt:
        _fail("interrupted", INTERRUPTED)
    except SystemExit as end:
        if end.code == INTERRUPTED:  # typer's word for Ctrl-C, without a word to the user
            _fail("interrupted", INTERRUPTED)
        raise
