"""Each paper's experiment, simulated, and its figures beside those that are published.

Every figure is simulated: layers at small strain, pictures with the constants that
:attr:`Report.constants` names. Beside it stand what the paper says and what a trivial guess would
score; its note says what differs. Nothing is tuned to a published figure: where one disagrees, that
is what was found.

What was trained on the way is kept as ONNX: :attr:`Report.networks`.

What learns needs scikit-learn: ``pip install fabkit-cad[bench]``.

>>> import fabkit_bench
>>> report = fabkit_bench.run("rtac0", rows=["slip"])
>>> [row.paper for row in report.rows]
[3.1, 3.8, 5.1, 8.2]
>>> report.document()["is_simulated"]
True
"""

from fabkit_bench._networks import Network
from fabkit_bench._report import Report, Row
from fabkit_bench._run import experiments, figures, run

__all__ = ["Network", "Report", "Row", "experiments", "figures", "run"]


def __dir__() -> list[str]:
    return __all__
