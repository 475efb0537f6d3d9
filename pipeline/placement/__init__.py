"""Where candidates of a search stand on the sphere about a scene, and which geometry rules out."""
