"""A worker process: ``python -m stiction.sweep.worker``, with lines of JSON from standard input to standard output.

The first line says what the sweep is, each further one is a batch and gets a line in return. It ends with its input, so
also soon after a driver that was killed.
"""

from __future__ import annotations

import json
import os
import signal
import sys

from stiction.sweep.runner import run_batch


def main() -> None:
    """Work until nobody asks any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # an exception: the run is noted as left
    # whatever else prints goes to standard error, so that answers stay alone
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    work = json.loads(sys.stdin.readline())
    for line in sys.stdin:
        answer = run_batch(work["job"], json.loads(line), work["folder"], work["session"])
        answers.write(json.dumps(answer) + "\n")
        try:
            answers.flush()
        except BrokenPipeError:
            os._exit(0)  # the driver is dead; the rows are in the journal


if __name__ == "__main__":
    main()
