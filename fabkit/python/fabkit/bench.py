"""The former name of the package ``fabkit_bench``, kept for one version."""

import sys
import warnings

try:
    import fabkit_bench
    from fabkit_bench import Network, Report, Row, experiments, families, figures, run
except ModuleNotFoundError as error:
    if error.name != "fabkit_bench":
        raise
    raise ImportError(
        "fabkit.bench is the package fabkit_bench, which is not installed; "
        "pip install 'fabkit-cad[bench]'",
        name="fabkit_bench",
    ) from error

__all__ = ["Network", "Report", "Row", "experiments", "figures", "run"]

if __name__ == "__main__":
    from fabkit_bench.__main__ import main

    sys.exit(main())

warnings.warn("fabkit.bench is called fabkit_bench now", DeprecationWarning, stacklevel=2)
# Old imports such as `fabkit.bench._run` still work; the families used to be in the same folder.
fabkit_bench.__path__.extend(families.__path__)
sys.modules[__name__] = fabkit_bench
