"""Checks that need every floor: what is wrong is told before a stage is run."""
