"""What `./run` does: the study from beginning to end by DVC, or its branches side by side.

It works in the root of the repository, where `./run` starts it.
"""
