"""A kernel that raises an unexpected exception."""


def rebuild(tree, samples, folder):
    raise ZeroDivisionError("on purpose")
