"""What every test can use: Hypothesis settings, and random numbers that a failure can be repeated with."""

from __future__ import annotations

import os
import secrets
from collections.abc import Generator

import numpy as np
import pytest
from hypothesis import settings

# No deadline: the first example of a property may compile kernels. The blob repeats a failure on another machine.
settings.register_profile("ci", derandomize=False, print_blob=True, deadline=None, max_examples=50)
settings.load_profile("ci")

SEED_VARIABLE = "STICTION_TEST_SEED"
_seed_key = pytest.StashKey[int]()


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """A generator with a fresh seed; a failing test prints it, and STICTION_TEST_SEED sets it."""
    given = os.environ.get(SEED_VARIABLE)
    seed = int(given) if given else secrets.randbits(32)
    request.node.stash[_seed_key] = seed
    return np.random.default_rng(seed)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Put the seed of ``rng`` into the report of a failed test, which also travels from a worker process."""
    report = yield
    if report.failed and _seed_key in item.stash:
        seed = item.stash[_seed_key]
        report.sections.append(("random numbers", f'repeat with: {SEED_VARIABLE}={seed} pytest "{item.nodeid}"'))
    return report
