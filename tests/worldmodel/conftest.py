"""Small networks here, too."""

from tests.learning.conftest import one_thread_each

__all__ = ["one_thread_each"]
