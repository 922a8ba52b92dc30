"""One engine in a process of its own: trials go in as JSON, each score comes out as a line of JSON.

``python -m stiction.verify.against.worker`` reads what to do from standard input. Engines print on standard output as
they like, so that is turned to standard error before anything else. A process that dies takes one trial with it; the
next one goes on with the rest.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict

from stiction.bench.worker import THREADS
from stiction.verify.against.comparison import Progress, ask, trials_named
from stiction.verify.against.trial import Score


def ask_apart(
    name: str, trials: list[str], dt: float, solver: str | None = None, progress: Progress | None = None
) -> Iterator[Score]:
    """One engine in all trials; where its process dies, the trial it was at has failed."""
    left = list(trials)
    while left:
        task = {"engine": name, "trials": left, "dt": dt, "solver": solver}
        environment = {**os.environ, **dict.fromkeys(THREADS, "1")}
        command = [sys.executable, "-m", "stiction.verify.against.worker"]
        pipe = subprocess.PIPE
        # a session of its own: Ctrl-C reaches this process first, which then ends the other
        with subprocess.Popen(
            command,
            stdin=pipe,
            stdout=pipe,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
            start_new_session=True,
        ) as process:
            try:
                assert process.stdin is not None
                assert process.stdout is not None
                process.stdin.write(json.dumps(task))
                process.stdin.close()
                for line in process.stdout:
                    score = Score(**json.loads(line))
                    left.remove(score.trial)
                    if progress is not None:
                        progress(f"  {score.trial}")
                    yield score
            except BaseException:
                process.kill()
                raise
        if left:
            yield Score(left.pop(0), name, failed=f"its process ended with status {process.returncode}")


def main() -> None:
    """Read what to do, do it, write scores."""
    answer = os.dup(1)
    os.dup2(2, 1)
    task = json.load(sys.stdin)
    with os.fdopen(answer, "w") as stream:
        for trial in trials_named(task["trials"]):
            score = ask(task["engine"], trial, task["dt"], task["solver"])
            stream.write(json.dumps(asdict(score)) + "\n")  # NaN goes through: both ends are Python
            stream.flush()
    # engines tear down their worlds in no particular order at exit, and some crash on it
    sys.stderr.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
