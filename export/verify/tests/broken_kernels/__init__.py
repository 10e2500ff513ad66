"""Faulty kernels, to test that worker processes survive them."""
