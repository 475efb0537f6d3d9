"""Floor 3: linear controllers, their evolution, the closed loop with the simulator, anchors."""
