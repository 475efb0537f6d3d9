"""Small networks: one thread, so that a busy machine does not make threads wait for each other."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from pipeline.learning.device import one_thread


@pytest.fixture(autouse=True)
def one_thread_each() -> Iterator[None]:
    with one_thread():
        yield
