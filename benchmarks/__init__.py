"""Measured ratios against what one would run otherwise; `./run bench` prints them."""

import os

os.environ.setdefault("MUJOCO_GL", "egl")  # before MuJoCo is imported: it has no screen here
