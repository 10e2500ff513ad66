"""Networks that are trained with numpy, their ONNX files, and fabkit's evaluation of these."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import fabkit
import fabkit.sim as sim
from fabkit_bench._onnx import Convolution, chain
from fabkit_bench._small import Form, Small

SEPARABLE = Form((3, 3), (3, 5), (5, 4), is_separable=True)
WHOLE = Form((3, 3), (4, 5), (5,), is_separable=False)


@pytest.mark.parametrize("form", [SEPARABLE, WHOLE])
def test_derivatives_equal_finite_differences_of_the_loss(form):
    network, random = Small(form, 1), np.random.default_rng(2)
    network.weights = [one.astype(float) for one in network.weights]
    network.biases = [one.astype(float) + 0.05 for one in network.biases]
    squares = random.uniform(0, 1, (40, form.side_px, form.side_px))
    targets = random.uniform(0, 1, 40)
    _, *slopes = network.loss(squares, targets)
    for parameters, derivatives in zip((network.weights, network.biases), slopes, strict=True):
        for one, derivative in zip(parameters, derivatives, strict=True):
            for k in range(0, one.size, max(1, one.size // 5)):
                middle, step = one.flat[k], 1e-6
                losses = []
                for sign in (1, -1):
                    one.flat[k] = middle + sign * step
                    losses.append(network.loss(squares, targets)[0])
                one.flat[k] = middle
                assert_allclose((losses[0] - losses[1]) / (2 * step), derivative.flat[k], atol=1e-8)


@pytest.mark.parametrize("form", [SEPARABLE, WHOLE])
def test_onnx_file_equals_the_trained_network(form, tmp_path):
    sensor = sim.Sensor("rtac0", size_px=(80, 60), spacing_mm=0.6)
    felt, rest = sensor.press("hemisphere@20deg,90deg,1mm", seed=4), sensor.press(seed=9)
    network = Small(form, 3)
    network.biases[-1][:] = 1.0
    network.weights[-1] *= np.float32(0.1)
    card = {"format": "fabkit-network-card", "version": 1, "output_mm": 2.0, "mask": None}
    card["input"] = {"blur_px": 1, "blur_sigma_px": 1, "offset_grey": 3, "maximum_grey": 47}
    found = {}
    for name, written in (("same", chain([])), ("network", network.onnx())):
        file = tmp_path / f"{name}.onnx"
        file.write_bytes(written)
        file.with_suffix(".json").write_text(json.dumps(card))
        found[name], contact = sensor.reconstruct(felt.image, rest.image, network=file)
    darkness, depth_mm = found["same"] / 2, found["network"]
    assert_allclose(contact, darkness > 0)
    side = form.side_px
    wide = np.pad(darkness, side // 2)
    squares = np.lib.stride_tricks.sliding_window_view(wide, (side, side))[contact]
    wanted = 2 * np.maximum(network.predict(squares.astype(np.float32)), 0)
    # Borders differ: the second convolution pads with zeros, training squares contain real pixels.
    inner = np.zeros_like(contact)
    inner[side:-side, side:-side] = True
    assert inner[contact].sum() > 50
    assert_allclose(depth_mm[contact & inner], wanted[inner[contact]], atol=1e-5)
    assert not depth_mm[~contact].any()


def test_a_network_of_other_layers_is_refused(tmp_path):
    sensor = sim.Sensor("rtac0", size_px=(40, 30), spacing_mm=0.8)
    rest = sensor.press(seed=9)
    wide = Convolution(np.ones((2, 1, 1, 1), np.float32), np.zeros(2, np.float32))
    file = tmp_path / "two.onnx"
    file.write_bytes(chain([wide]))
    with pytest.raises(fabkit.FabkitError, match="2 channels"):
        sensor.reconstruct(rest.image, rest.image, network=file)
