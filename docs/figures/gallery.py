"""The pictures of gallery-of-figures.md: its commands, run as they stand, unless nothing has changed since."""

from __future__ import annotations

import hashlib
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

import stiction

DOCS = Path(__file__).resolve().parent.parent
PAGE = DOCS / "gallery-of-figures.md"
FOLDER = DOCS / "_build" / "figures"
STAMP = "made-from"
"""File beside the pictures that says what they were made from."""


def commands(text: str) -> dict[str, list[str]]:
    """Figures that a page asks for by the rest of the command that makes them: the scene and all that changes it.

    Args:
        text: of the page; a command is an indented line ``stiction run SCENE … --plot KIND``.
    """
    found: dict[str, list[str]] = {}
    for line in re.findall(r"^ {4}stiction run (.*)$", text, re.MULTILINE):
        scene, *options = shlex.split(line)
        kinds = [b for a, b in pairwise(options) if a == "--plot"]
        at = [i for i, option in enumerate(options) if option == "--plot"]
        rest = [option for i, option in enumerate(options) if i not in at and i - 1 not in at]
        found.setdefault(shlex.join([scene, *rest]), []).extend(kinds)
    return found


def state(text: str) -> str:
    """A hash of all that the pictures depend on: the commands and the package."""
    return hashlib.blake2b(f"{commands(text)!r} {state_of_package()}".encode(), digest_size=16).hexdigest()


def state_of_package() -> str:
    """A hash of the package's sources."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sources():
        digest.update(path.read_bytes())
    return digest.hexdigest()


def sources() -> Iterable[Path]:
    """Every source of the package, scenes, tables and styles included, in a fixed order."""
    package = Path(stiction.__file__).parent
    return sorted(path for ending in ("py", "toml", "mplstyle") for path in package.rglob(f"*.{ending}"))


def draw(say: Callable[[str], object] = print) -> None:
    """Draw the pictures of the page that are missing or no longer true.

    Args:
        say: told before each scene runs.

    Raises:
        RuntimeError: a command failed; what it said is in the text.
    """
    text = PAGE.read_text(encoding="utf-8")
    now, stamp = state(text), FOLDER / STAMP
    if stamp.exists() and stamp.read_text() == now and all((FOLDER / name).exists() for name in pictures(text)):
        return
    FOLDER.mkdir(parents=True, exist_ok=True)
    stamp.unlink(missing_ok=True)
    for command, kinds in commands(text).items():
        say(f"drawing figures of {command}: {', '.join(kinds)}")
        plots = [word for kind in kinds for word in ("--plot", kind)]
        whole = [sys.executable, "-m", "stiction.cli.main", "run", *shlex.split(command), *plots]
        done = subprocess.run(whole, cwd=FOLDER, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"stiction run {command} failed: {done.stderr.strip()}")
    stamp.write_text(now)


def pictures(text: str) -> set[str]:
    """Names of the pictures that a page shows out of that folder."""
    return set(re.findall(r"_build/figures/([\w.-]+)", text))


if __name__ == "__main__":
    draw()
