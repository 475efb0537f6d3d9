"""Floor 1: the simulation. Scenes, cameras, the task, batches of worlds, ray-traced pictures."""
