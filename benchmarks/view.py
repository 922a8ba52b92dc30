"""What the live view sends: ``python benchmarks/view.py [--bodies N] [--docs]``, the table of docs/view.md.

A world of moving bodies is shown by the real server to a client that reads all it gets, in a process of its own. Frames
are counted where they arrive: messages that set positions of bodies. In every second row another client is there that
reads nothing: frames, simulated time and the memory of the server should stay as they are without it. Processor time is
told apart: of steps, of what the view does for a frame in its own thread, and of packing and sending it in viser's.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from docs_table import write_between

import stiction as st
from stiction.view.server import Viewer
from stiction.view.session import LiveSession

SCENES = ("flying", "rolling", "heap")
DT = 1.0 / 60.0


def world_of(name: str, count: int) -> st.World:
    """Bodies that all move: in the air, rolling on a floor, or in a heap of spheres that is poured."""
    world = st.World(dt=DT, sleeping=False, gravity=(0, 0, 0) if name == "flying" else (0, 0, -9.81))
    world.materials.set_pair("wood", "concrete", static=0.5, dynamic=0.3)
    world.add(st.Plane(), static=True, material="concrete")
    side = int(np.ceil(count ** (1 / 3))) if name == "heap" else int(np.ceil(np.sqrt(count)))
    rng = np.random.default_rng(1)
    for k in range(count):
        x, y, z = k % side, (k // side) % side, k // side**2
        place = np.array([1.05 * x, 1.05 * y, 0.5 + 1.05 * z]) if name == "heap" else np.array([2.0 * x, 2.0 * y, 0.5])
        place[:2] += rng.uniform(-0.02, 0.02, 2)
        angle = rng.uniform(0, 2 * np.pi)
        velocity = np.array([np.cos(angle), np.sin(angle), 0.0]) * (0.5 if name != "heap" else 0.1)
        if name == "flying":
            velocity[2] = 1.0
        world.add(st.Sphere(0.5), material="wood", mass=1.0, position=place, velocity=velocity)
    return world


def read(port: int, seconds: float, reads: bool) -> None:
    """A client, in a process of its own: prints how many frames came."""
    import msgspec
    import viser
    from viser._messages import ViewerCameraMessage
    from websockets.sync.client import connect

    frames = 0
    client = connect(
        f"ws://127.0.0.1:{port}", subprotocols=[f"viser-v{viser.__version__}"], max_size=None, ping_interval=None,
        max_queue=1,
    )  # fmt: skip
    camera = ViewerCameraMessage((1, 0, 0, 0), (5, 5, 5), 0.8, 0.01, 100.0, 480, 640, (0, 0, 0), (0, 0, 1))
    client.send(msgspec.msgpack.encode(camera.as_serializable_dict()))
    time.sleep(0.0 if reads else seconds)
    # what puts up the scene is not counted
    while reads and not _holds_positions(client.recv(timeout=seconds)):
        pass
    end = time.perf_counter() + seconds
    while reads and (left := end - time.perf_counter()) > 0:
        with contextlib.suppress(TimeoutError):
            frames += _holds_positions(client.recv(timeout=left))
    client.close_socket()
    print(frames)


def _holds_positions(message: bytes) -> bool:
    """Whether a message of viser's sets positions of bodies: two lengths of 8 bytes, then MessagePack in zstandard."""
    import zstandard

    packed = message[16 : 16 + int.from_bytes(message[8:16], "little")]
    return b"batched_positions" in zstandard.decompress(packed)


def start(port: int, seconds: float, *, reads: bool) -> subprocess.Popen[str]:
    """Such a client."""
    more = [str(port), str(seconds), str(int(reads))]
    return subprocess.Popen([sys.executable, __file__, "--client", *more], stdout=subprocess.PIPE, text=True)


def memory() -> float:
    """Resident memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def measure(name: str, count: int, seconds: float, stuck: bool) -> str:
    """A row of the table."""
    world = world_of(name, count)
    world.step(60)
    stepping = 0.0

    def advance(steps: int) -> None:
        nonlocal stepping
        began = time.thread_time()
        world.step(steps)
        stepping += time.thread_time() - began

    session = LiveSession(world, advance=advance)
    session.playing = True
    with Viewer(session, port=0) as viewer:
        clients = [start(viewer.port, seconds + 2.0, reads=True)]
        clients += [start(viewer.port, seconds + 5.0, reads=False)] if stuck else []
        while viewer.clients < 1 + stuck:
            time.sleep(0.01)
        time.sleep(1.0)
        clock = time.pthread_getcpuclockid(viewer._thread.ident or 0)
        sent, steps, held = viewer.sent, session.world.steps, memory()
        began, cpu, own, stepped = time.perf_counter(), time.process_time(), time.clock_gettime(clock), stepping
        time.sleep(seconds)
        wall, spent = time.perf_counter() - began, time.process_time() - cpu
        own, stepped = time.clock_gettime(clock) - own, stepping - stepped
        sent, steps, grown = viewer.sent - sent, session.world.steps - steps, memory() - held
        got = int(clients[0].communicate()[0])
        for client in clients:
            client.kill()
            client.wait()
    return (
        f"| {name} | {count:,} | {'yes' if stuck else 'no'} | {sent / wall:.1f} | {got / (seconds + 2):.1f} | "
        f"{steps * DT / wall:.2f} | {1e3 * stepped / max(1, steps):.1f} | {1e3 * (own - stepped) / max(1, sent):.1f} | "
        f"{1e3 * (spent - own) / max(1, sent):.1f} | {grown:+.1f} |"
    )


def main() -> None:
    """Print the table as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bodies", type=int, default=5000)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--docs", action="store_true", help="write the table into docs/view.md")
    parser.add_argument("--client", nargs=3, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.client:
        port, seconds, reads = given.client
        read(int(port), float(seconds), reads == "1")
        return
    columns = (
        "bodies", "count", "another does not read", "sent/s", "read/s", "simulated s/s", "ms a step",
        "view, ms a frame", "sending, ms a frame", "MB more",
    )  # fmt: skip
    lines = [f"| {' | '.join(columns)} |", f"|{' --- |' * len(columns)}"]
    print(*lines, sep="\n")
    for name in given.scenes.split(","):
        for stuck in (False, True):
            lines.append(measure(name, given.bodies, given.seconds, stuck))
            print(lines[-1], flush=True)
    lines += ["", f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}."]
    print(*lines[-2:], sep="\n")
    if given.docs:
        write_between("view.md", "sending", "\n".join(lines))


if __name__ == "__main__":
    main()
