"""What a task is: a world to copy, what is seen of it, what an action does, and what is rewarded."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from stiction.batch import Batch
from stiction.errors import InvalidInputError
from stiction.world import World

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Chosen = NDArray[np.int64]


class Draw(Protocol):
    """Uniform draws for the worlds that begin anew, each from its own stream: (worlds, ...) of the shape of low."""

    def __call__(self, low: float | Array, high: float | Array) -> Array: ...


class Verdict(NamedTuple):
    """How a step ended, (worlds,) each: reward, whether the episode is over, and whether the aim was reached."""

    reward: Array
    terminated: Mask
    success: Mask


class View(NamedTuple):
    """The part of the world that a picture shows.

    Attributes:
        axes: which coordinates go right and up: (0, 1) from above, (0, 2) from the side.
        x, y: from, to, in m.
        width: of the picture in pixels; its height follows.
    """

    axes: tuple[int, int]
    x: tuple[float, float]
    y: tuple[float, float]
    width: int = 600


class Mark(NamedTuple):
    """Something to see that is no body: a circle, or a rectangle if ``size`` is given.

    Attributes:
        center: right and up, in m.
        radius: m.
        color: of matplotlib.
        size: width and height in m.
    """

    center: tuple[float, float]
    radius: float
    color: str
    size: tuple[float, float] | None = None


class Task(ABC):
    """A task on many copies of a world at once. One object serves one batch, and may keep arrays with a row a world.

    All that it does to a world must depend on this world alone, by elementwise operations, so that a world goes the
    same way, to the last bit, whatever the others do and however many they are.
    """

    name: ClassVar[str]
    episode: ClassVar[int]
    """Steps of an episode, after which it is truncated."""
    drives: ClassVar[int] = 1
    """How often :meth:`drive` is called in a step of the environment."""
    hold: ClassVar[int] = 1
    """Steps of the world after each of them."""
    actions: ClassVar[int]
    """Numbers of an action, each from -1 to 1."""
    limits: ClassVar[tuple[float, ...]]
    """Largest magnitude of each number of an observation; what is beyond is clipped."""
    view: ClassVar[View]

    @abstractmethod
    def build(self) -> World:
        """The world to copy."""

    @abstractmethod
    def start(self, batch: Batch) -> None:
        """Make room for what is remembered of each world."""

    @abstractmethod
    def begin(self, batch: Batch, chosen: Chosen, draw: Draw) -> None:
        """Vary how the chosen worlds begin; they have been reset."""

    @abstractmethod
    def drive(self, batch: Batch, actions: Array) -> None:
        """Let the actions (worlds, k) act."""

    @abstractmethod
    def observe(self, batch: Batch) -> Array:
        """(worlds, m) what is seen."""

    @abstractmethod
    def judge(self, batch: Batch, actions: Array) -> Verdict:
        """How the step went; called once after each step."""

    def marks(self, world: int) -> list[Mark]:
        """What to draw under the bodies of this world."""
        return []


def task_of(task: Task | str) -> Task:
    """A task by its name, or as it is.

    Raises:
        InvalidInputError: there is none of that name.
    """
    if isinstance(task, Task):
        return task
    from stiction import checks, envs
    from stiction.envs.registration import TASKS

    if not isinstance(task, str):
        raise InvalidInputError(f"task must be a Task or one of {', '.join(TASKS)}, got {task!r}.")
    made = getattr(envs, checks.one_of("task", task, TASKS))()
    assert isinstance(made, Task)
    return made
