"""Kernels with the faults that a process must survive."""
