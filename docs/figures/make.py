"""Draw every figure of the documentation anew: ``python docs/figures/make.py``, into ``docs/_static``."""

from __future__ import annotations

import badges
import braking_on_ice
import clipping
import concepts
import push_and_release
import stopping
import threshold


def main() -> None:
    """Draw all of them and print the numbers that the pages quote."""
    for figure in (stopping, clipping, push_and_release, threshold, braking_on_ice, concepts, badges):
        print(f"--- {figure.__name__}")
        figure.draw()


if __name__ == "__main__":
    main()
