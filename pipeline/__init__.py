"""Belvedere: which fixed camera viewpoint serves the teleoperation of a robot arm best."""
