"""The scenes and views of the simulator's tests."""

from tests.sim.conftest import scene, view

__all__ = ["scene", "view"]
