"""Numerics of the kernels: compilation, small vectors, matrices, SIMD lanes, rotations."""
