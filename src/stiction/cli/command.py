"""What all commands have in common: ``--quiet``, Ctrl-C, and examples at the end of their help."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperCommand

from stiction.cli.complete import completer_of
from stiction.cli.console import complain, hush

HEADING = re.compile(r"^Examples(.*):$", re.MULTILINE)
INTERRUPTED = 130
"""Exit status after Ctrl-C."""
UNWRAPPED = "\b"
"""Before a paragraph of a docstring whose lines stay as they are."""


class Example(NamedTuple):
    """A line that a user can type, and what it does where that is not plain."""

    line: str
    remark: str


def parts(text: str) -> tuple[str, str, list[Example]]:
    """What a docstring says of a command, what it says of its examples, and the examples.

    They are its last paragraph; a backslash at the end of a line goes on in the next::

        Examples:
          stiction run ramp        # what it does
    """
    text = inspect.cleandoc(text)
    found = HEADING.search(text)
    if found is None:
        return text, "", []
    rows = re.sub(r"\\\n\s*", "", text[found.end() :]).splitlines()
    split = [row.partition(" # ") for row in rows if row.strip()]
    examples = [Example(line.strip(), remark.strip()) for line, _, remark in split]
    return text[: found.start()].rstrip(f"{UNWRAPPED}\n "), found[1].strip(), examples


class Command(TyperCommand):
    """A command whose help ends in its examples."""

    def __init__(self, *args: Any, help: str | None = None, **kwargs: Any) -> None:
        said, self.legend, self.examples = parts(help or "")
        super().__init__(*args, help=said, **kwargs)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """The help as typer prints it, and the examples below."""
        from rich.console import Console
        from rich.markup import escape
        from rich.panel import Panel

        super().format_help(ctx, formatter)
        width = max((len(line) for line, remark in self.examples if remark), default=0)
        rows = [
            f"{escape(line)}{' ' * (width - len(line))}  [dim]# {escape(remark)}[/]" if remark else escape(line)
            for line, remark in self.examples
        ]
        title = f"Examples {escape(self.legend)}".strip()
        Console(highlight=False).print(Panel("\n".join(rows), title=title, title_align="left", border_style="dim"))


Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Say nothing but the result, warnings and errors.", callback=hush),
]


def common(function: Callable[..., None]) -> Callable[..., None]:
    """The command with what it need not know of: an option ``--quiet``, and a word and a status for Ctrl-C, and
    names that complete in a shell."""

    @functools.wraps(function)
    def called(*args: Any, quiet: bool = False, **kwargs: Any) -> None:
        try:
            function(*args, **kwargs)
        except KeyboardInterrupt:
            complain("interrupted.")
            raise typer.Exit(INTERRUPTED) from None

    own = inspect.signature(function, eval_str=True)
    for name, parameter in own.parameters.items():
        for info in getattr(parameter.annotation, "__metadata__", ()):
            info.autocompletion = completer_of(function.__name__, name)
    more = inspect.Parameter("quiet", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Quiet)
    called.__signature__ = own.replace(parameters=[*own.parameters.values(), more])  # type: ignore[attr-defined]  # functions have it
    called.__annotations__ = {**function.__annotations__, "quiet": Quiet}
    return called
