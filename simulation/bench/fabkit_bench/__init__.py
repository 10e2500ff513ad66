"""Simulated experiments of papers, compared with their published figures.

Every figure is simulated: layers at small strain, images with the constants that
:attr:`Report.constants` names. Each is reported with the paper's figure, the score of a trivial
guess, and a note on the differences. Nothing is tuned to a published figure; disagreements are
reported as they are.

Trained networks are kept as ONNX: :attr:`Report.networks`. Training requires scikit-learn:
``pip install fabkit-cad[bench]``.

>>> import fabkit_bench
>>> report = fabkit_bench.run("shadowtac", rows=["linear"])
>>> [row.paper for row in report.rows]
[0.997, 0.0014, 0.988, 0.0185]
>>> report.document()["is_simulated"]
True
"""

from fabkit_bench._networks import Network
from fabkit_bench._report import Report, Row
from fabkit_bench._run import experiments, figures, run

__all__ = ["Network", "Report", "Row", "experiments", "figures", "run"]


def __dir__() -> list[str]:
    return __all__
