"""The boundary value problem of the rod: equations, march along the rod, shooting, time step. Kernels only."""
