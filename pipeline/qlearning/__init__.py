"""The other judge: a deep Q-network on one picture (paper section III), by stable-baselines3."""
