"""A kernel that exits its process silently."""

import os


def rebuild(tree, samples, folder):
    os._exit(3)
