"""``stiction info``: what runs here."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction import __version__
from stiction.cli.console import out, print_json, table

if TYPE_CHECKING:
    from stiction.cli.kernels import Kernel

PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "h5py", "matplotlib", "viser", "pydantic", "typer", "rich")
"""What is installed with stiction."""
EXTRAS = {
    "sweep": (("pyarrow",), "tables of sweeps as Parquet files"),
    "ray": (("ray", "pyarrow"), "sweeps on a cluster"),
    "data": (("pyarrow", "xarray", "h5netcdf"), "recordings as tables and arrays with names"),
    "fit": (("optuna",), "fits of noisy motion"),
    "peers": (("mujoco", "rapier3d", "robox3d", "pybullet"), "other engines, to compare with"),
}
"""Packages of each extra that a part of stiction asks for, and what they are for."""


def info(json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False) -> None:
    """Tell what runs here: versions, CPU, the cache folder and what is compiled in it, extras. Nothing is compiled.

    \b
    Examples:
      stiction info
      stiction info --json    # for a bug report
    """
    facts = _facts()
    if json:
        print_json(facts)
        return
    _print(facts)


def _version(package: str) -> str | None:
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _facts() -> dict[str, Any]:
    import llvmlite.binding as llvm

    from stiction.bench.report import machine
    from stiction.cli.kernels import compiled, folder_size
    from stiction.core import jit
    from stiction.scene import builtin_names

    here = machine()
    folder = jit.kernel_folder()
    kernels: list[Kernel] = compiled(folder) if folder is not None else []
    return {
        "stiction": __version__,
        "python": here["python"],
        "system": here["system"],
        "packages": {name: _version(name) for name in PACKAGES},
        "extras": {
            extra: {"packages": {name: _version(name) for name in names}, "for": purpose}
            for extra, (names, purpose) in EXTRAS.items()
        },
        "cpu": {
            "name": here["cpu"],
            "llvm_name": llvm.get_host_cpu_name(),
            "cores": here["cores"],
            "cores_of_this_process": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None,
            "simd_bits": _simd_bits(dict(llvm.get_host_cpu_features())),
        },
        "compiler": "off (NUMBA_DISABLE_JIT)" if jit.config.DISABLE_JIT else "on",
        "cache": {
            "folder": None if folder is None else str(folder),
            "bytes": None if folder is None else folder_size(folder),
            "all_bytes": None if folder is None else folder_size(folder.parent),
            "kernels": [kernel._asdict() for kernel in kernels],
        },
        "package_folder": str(Path(sys.modules["stiction"].__file__ or "").parent),
        "builtin_scenes": builtin_names(),
    }


def _simd_bits(features: dict[str, bool]) -> int:
    """Width of the registers that the solver's eight lanes are laid in."""
    if platform.machine().lower() in {"arm64", "aarch64"}:
        return 128
    return 256 if features.get("avx") else 128


def _print(facts: dict[str, Any]) -> None:
    cpu, cache = facts["cpu"], facts["cache"]
    made = table(f"stiction {facts['stiction']}", ["", ""])
    made.show_header = False
    made.add_row("[bold]Python[/]", f"{facts['python']}, {facts['system']}")
    made.add_row(
        "[bold]packages[/]", ", ".join(f"{name} {version or '–'}" for name, version in facts["packages"].items())
    )
    own = cpu["cores_of_this_process"]
    cores = f"{cpu['cores']} cores" + (f", {own} of them for this process" if own not in (None, cpu["cores"]) else "")
    made.add_row("[bold]CPU[/]", f"{cpu['name']} ({cpu['llvm_name']}), {cores}")
    steps = 256 // cpu["simd_bits"]
    made.add_row(
        "[bold]SIMD[/]",
        f"{cpu['simd_bits']} bits: the eight float32 lanes of the solver lie in {steps} register{'s' * (steps > 1)}",
    )
    made.add_row("[bold]threads[/]", f"1 a world unless World(threads=N) asks for more; compiler {facts['compiler']}")
    scenes = f"a name is one of {len(facts['builtin_scenes'])} built in; what ends in .toml or has a slash is a path"
    made.add_row("[bold]scenes[/]", scenes)
    made.add_row("[bold]installed in[/]", facts["package_folder"])
    if cache["folder"] is None:
        made.add_row("[bold]cache[/]", "none can be written: every process compiles anew")
    else:
        others = f"; with those of other versions {cache['all_bytes'] / 1e6:.1f} MB"
        made.add_row("[bold]cache[/]", f"{cache['folder']}: {cache['bytes'] / 1e6:.1f} MB{others}")
    out.print(made)
    _print_kernels(cache["kernels"])
    _print_extras(facts["extras"])


def _print_kernels(kernels: list[dict[str, Any]]) -> None:
    if not kernels:
        out.print("No kernels are compiled yet: the first run does that, or [bold]stiction warmup[/].\n")
        return
    numbers = ("variants", "MB", "compiled in")
    made = table("Compiled kernels", ["kernel", *numbers, "switches of each variant"], right=numbers)
    for one in kernels:
        seconds = "" if one["seconds"] is None else f"{one['seconds']:.1f} s"
        switches = "; ".join(" ".join(on) or "none" for on in one["variants"]) if any(one["variants"]) else ""
        made.add_row(one["name"], str(len(one["variants"])), f"{one['size'] / 1e6:.1f}", seconds, switches)
    out.print(made)


def _print_extras(extras: dict[str, Any]) -> None:
    made = table("Extras", ["extra", "what for", "packages", ""])
    for name, extra in extras.items():
        missing = [package for package, version in extra["packages"].items() if version is None]
        listed = ", ".join(
            f"{package} {version}" if version else f"[dim]{package}[/]"
            for package, version in extra["packages"].items()
        )
        done = "[green]installed[/]" if not missing else f'[yellow]pip install "stiction\\[{name}]"[/]'
        made.add_row(f"[bold]{name}[/]", extra["for"], listed, done)
    out.print(made)
