"""``stiction warmup``: compile all kernels ahead of the first run."""

from __future__ import annotations

import time

from stiction.cli.console import out, say


def warmup() -> None:
    """Compile the kernels for this machine, or load them if that was done before, and say how long it took.

    \b
    Examples:
      stiction warmup
      stiction warmup --quiet    # in the recipe of a container
    """
    from stiction import Box, Plane, World
    from stiction.cli.kernels import noting_times
    from stiction.core import jit
    from stiction.core.parts import Variant
    from stiction.core.soft_kernels import prepare_steps

    say("compiling kernels, about half a minute …" if jit.is_cold() else "kernels lie in the cache; loading them …")
    began = time.perf_counter()
    with noting_times():
        # of a body alone and of boxes that meet, all at once: the first step would compile no more than it needs
        prepare_steps(Variant(False, False), Variant(False, False, ("boxes_meet",)))
        world = World()
        world.add(Plane(), static=True)
        world.add(Box((1, 1, 1)), position=(0, 0, 0.5))
        world.step()
        world.add(Box((1, 1, 1)), position=(0, 0, 1.5))
        world.step()
    out.print(f"kernels ready in {time.perf_counter() - began:.1f} s, kept in {jit.kernel_folder()}")
