"""Ends its process without a word."""

import os


def rebuild(tree, samples, folder):
    os._exit(3)
