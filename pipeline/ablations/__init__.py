"""The judge with parts of it taken away: what z, h and the simulator each do for its controllers."""
