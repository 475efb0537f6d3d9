"""Pictures: the ray tracer, and what a camera can see."""
