"""Ends its process as a null pointer does."""

import os
import signal


def rebuild(tree, samples, folder):
    os.kill(os.getpid(), signal.SIGSEGV)
