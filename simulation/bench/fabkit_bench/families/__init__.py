"""The experiments of each family, in a module that is called after it: ``pin-tip`` is ``pin_tip``."""
