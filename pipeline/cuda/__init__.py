"""What runs on a CUDA device: worlds, arm controllers and inverse kinematics as Warp kernels."""
