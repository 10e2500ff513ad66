"""One module per kernel. Each has `NAME` and `rebuild(tree, samples, folder) -> Rebuilt`."""
