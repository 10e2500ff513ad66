"""Calibration: the lens from images of a board, the camera's pose from pins at known positions."""

from __future__ import annotations

import importlib
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fabkit import _arrays, _fabkit
from fabkit._planning import CapturePlan, Effort, Expected, NextCapture, plan
from fabkit.cameras import Camera
from fabkit.designs import Fixture, Sensor, as_sensor
from fabkit.errors import FabkitError, Problem, invalid

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

    Detector = Literal["auto", "opencv", "fabkit"]

__all__ = [
    "Board",
    "CapturePlan",
    "Corners",
    "Effort",
    "Expected",
    "Extrinsics",
    "Intrinsics",
    "NextCapture",
    "Pins",
    "boards",
    "extrinsics",
    "find_corners",
    "find_pins",
    "intrinsics",
    "plan",
]


def __dir__() -> list[str]:
    return __all__


#: Standard deviation of corners from detectors that do not report one, px: what good ones reach.
_USUAL_CORNER_SIGMA_PX = 0.1
#: Standard deviation of a pin that was marked by hand, px; the same as in ``captures.csv``.
_USUAL_PIN_SIGMA_PX = 0.3


class Board:
    """A calibration board, as its file describes it.

    >>> import fabkit
    >>> board = fabkit.calibrate.boards("rtac0")["checkerboard"]
    >>> board.kind, board.corners_mm.shape
    ('checkerboard', (400, 2))
    """

    def __init__(self, text: str) -> None:
        self._text = _fabkit.board(text)
        self.document: dict[str, Any] = json.loads(self._text)
        """Content of the file: ``fabkit-board`` version 1."""

    @staticmethod
    def load(path: str | PathLike[str]) -> Board:
        """Read a board file; ``fabkit export SENSOR/boards`` writes one beside each board."""
        return Board(_read(path))

    def __repr__(self) -> str:
        columns, rows = self.document["squares"]
        return f"<Board {self.name}: {columns} x {rows} squares of {self.document['square_mm']} mm>"

    @property
    def name(self) -> str:
        """Name of the board, for reports and messages."""
        return self.document["name"]

    @property
    def kind(self) -> str:
        """Kind of board: ``checkerboard`` or ``charuco``."""
        return self.document["kind"]

    @property
    def corners_mm(self) -> NDArray[np.float64]:
        """Positions of the corners by id, (n, 2), mm; x to the right and y down as seen."""
        return np.array([corner["in_board_mm"] for corner in self.document["corners"]], dtype=float)


def boards(sensor: Sensor | str) -> dict[str, Board]:
    """Return the boards that come with a sensor, by kind.

    The keys are ``checkerboard`` and ``charuco``, as far as the sensor has them.
    """
    sensor = as_sensor(sensor)
    native = sensor.fixtures["boards"]._native  # pyright: ignore[reportPrivateUsage]
    listed = [Board(text) for text in native.boards()]
    return {board.kind: board for board in listed}


@dataclass(frozen=True)
class Corners:
    """Corners of a board in one image."""

    ids: NDArray[np.uint32]
    """Numbers of the corners that were found, (n,)."""
    pixels: NDArray[np.float64]
    """Column and row, (n, 2), px; the first pixel's centre is (0, 0)."""
    sigma_px: NDArray[np.float64] | float = _USUAL_CORNER_SIGMA_PX
    """Standard deviation in each direction, (n,) or one for all, px."""
    name: str = ""
    """Name of the image in messages."""


@dataclass(frozen=True)
class Pins:
    """Positions of pins in one image."""

    pixels: NDArray[np.float64]
    """Column and row, (n, 2), px; in any order."""
    holes: Sequence[int] | None = None
    """Numbers of the holes that had pins, in any order; ``None`` if they are not known."""
    sigma_px: NDArray[np.float64] | float = _USUAL_PIN_SIGMA_PX
    """Standard deviation in each direction, (n,) or one for all, px."""
    name: str = ""
    """Name of the image in messages."""


def find_corners(
    picture: ArrayLike, board: Board, *, detector: Detector = "auto", name: str = "the image"
) -> Corners:
    """Find a board's corners in an image.

    Parameters
    ----------
    picture
        Image, (rows, columns) or (rows, columns, 3) RGB; unsigned integers, or floating point
        from 0 to 1.
    board
        The board to find.
    detector
        ``opencv``, ``fabkit``, or ``auto``: OpenCV's if cv2 is installed, else fabkit's.
    name
        Name of the image in messages.

    Raises
    ------
    FabkitError
        The image shows no such board (the message says why), or has another shape or dtype.
    """
    grey = _arrays.luminance(picture, name)
    cv2 = _opencv(detector)
    if cv2 is not None:
        return _with_opencv(cv2, grey, board, name)
    ids, (pixels, sigmas) = _fabkit.find_corners(grey, board._text)  # pyright: ignore[reportPrivateUsage]
    return Corners(ids, pixels, sigmas, name)


def find_pins(reference: ArrayLike, picture: ArrayLike, *, brighter: bool = False) -> Pins:
    """Find pins that press on the surface, by comparing an image with the reference image.

    Parameters
    ----------
    reference
        Image without contact, as for :func:`find_corners`.
    picture
        Image with pins, of the same size.
    brighter
        Pins appear brighter than the reference image, not darker.

    Returns
    -------
    The pins, the strongest first; their holes are not known. A ``UserWarning`` says how many
    fainter spots were left out, and their contrast.
    """
    (pixels, sigmas), left_out = _fabkit.find_pins(
        _arrays.luminance(reference, "reference"), _arrays.luminance(picture, "picture"), brighter
    )
    if left_out is not None:
        warnings.warn(left_out, stacklevel=2)
    return Pins(pixels, None, sigmas)


class Intrinsics:
    """Result of a lens calibration."""

    def __init__(self, native: _fabkit.Intrinsics) -> None:
        self._native = native
        self.document: dict[str, Any] = json.loads(native.document())
        """Output of ``fabkit calibrate intrinsics --json``: ``fabkit-intrinsics`` version 1."""
        self.camera = Camera(native.camera())
        """The calibrated lens, with the covariance of its parameters."""

    def __repr__(self) -> str:
        return f"<Intrinsics {self.model}: {self.rms_px:.3f} px rms>"

    @property
    def model(self) -> str:
        """Name of the lens model that fits the images best."""
        return self.document["model"]

    @property
    def rms_px(self) -> float:
        """Root mean square length of all residuals, px."""
        return self.document["reprojection_rms_px"]

    @property
    def focal_px_per_rad(self) -> tuple[float, float]:
        """Columns per radian on the axis, and the standard deviation; comparable between models."""
        return self.document["focal_px_per_rad"], self.document["focal_sigma_px_per_rad"]

    @property
    def rays(self) -> dict[str, dict[str, float] | None]:
        """Uncertainty of rays relative to each other: ``seen``, where corners were, and ``beyond``.

        Each has ``typical_mrad``, ``typical_px``, ``worst_mrad`` and ``worst_px``: standard
        deviations that hold as far as the lens model does. ``beyond`` is ``None`` if corners
        covered the whole image.
        """
        return self.document["rays"]

    @property
    def warnings(self) -> list[str]:
        """Properties of the lens that the images do not determine."""
        return self.document["warnings"]

    def save_report(self, path: str | PathLike[str]) -> None:
        """Write a report as one HTML file that works offline."""
        _write(path, self._native.html())


class Extrinsics:
    """Result of a pose calibration."""

    def __init__(self, native: _fabkit.Extrinsics) -> None:
        self._native = native
        self.document: dict[str, Any] = json.loads(native.document())
        """Output of ``fabkit calibrate extrinsics --json``: ``fabkit-extrinsics`` version 1."""
        self.camera = Camera(native.camera())
        """The camera that belongs to the pose, with its part of :attr:`joint_covariance`.

        The calibration may have added an interface to it.
        """

    def __repr__(self) -> str:
        return f"<Extrinsics: {self.held_out_rms_px:.2f} px rms, held out>"

    @property
    def camera_from_sensor(self) -> NDArray[np.float64]:
        """Pose: sensor frame to camera frame, (4, 4), mm."""
        return np.array(self.document["camera_from_sensor"], dtype=float)

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the pose, (6, 6): rotation about camera axes, rad, then translation, mm."""
        return np.array(self.document["covariance"], dtype=float)

    @property
    def joint_covariance(self) -> NDArray[np.float64]:
        """Covariance of pose and camera together, (p, p), in the order of :attr:`joint_parameters`.

        Zeros where a parameter was fixed and its uncertainty is unknown.
        """
        return np.array(self.document["joint_covariance"]["matrix"], dtype=float)

    @property
    def joint_parameters(self) -> list[str]:
        """Names, with units, of the parameters of the pose and then of the camera."""
        return list(self.document["joint_covariance"]["names"])

    @property
    def held_out_rms_px(self) -> float:
        """Root mean square residual of captures that were left out of the fit, px."""
        return self.document["held_out_rms_px"]

    @property
    def warnings(self) -> list[str]:
        """Properties that the pins do not determine, and observations that do not fit."""
        return self.document["warnings"]

    def save(self, path: str | PathLike[str]) -> None:
        """Write a pose file, and beside it the file of the camera that belongs to it."""
        self._native.write(os.fspath(path))

    def save_report(self, path: str | PathLike[str]) -> None:
        """Write a report as one HTML file that works offline."""
        _write(path, self._native.html())


def intrinsics(
    sensor: Sensor | str,
    board: Board | str | PathLike[str],
    views: Sequence[str | PathLike[str] | ArrayLike | Corners],
    *,
    models: Sequence[str] = (),
    detector: Detector = "auto",
) -> Intrinsics:
    """Calibrate the lens from images of a board.

    Parameters
    ----------
    sensor
        A sensor, or its name. The solver starts from its nominal camera, which also gives the
        image size.
    board
        A board, or the path of its file.
    views
        At least 3 views: PNG files, images as arrays (see :func:`find_corners`), or corners that
        were found already.
    models
        Lens models to choose from. Default: all.
    detector
        See :func:`find_corners`. Images in which it finds no board are left out and listed.

    Raises
    ------
    FabkitError
        Too few images show the board, or images cannot be used; the message lists them all.
    """
    sensor = as_sensor(sensor)
    board = board if isinstance(board, Board) else Board.load(board)
    files: list[str] = []
    pictures: list[tuple[str, NDArray[np.float32]]] = []
    corners: list[tuple[str, list[int], list[list[float]], list[float]]] = []
    cv2 = None if all(isinstance(view, Corners) for view in views) else _opencv(detector)
    for number, view in enumerate(views):
        if isinstance(view, Corners):
            corners.append(_corners(view, view.name or f"view {number}"))
        elif cv2 is not None:
            name, grey = _picture(cv2, view, number)
            found = _with_opencv(cv2, grey, board, name, missing_ok=True)
            corners.append(_corners(found, name))
        elif isinstance(view, str | os.PathLike):
            files.append(os.fspath(view))
        else:
            pictures.append((f"view {number}", _arrays.luminance(view, f"view {number}")))
    if sum(map(bool, (files, pictures, corners))) > 1:
        raise invalid("views mixes several kinds; give only files, only arrays or only corners")
    native = _fabkit.intrinsics(
        sensor._project,  # pyright: ignore[reportPrivateUsage]
        board._text,  # pyright: ignore[reportPrivateUsage]
        files,
        pictures,
        corners,
        list(models),
    )
    return Intrinsics(native)


def extrinsics(
    sensor: Sensor | str,
    camera: Camera | str | PathLike[str],
    captures: str | PathLike[str] | Sequence[Pins],
    *,
    landmarks: Fixture | str | PathLike[str] | Mapping[int, ArrayLike] | None = None,
    reference: str | PathLike[str] | None = None,
    pin: str | None = None,
    gel_index: float = 1.41,
) -> Extrinsics:
    """Solve for the camera's pose from captures of pins that touch the surface at known points.

    Parameters
    ----------
    sensor
        A sensor, or its name. The solver starts from its nominal pose.
    camera
        The calibrated lens, or the path of its file.
    captures
        A folder of images that are named after the holes that had pins, or listed in
        ``captures.csv``; or pins that were found already.
    landmarks
        Points where pins touch: a fixture with pins, a file, or (x, y, z) in the sensor frame, mm,
        by hole. Default: those of the sensor's own ``pin-dome`` or ``pin-plate``.
    reference
        With a folder: the reference image, if it is not called ``ref.png``.
    pin
        Kind of pin, where the fixture has several.
    gel_index
        Refractive index, 1 to 2, of the gel that the solver tries in front of the lens.

    Raises
    ------
    FabkitError
        The pins do not determine the pose, labels do not fit, or a file has errors.
    """
    sensor = as_sensor(sensor)
    camera_file = "camera" if isinstance(camera, Camera) else os.fspath(camera)
    camera = camera if isinstance(camera, Camera) else Camera.load(camera)
    if not 1.0 <= gel_index <= 2.0:
        raise invalid(f"gel_index is {gel_index}; the limits are 1 and 2")
    folder: str | None = None
    pins: list[tuple[str, list[int] | None, list[list[float]], list[float]]] = []
    if isinstance(captures, str | os.PathLike):
        folder = os.fspath(captures)
    else:
        for number, capture in enumerate(captures):
            name = capture.name or f"capture {number}"
            pixels, _ = _arrays.rows(capture.pixels, 2, f"pixels of {name}")
            sigmas = _arrays.vector(capture.sigma_px, len(pixels), f"sigma_px of {name}")
            holes = None if capture.holes is None else [int(hole) for hole in capture.holes]
            pins.append((name, holes, pixels.tolist(), sigmas.tolist()))
    native = _fabkit.extrinsics(
        sensor._project,  # pyright: ignore[reportPrivateUsage]
        camera._native,  # pyright: ignore[reportPrivateUsage]
        camera_file,
        _landmarks(sensor, landmarks),
        folder,
        None if reference is None else os.fspath(reference),
        pins,
        pin,
        gel_index,
    )
    return Extrinsics(native)


def _landmarks(
    sensor: Sensor, given: Fixture | str | PathLike[str] | Mapping[int, ArrayLike] | None
) -> str:
    """Return a list of landmarks as JSON text."""
    if isinstance(given, Mapping):
        points = {str(hole): _arrays.vector(at, 3, f"hole {hole}") for hole, at in given.items()}
        return json.dumps({hole: at.tolist() for hole, at in points.items()})
    if isinstance(given, str | os.PathLike):
        return _read(given)
    own = "pin-plate" if "pin-plate" in sensor.fixtures else "pin-dome"
    dome = sensor.fixtures[own] if given is None else given
    text = dome._native.pin_landmarks()  # pyright: ignore[reportPrivateUsage]
    if text is None:
        raise invalid(f"{dome.name} has no pins, and so no landmarks")
    return text


def _corners(view: Corners, name: str) -> tuple[str, list[int], list[list[float]], list[float]]:
    """Check corners and convert them for the compiled library: name, ids, pixels, sigmas."""
    pixels, _ = _arrays.rows(view.pixels, 2, f"pixels of {name}")
    ids = np.asarray(view.ids)
    if ids.shape != (len(pixels),) or ids.dtype.kind not in "iu" or (ids < 0).any():
        raise invalid(
            f"ids of {name} have the shape {ids.shape} and the dtype {ids.dtype}; "
            f"they must be ({len(pixels)},) whole numbers from 0"
        )
    sigmas = _arrays.vector(view.sigma_px, len(pixels), f"sigma_px of {name}")
    return (name, ids.tolist(), pixels.tolist(), sigmas.tolist())


def _opencv(detector: Detector) -> Any:
    """Import and return cv2, or ``None`` for fabkit's own detector."""
    if detector not in ("auto", "opencv", "fabkit"):
        raise invalid(f"there is no detector `{detector}`", "known: auto, opencv, fabkit")
    if detector == "fabkit":
        return None
    try:
        return importlib.import_module("cv2")
    except ImportError as error:
        if detector == "auto":
            return None
        raise invalid("cv2 is not installed", "pip install opencv-python-headless") from error


def _picture(cv2: Any, view: Any, number: int) -> tuple[str, NDArray[np.float32]]:
    """Return a view's name and its image as luminance from 0 to 1."""
    if not isinstance(view, str | os.PathLike):
        return f"view {number}", _arrays.luminance(view, f"view {number}")
    name = str(os.fspath(view))  # pyright: ignore[reportUnknownArgumentType]
    read = cv2.imread(name, cv2.IMREAD_GRAYSCALE)
    if read is None:
        raise invalid(f"cannot read {name} as an image")
    return name, _arrays.luminance(read, name)


def _with_opencv(
    cv2: Any, grey: NDArray[np.float32], board: Board, name: str, *, missing_ok: bool = False
) -> Corners:
    """Find corners with OpenCV; finding none is an error unless ``missing_ok``."""
    bytes_ = np.rint(255 * np.clip(grey, 0, 1)).astype(np.uint8)
    columns, rows = board.document["squares"]
    ids: Any
    if board.kind == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(
            getattr(cv2.aruco, board.document["dictionary"])
        )
        sizes = (board.document["square_mm"], board.document["marker_mm"])
        detector = cv2.aruco.CharucoDetector(
            cv2.aruco.CharucoBoard((columns, rows), *sizes, dictionary)
        )
        found, ids, _, _ = detector.detectBoard(bytes_)
    else:
        size = (columns - 1, rows - 1)
        seen, found = cv2.findChessboardCornersSB(bytes_, size, flags=cv2.CALIB_CB_ACCURACY)
        ids = list(range(size[0] * size[1])) if seen else None
    which = np.array([] if ids is None else ids, dtype=np.uint32).reshape(-1)
    if which.size == 0 and not missing_ok:
        raise invalid(f"{name}: OpenCV finds no {board.kind} `{board.name}`")
    pixels = np.zeros((0, 2)) if which.size == 0 else np.asarray(found, dtype=float).reshape(-1, 2)
    return Corners(which, pixels, _USUAL_CORNER_SIGMA_PX, name)


def _read(path: str | PathLike[str]) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        message = f"cannot read {os.fspath(path)}: {error}"
        problems = (Problem(message, file=os.fspath(path)),)
        raise FabkitError(message, code="io", exit_code=4, problems=problems) from error


def _write(path: str | PathLike[str], text: str) -> None:
    path = Path(path)
    _fabkit.write_files(str(path.parent), [(path.name, text.encode())])
