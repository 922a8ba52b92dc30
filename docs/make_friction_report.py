"""Write friction-report.md from a run of all engines: ``python docs/make_friction_report.py`` (about two minutes).

Engines that are not installed are named in the page and left out; ``pip install stiction[peers]`` has most of them.
"""

from __future__ import annotations

import sys
from pathlib import Path

from stiction.verify.against import PEERS, compare
from stiction.verify.against.plot import save
from stiction.verify.against.report import markdown

PAGE = Path(__file__).with_name("friction-report.md")
PICTURE = Path(__file__).with_name("_static") / "friction-report.png"


def main() -> None:
    """Ask, write, draw."""
    found = compare(PEERS, progress=lambda what: print(what, file=sys.stderr))
    PAGE.write_text(markdown(found, picture=f"{PICTURE.parent.name}/{PICTURE.name}"), encoding="utf-8")
    save(found, PICTURE)


if __name__ == "__main__":
    main()
