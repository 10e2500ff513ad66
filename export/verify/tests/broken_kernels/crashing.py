"""A kernel that crashes its process with a segmentation fault."""

import os
import signal


def rebuild(tree, samples, folder):
    os.kill(os.getpid(), signal.SIGSEGV)
