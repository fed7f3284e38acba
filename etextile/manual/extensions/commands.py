"""What a page shows is what happened: its files are written, its commands are run, its pictures were drawn.

Each page has a working folder of its own. A command that ends with another exit code than the page expects is a
warning, and so an error of the build.

    :::{file} mine.yaml          writes the file and shows it
    :::{command} 4               runs the lines (the number is the exit code expected, 0 when left out) and shows them
    :::{drawn} out/map.png       shows a picture that a command has left; the content is its alternative text
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective


LOGGER = logging.getLogger(__name__)
TIMEOUT_S = 300
LANGUAGES = {".yaml": "yaml", ".py": "python", ".csv": "text", ".sh": "bash", ".toml": "toml", ".yml": "yaml"}


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives; a page that is read again starts with an empty folder."""
    app.add_directive("file", FileDirective)
    app.add_directive("command", CommandDirective)
    app.add_directive("drawn", DrawnDirective)
    app.connect("source-read", _empty_folder)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def folder_of(app: Sphinx, page: str) -> Path:
    """Return the working folder of a page, beside the stage."""
    return Path(app.srcdir).parent / "work" / page


def _empty_folder(app: Sphinx, page: str, _: list[str]) -> None:
    shutil.rmtree(folder_of(app, page), ignore_errors=True)


class FileDirective(SphinxDirective):
    """Write the content as a file of the page's folder and show it under its name."""

    has_content = True
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the file as a block of code."""
        path = folder_of(self.env.app, self.env.docname) / self.arguments[0]
        path.parent.mkdir(parents=True, exist_ok=True)
        text = "\n".join(self.content) + "\n"
        path.write_text(text, encoding="utf-8")
        name = nodes.paragraph("", "", nodes.literal(text=self.arguments[0]), classes=["file-name"])
        return [name, nodes.literal_block(text, text, language=LANGUAGES.get(path.suffix, "text"))]


class CommandDirective(SphinxDirective):
    """Run the lines of the content in the page's folder and show them with what they print."""

    has_content = True
    optional_arguments = 1
    option_spec = {"lines": directives.nonnegative_int, "silent": directives.flag}  # noqa: RUF012 (docutils' own way)

    def run(self) -> list[nodes.Node]:
        """Return the commands and their output, cut to `lines`."""
        folder = folder_of(self.env.app, self.env.docname)
        folder.mkdir(parents=True, exist_ok=True)
        shown: list[nodes.Node] = []
        for line in self.content:
            command = nodes.literal_block(line, line, language="bash", classes=["command"])
            output = self._output(line, folder)
            shown.append(command)
            if output and "silent" not in self.options:
                shown.append(nodes.literal_block(output, output, language="text", classes=["output"]))
        return shown

    def _output(self, line: str, folder: Path) -> str:
        """Return what a command prints; another exit code than the one expected is a warning."""
        expected = int(self.arguments[0]) if self.arguments else 0
        try:
            ended = subprocess.run(
                ["bash", "-c", line], cwd=folder, env=_environment(), text=True, timeout=TIMEOUT_S, check=False,
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            LOGGER.warning("%r takes more than %d s", line, TIMEOUT_S, location=self.get_location())
            return ""
        if ended.returncode != expected:
            message = "%r ended with exit code %d, not %d:\n%s"
            LOGGER.warning(message, line, ended.returncode, expected, ended.stdout, location=self.get_location())
        lines = ended.stdout.strip("\n").replace(str(folder), ".").splitlines()
        most = self.options.get("lines", len(lines))
        return "\n".join([*lines[:most], "..."] if len(lines) > most else lines)


class DrawnDirective(SphinxDirective):
    """Show a picture that a command of this page has left in the page's folder."""

    has_content = True
    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the picture, copied to where Sphinx finds it."""
        source = folder_of(self.env.app, self.env.docname) / self.arguments[0]
        if not source.is_file():
            LOGGER.warning("no command of this page has drawn %s", self.arguments[0], location=self.get_location())
            return []
        name = f"drawn/{self.env.docname.replace('/', '-')}-{source.name}"
        target = Path(self.env.app.srcdir) / name
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(source, target)
        image = nodes.image(uri=f"/{name}", alt=" ".join(self.content))
        image.document = self.state.document
        return [image]


def _environment() -> dict[str, str]:
    """Return the environment of the commands: this Python's own commands first, plain text of fixed width."""
    own = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return {**os.environ, "PATH": own, "COLUMNS": "100", "NO_COLOR": "1", "TERM": "dumb"}
