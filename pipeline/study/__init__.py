"""A study with people, or with the scripted operator: what its folder holds, and how it is read."""
