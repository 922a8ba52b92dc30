"""Ctrl-C waits while a file is written, and is never lost."""

from __future__ import annotations

import os
import signal
import threading
import weakref
from pathlib import Path

import pytest

from stiction.record import writer as writer_module
from stiction.record.hdf5 import RecordingWriter, load_frames
from stiction.record.interrupts import interrupts_held
from stiction.record.run import run
from stiction.scene import Simulation, load


def press_ctrl_c() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupt_is_raised_at_the_end_of_the_block() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        press_ctrl_c()
        done.append("the rest of the block")
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_without_an_interrupt_nothing_happens_and_blocks_can_be_nested() -> None:
    with interrupts_held(), interrupts_held():
        pass
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        with interrupts_held():
            press_ctrl_c()
        outer = True
    assert outer, "the inner block hands it to the outer one"


def test_an_error_in_the_block_does_not_leave_the_interrupt_behind() -> None:
    with pytest.raises(KeyboardInterrupt) as caught, interrupts_held():
        press_ctrl_c()
        raise ValueError
    assert isinstance(caught.value.__context__, ValueError)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_program_that_ignores_ctrl_c_still_does() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_held():
            press_ctrl_c()
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_thread_can_write_as_well() -> None:
    entered: list[bool] = []

    def work() -> None:
        with interrupts_held():
            entered.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert entered == [True]


def test_ctrl_c_in_a_callback_that_swallows_exceptions_ends_the_run_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What h5py does by chance is done here by intention: the signal arrives in the callback of a weak reference."""

    class Handle:
        pass

    simulation = Simulation(load("push-and-release"))
    calls = [0]
    with pytest.raises(KeyboardInterrupt), RecordingWriter(tmp_path / "run.h5", simulation, 2) as writer:
        hand_over = writer._hand_over

        def freeing_a_handle() -> None:
            calls[0] += 1
            if calls[0] == 3:
                handle = Handle()
                watched = weakref.ref(handle, lambda reference: press_ctrl_c())
                del handle
                assert watched() is None
            hand_over()

        monkeypatch.setattr(writer_module, "BATCH_STEPS", 10)
        monkeypatch.setattr(writer, "_hand_over", freeing_a_handle)
        run(simulation, writer=writer)
    assert not simulation.done
    frames = load_frames(tmp_path / "run.h5")
    assert frames.meta["outcome"] == "interrupted"
    assert len(frames) == simulation.step_index // 2 + 1
