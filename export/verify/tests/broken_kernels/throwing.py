"""Throws what nobody expects."""


def rebuild(tree, samples, folder):
    raise ZeroDivisionError("on purpose")
