"""Names that complete in a shell. Each Tab starts a process, so nothing here loads numba, pydantic or matplotlib."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from importlib import resources
from pathlib import Path

Completer = Callable[[str], list[str]]

RECORDINGS = (".h5", ".hdf5")


def completer_of(command: str, parameter: str) -> Completer | None:
    """What completes a parameter of a command, if anything does."""
    return COMPLETERS.get(f"{command}.{parameter}") or COMPLETERS.get(parameter)


def _scenes(incomplete: str) -> list[str]:
    return [*_builtin_scenes(incomplete), *_files(incomplete, ".toml")]


def _shown(incomplete: str) -> list[str]:
    return [*_builtin_scenes(incomplete), *_files(incomplete, ".toml", *RECORDINGS)]


def _builtin_scenes(incomplete: str) -> list[str]:
    return _beginning(incomplete, _shipped("stiction.scene"))


def _toml_files(incomplete: str) -> list[str]:
    return _files(incomplete, ".toml")


def _sweeps(incomplete: str) -> list[str]:
    return [*_beginning(incomplete, _shipped("stiction.sweep")), *_files(incomplete, ".toml")]


def _recordings(incomplete: str) -> list[str]:
    return _files(incomplete, *RECORDINGS)


def _tables(incomplete: str) -> list[str]:
    return _files(incomplete, ".csv")


def _materials(incomplete: str) -> list[str]:
    from stiction.materials import MaterialTable

    return _beginning(incomplete, MaterialTable.default().materials)


def _cases(incomplete: str) -> list[str]:
    from stiction.verify import all_cases

    return _beginning(incomplete, [case.name for case in all_cases()])


def _figures(incomplete: str) -> list[str]:
    # read, not imported: the kinds bring in what recordings are made of, and with it pydantic
    source = resources.files("stiction").joinpath("plot", "kinds.py").read_text(encoding="utf-8")
    return _beginning(incomplete, re.findall(r'\bKind\(\s*"([a-z]+)"', source))


def _benches(incomplete: str) -> list[str]:
    from stiction.bench import SCENES

    return _beginning(incomplete, SCENES)


def _solvers(incomplete: str) -> list[str]:
    from stiction.world import SOLVERS

    return _beginning(incomplete, SOLVERS)


def _engines(incomplete: str) -> list[str]:
    from stiction.bench.engines import PEERS

    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in _beginning(last, [*PEERS, *([] if comma else ["all", "none"])])]


def _words(*words: str) -> Completer:
    return lambda incomplete: _beginning(incomplete, words)


COMPLETERS: dict[str, Completer] = {
    "scene": _scenes,
    "view.scene": _shown,
    "scenes.name": _builtin_scenes,
    "new.from_": _builtin_scenes,
    "new.file": _toml_files,
    "check.files": _scenes,
    "sweep.spec": _sweeps,
    "file": _recordings,
    "recording": _recordings,
    "data": _tables,
    "materials.a": _materials,
    "materials.b": _materials,
    "table_name": _words("default", "lecture"),
    "cases": _cases,
    "run.plot": _figures,
    "figures": _figures,
    "bench.names": _benches,
    "solver": _solvers,
    "bench.against": _engines,
    "backend": _words("local", "ray", "inline"),
    "loss": _words("linear", "soft_l1", "huber", "cauchy"),
}
"""By the name of a parameter, or by those of command and parameter."""


def _beginning(incomplete: str, words: Iterable[str]) -> list[str]:
    return [word for word in words if word.startswith(incomplete)]


def _shipped(package: str) -> list[str]:
    """Names of the TOML files in a package's folder ``builtin``; found without loading the package."""
    folder = resources.files("stiction").joinpath(package.removeprefix("stiction."), "builtin")
    return sorted(file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml"))


def _files(incomplete: str, *endings: str) -> list[str]:
    """Files with one of these endings, and the folders on the way to more."""
    head, slash, tail = incomplete.rpartition("/")
    folder = Path(head + slash or ".")
    try:
        found = sorted(entry for entry in folder.iterdir() if entry.name.startswith(tail))
    except OSError:
        return []
    return [
        f"{head}{slash}{entry.name}{'/' if entry.is_dir() else ''}"
        for entry in found
        if (entry.is_dir() and not entry.name.startswith(".")) or entry.suffix in endings
    ]
