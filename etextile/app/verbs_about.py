"""Verbs about the program itself: list, schema and completion."""

from __future__ import annotations

import json
from typing import Annotated, Literal

from cyclopts import Parameter

from etextile.app.options import Verbose


def list_(*kinds: Annotated[str, Parameter(name="KIND")], verbose: Verbose = False) -> int:
    """List what is built in: cases, fabrics, wires, bodies, ...; -v shows numbers with sources.

    Parameters
    ----------
    kinds
        What to list: cases, fabrics, wires, bodies, effects, criteria, scatter, sites, solvers; all when left out.
        layout CASE lists the wires, loops and parts of a case.
    """
    if kinds[:1] == ("layout",) and len(kinds) == 2:
        from etextile.app.verbs_layout import layout

        return layout(kinds[1])
    from etextile.app.show import show
    from etextile.text.listing import listings

    show(listings(kinds, verbose=verbose))
    return 0


def schema(kind: Annotated[Literal["case", "fabric", "wire", "measured"], Parameter(name="KIND")] = "case", /) -> int:
    """Print the JSON Schema of case files and others for editors.

    Parameters
    ----------
    kind
        Kind of file: case, fabric, wire or measured (measured.yaml).
    """
    from loadcases.json_schema import json_schema

    print(json.dumps(json_schema(kind), indent=2, ensure_ascii=False))
    return 0


def completion(shell: Annotated[Literal["bash", "zsh", "fish"], Parameter(name="SHELL")], /) -> int:
    """Print what makes a shell complete verbs and options with the tab key.

    Parameters
    ----------
    shell
        bash (append to ~/.bashrc), zsh (a file _etextile in a folder of $fpath) or fish
        (~/.config/fish/completions/etextile.fish).
    """
    from etextile.app.cli import command_line

    print(command_line().generate_completion(prog_name="etextile", shell=shell))
    return 0
