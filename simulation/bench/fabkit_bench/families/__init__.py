"""The experiments of each family, in a module called after it: ``pin-tip`` is ``pin_tip``."""
