"""One run in a fresh process: a task goes in as JSON, an outcome comes out as JSON.

``python -m stiction.bench.worker`` reads the task from standard input. Some engines print on standard output when they
are imported, from C, so that output is turned to standard error before anything else happens, and the answer is
written to the output that was there before.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import warnings
from dataclasses import asdict

from stiction.bench.single import Outcome, Task, run_here

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS")
"""Environment variables that keep libraries to one thread."""

GRACE = 300.0
"""s beyond the time limit of a task for importing, compiling, building and a step that has begun."""


def run_apart(task: Task) -> Outcome:
    """One run in a process of its own; a crash or a hang becomes an outcome that says so."""
    command = [sys.executable, "-m", "stiction.bench.worker"]
    environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
    pipe = subprocess.PIPE
    # a session of its own: Ctrl-C reaches this process first, which then ends the run
    with subprocess.Popen(
        command, stdin=pipe, stdout=pipe, stderr=pipe, text=True, env=environment, start_new_session=True
    ) as process:
        try:
            answer, errors = process.communicate(json.dumps(asdict(task)), timeout=2.0 * task.limit + GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            return Outcome(failed=f"no answer within {2.0 * task.limit + GRACE:.0f} s")
        except BaseException:
            process.kill()
            raise
    if process.returncode == 0:
        return Outcome.from_dict(json.loads(answer))
    return Outcome(failed=_reason(process.returncode, errors))


def _reason(status: int, errors: str) -> str:
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    last = lines[-1] if lines else "no message"
    if status < 0:
        return f"killed by {signal.Signals(-status).name}: {last}"
    return last


def main() -> None:
    """Read a task, run it, write the outcome."""
    answer = os.dup(1)
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    task = Task(**json.load(sys.stdin))
    outcome = run_here(task)
    with os.fdopen(answer, "w") as stream:
        json.dump(outcome.as_dict(), stream)  # NaN and Infinity go through: both ends are Python
    # engines tear down their worlds in no particular order at exit, and some crash on it
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
