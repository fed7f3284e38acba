"""The command `etextile`: its verbs, and what becomes of errors (exit codes 0, 1, 2, 3, 4, 130).

A verb is one function in a module of its own and one line in `VERBS`. Everything heavy is imported inside the verbs,
so that `etextile --help` stays under 0.3 s.
"""

from __future__ import annotations

import errno
import os
import re
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from itertools import pairwise

from cyclopts import App, CycloptsError

from etextile.app.streams import ended, prepare
from etextile.collisions import require_own_packages
from etextile.environment import look_for_garbage_seldom
from etextile.errors import BadInput, EtextileError
from etextile.files import short, too_long
from etextile.visible import visible


INTERRUPTED = 130
FAULT = 1
MOST_PROBLEMS = 20
"""Problems that are listed one by one."""
LONGEST = 1200
"""Characters of one message."""
OUTPUTS = ("-o", "--output", "--build")
WRONG_PLACE = (
    errno.ENAMETOOLONG,
    errno.ELOOP,
    errno.EACCES,
    errno.EPERM,
    errno.ENOENT,
    errno.EEXIST,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EROFS,
)

VERBS = {
    "check": ("etextile.app.verbs_case:check", "etextile check elbow --set motion.total='35 mm'"),
    "run": ("etextile.app.verbs_case:run", "etextile run punch -o out/punch --set contact.friction=stick"),
    "report": ("etextile.app.verbs_folder:report", "etextile report out/punch --format json"),
    "show": ("etextile.app.verbs_show:show", "etextile show out/punch"),
    "map": ("etextile.app.verbs_map:map_", "etextile map out/punch --field weft_strain --camera top --step 10"),
    "inspect": ("etextile.app.verbs_inspect:inspect", "etextile inspect measured/warp_1.csv -o look.png"),
    "identify": ("etextile.app.verbs_identify:identify", "etextile identify measured/ -o fabric.yaml"),
    "calibrate": (
        "etextile.app.verbs_calibrate:calibrate",
        "etextile calibrate bulge_valmex --measured valmex_bulge --free fabric.warp.H,fabric.weft.H -o fabric.yaml",
    ),
    "compare": ("etextile.app.verbs_diagnose:compare", "etextile compare punch --measured hidden_clamp"),
    "diagnose": (
        "etextile.app.verbs_diagnose:diagnose",
        "etextile diagnose punch --measured hidden_clamp -o out/diagnosis",
    ),
    "ensemble": ("etextile.app.verbs_ensemble:ensemble", "etextile ensemble punch -n 128 --seed 1 -o out/ensemble"),
    "compare-designs": (
        "etextile.app.verbs_ensemble:compare_designs",
        "etextile compare-designs punch punch --set-b wires.loops.slack='5 %' --set failure.criterion=wire_strain",
    ),
    "size-loops": ("etextile.app.verbs_size_loops:size_loops", "etextile size-loops elbow --target 0.01"),
    "layout": ("etextile.app.verbs_layout:layout", "etextile layout elbow -o layout.dxf"),
    "life": ("etextile.app.verbs_life:life", "etextile life life.csv --required-cycles 20000 -o out/life"),
    "list": ("etextile.app.verbs_about:list_", "etextile list fabrics wires -v"),
    "schema": ("etextile.app.verbs_about:schema", "etextile schema > etextile.schema.json"),
    "completion": ("etextile.app.verbs_about:completion", "etextile completion bash >> ~/.bashrc"),
    "manual": ("etextile.app.verbs_manual:manual", "etextile manual --build manual/html"),
}
"""Verb: where its function is, and the example shown by --help."""

ABOUT = "Do the conductive wires in a woven fabric survive an elbow or a knee?"
CLOSING = """Example:

  etextile run elbow -o out/elbow

Exit codes: 0 done, 2 bad input, 3 no equilibrium, 4 done but a trust limit was passed, 130 interrupted."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code (console entry point)."""
    if arguments is not None:
        return _answer(list(arguments))
    look_for_garbage_seldom()
    below = prepare()
    code = _answer(sys.argv[1:])
    trouble = ended(below)
    return _complain(trouble, code or FAULT) if trouble else code


def _answer(tokens: list[str]) -> int:
    """Run the command line and turn every error into a message and an exit code."""
    try:
        require_own_packages()
        _refuse_nameless(tokens)
        return _run(tokens)
    except CycloptsError as error:
        return _complain(_usage_message(error, tokens), 2)
    except EtextileError as error:
        return _complain(_message(error), error.exit_code)
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)
    except OSError as error:
        return _complain(_system_message(error), 2 if error.errno in WRONG_PLACE else FAULT, show=_verbose(tokens))
    except Exception as error:
        own = import_module("etextile.plugins").raised_in(error)
        if own is not None:
            return _complain(_own_message(error, own), 2, show=_verbose(tokens))
        return _complain(_fault_message(error), FAULT, show=_verbose(tokens))


def _run(tokens: list[str]) -> int:
    """Parse the tokens, run the verb and return its exit code."""
    result = command_line()(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    sys.stdout.flush()
    return result if isinstance(result, int) else 0


def _refuse_nameless(tokens: Sequence[str]) -> None:
    """Refuse an empty name of an output, which would stand for the working folder."""
    for option, value in pairwise([*tokens, "-"]):
        if (option in OUTPUTS and not value.strip()) or option in {f"{name}=" for name in OUTPUTS}:
            raise BadInput.of(f"{option.rstrip('=')} needs a name (got ''), write . for the working folder")


def command_line() -> App:
    """Return the command with all its verbs."""
    app = App(
        name="etextile",
        help=ABOUT,
        help_format="plaintext",
        help_epilogue=CLOSING,
        version=_version,
        suppress_keyboard_interrupt=False,
    )
    for order, (verb, (place, example)) in enumerate(VERBS.items()):
        module, _, function = place.partition(":")
        command = getattr(import_module(module), function)
        app.command(command, name=verb, sort_key=order, help_epilogue=f"Example:\n\n  {example}")
    return app


def _version() -> str:
    """Return the version of the installed package."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"etextile {version('etextile')}"
    except PackageNotFoundError:
        return "etextile (source folder, not installed)"


def _complain(text: str, code: int, *, show: bool = False) -> int:
    """Print a message (and with `show` the traceback) to the standard error and return the exit code."""
    if show:
        traceback.print_exc()
    print(visible(text), file=sys.stderr)
    return code


def _verbose(tokens: list[str]) -> bool:
    """Tell whether the user asked for details."""
    return "-v" in tokens or "--verbose" in tokens


def _message(error: EtextileError) -> str:
    """Return the text of an error; problems without a file get the name of the program."""
    if isinstance(error, BadInput):
        return "\n".join(_shown(error))
    return _cut(f"etextile: {error}")


def _shown(error: BadInput) -> list[str]:
    """Return the first problems in a line each, the others counted."""
    lines = [_cut(str(item) if item.file else f"etextile: {item}") for item in error.problems[:MOST_PROBLEMS]]
    left = len(error.problems) - len(lines)
    return [*lines, f"and {left} more problem{'s' if left > 1 else ''}"] if left else lines


def _cut(text: str) -> str:
    """Return a message without the middle of what is much too long to be read."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 4 :]}"


def _usage_message(error: CycloptsError, tokens: list[str]) -> str:
    """Return what is wrong with the command line, and where to read on."""
    verb = f" {tokens[0]}" if tokens and tokens[0] in VERBS else ""
    text = str(error).strip().replace("Unused Tokens", "too many arguments")
    text = re.sub(r'^Command ".*?" parameter (\S+) requires an argument\.', r"\1 is missing.", text)
    return f"etextile{verb}: {_cut(text)}\nSee: etextile{verb} --help"


def _system_message(error: OSError) -> str:
    """Return what the operating system refused, and on which file."""
    if error.errno == errno.ENAMETOOLONG:
        return f"etextile: {too_long(str(error.filename))}"
    return f"etextile: {short(str(error.filename or 'a file'))}: {error.strerror or error}"


def _own_message(error: Exception, own: traceback.FrameSummary) -> str:
    """Return one line about a Python file of the user that failed while the program called it."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    within = (
        ""
        if last.filename == own.filename
        else f" (raised in {last.filename.rpartition(os.sep)[2]}, line {last.lineno})"
    )
    return f"{own.filename}:{own.lineno}: {own.name} fails: {type(error).__name__}: {error}{within}"


def _fault_message(error: Exception) -> str:
    """Return one line about a fault of the program and how to report it."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f" in {os.path.basename(frames[-1].filename)}:{frames[-1].lineno}" if frames else ""  # noqa: PTH119
    return (
        f"etextile: fault of the program: {type(error).__name__}: {error}{place}\n"
        "Please report it with the case and the output of the same command with -v."
    )
