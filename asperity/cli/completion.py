"""``asperity completion``: a script that lets the shell complete commands, options and files."""

from __future__ import annotations

import argparse

from .exit_codes import EXIT_OK

EPILOG = """examples:
  asperity completion bash > ~/.local/share/bash-completion/completions/asperity
  asperity completion zsh > ~/.zfunc/_asperity    # a folder of $fpath
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The shell."""
    parser.add_argument("shell", choices=["bash", "zsh"])


def run(args: argparse.Namespace) -> int:
    """Print the script; it is made once, and asks nothing of this program afterwards."""
    import shtab

    from .main import COMMANDS, build_parser

    parser = build_parser(*COMMANDS)
    _complete_files(parser)
    print(shtab.complete(parser, shell=args.shell))
    return EXIT_OK


def _complete_files(parser: argparse.ArgumentParser) -> None:
    """Tell which options take a file or a folder."""
    import shtab

    takes = {"FILE": shtab.FILE, "RESULTS": shtab.FILE, "DIR": shtab.DIRECTORY}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                _complete_files(inner)
        elif isinstance(action.metavar, str) and action.metavar in takes:
            action.complete = takes[action.metavar]  # type: ignore[attr-defined]
