"""Floor 1: how networks are trained: device, seeding, the one loop, checkpoints, finished repeats."""
