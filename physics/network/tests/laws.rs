//! Evaluated networks equal plain loops over all windows to the bit, for any requested pixels, tiles and threads.

use fabkit_network::writer::{ChainLayer, write_chain};
use fabkit_network::{Network, TILE_PX};
use proptest::prelude::*;

/// Pseudo-random numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn some(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.next()).collect()
    }
}

/// Convolution as the tests compute it: outputs x inputs of a group x rows x columns.
#[derive(Clone)]
struct Plain {
    shape: [usize; 4],
    groups: usize,
    weights: Vec<f32>,
    bias: Vec<f32>,
}

impl Plain {
    fn new(numbers: &mut Numbers, shape: [usize; 4], groups: usize) -> Self {
        let weights = numbers.some(shape.iter().product());
        Self { shape, groups, weights, bias: numbers.some(shape[0]) }
    }

    fn layer(&self) -> ChainLayer {
        ChainLayer::convolution(self.shape, self.groups, &self.weights, &self.bias)
    }

    /// Computes one output at one pixel: starts from the bias and applies `step` over rows, columns and channels of the
    /// window.
    fn at<T: Copy>(
        &self,
        maps: &[Vec<f32>],
        columns: usize,
        [output, row, column]: [usize; 3],
        first: impl Fn(f32) -> T,
        step: impl Fn(T, f32, f32) -> T,
    ) -> T {
        let [outputs, per_group, high, wide] = self.shape;
        let rows = maps[0].len() / columns;
        let group = output / (outputs / self.groups);
        let mut sum = first(self.bias[output]);
        for (ky, kx) in (0..high).flat_map(|ky| (0..wide).map(move |kx| (ky, kx))) {
            let (y, x) = (row + ky, column + kx);
            let inside = (high / 2..rows + high / 2).contains(&y)
                && (wide / 2..columns + wide / 2).contains(&x);
            for input in 0..per_group {
                let weight = self.weights[((output * per_group + input) * high + ky) * wide + kx];
                let value = if inside {
                    maps[group * per_group + input][(y - high / 2) * columns + x - wide / 2]
                } else {
                    0.0
                };
                sum = step(sum, weight, value);
            }
        }
        sum
    }

    /// Computes all outputs, with sums rounded as the crate documents.
    fn map(&self, maps: &[Vec<f32>], columns: usize) -> Vec<Vec<f32>> {
        let pixels = maps[0].len();
        let of = |output: usize, i: usize| {
            let at = [output, i / columns, i % columns];
            self.at(maps, columns, at, |bias| bias, |sum, w, x| x.mul_add(w, sum))
        };
        (0..self.shape[0]).map(|o| (0..pixels).map(|i| of(o, i)).collect()).collect()
    }
}

fn relu(maps: &mut [Vec<f32>]) {
    maps.iter_mut().flatten().for_each(|value| *value = value.max(0.0));
}

/// Builds four convolutions, to be used with a Relu between them: odd channel counts, a depthwise or full one, and a
/// grouped one.
fn four_convolutions(numbers: &mut Numbers, channels: usize, depthwise: bool) -> Vec<Plain> {
    let middle = if depthwise {
        ([channels, 1, 5, 3], channels)
    } else {
        ([2 * channels, channels, 3, 5], 1)
    };
    let last = middle.0[0];
    let groups = if last % 2 == 0 { 2 } else { 1 };
    vec![
        Plain::new(numbers, [channels, 1, 3, 7], 1),
        Plain::new(numbers, middle.0, middle.1),
        Plain::new(numbers, [4, last / groups, 1, 1], groups),
        Plain::new(numbers, [1, 4, 3, 3], 1),
    ]
}

fn network(plain: &[Plain]) -> Network {
    let mut layers = vec![];
    for (i, one) in plain.iter().enumerate() {
        layers.push(one.layer());
        if i + 1 < plain.len() {
            layers.push(ChainLayer::operator("Relu"));
        }
    }
    Network::read(&write_chain(&layers)).unwrap()
}

/// Draws an image, with zeros outside a pattern of patches if `sparse`.
fn image(numbers: &mut Numbers, [rows, columns]: [usize; 2], sparse: bool) -> Vec<f32> {
    let mut image = numbers.some(rows * columns);
    for (i, value) in image.iter_mut().enumerate() {
        let (row, column) = (i / columns, i % columns);
        if sparse && !(row / 5 % 3 == 0 && column / 7 % 4 == 1) {
            *value = 0.0;
        }
    }
    image
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn chains_equal_plain_loops_to_the_bit() {
    for (seed, channels, depthwise, size) in [
        (1, 3, true, [40, 45]),
        (2, 8, true, [33, 32]),
        (3, 16, true, [20, 70]),
        (4, 19, true, [9, 11]),
        (5, 5, false, [35, 40]),
        (6, 12, false, [64, 8]),
        (7, 1, false, [1, 1]),
    ] {
        let mut numbers = Numbers(seed);
        let plain = four_convolutions(&mut numbers, channels, depthwise);
        let image = image(&mut numbers, size, false);
        let mut maps = vec![image.clone()];
        for (i, one) in plain.iter().enumerate() {
            maps = one.map(&maps, size[1]);
            if i + 1 < plain.len() {
                relu(&mut maps);
            }
        }
        let found = network(&plain).run(&image, size[1]).unwrap();
        assert_eq!(bits(&found), bits(&maps[0]), "{channels} {depthwise}");
    }
}

#[test]
fn a_convolution_is_as_exact_as_its_sum_can_be() {
    let mut numbers = Numbers(11);
    let size = [21, 37];
    for kernel in [[1, 1], [3, 3], [7, 7], [1, 9]] {
        let first = Plain::new(&mut numbers, [6, 1, 1, 1], 1);
        let second = Plain::new(&mut numbers, [1, 6, kernel[0], kernel[1]], 1);
        let image = image(&mut numbers, size, false);
        let maps = first.map(std::slice::from_ref(&image), size[1]);
        let file = write_chain(&[first.layer(), second.layer()]);
        let found = Network::read(&file).unwrap().run(&image, size[1]).unwrap();
        // Each of n steps rounds once, by at most half a unit in the last place of the sum so far.
        let steps = (6 * kernel[0] * kernel[1] + 1) as f64;
        for (i, found) in found.iter().enumerate() {
            let at = [0, i / size[1], i % size[1]];
            let [exact, sizes] = second.at(
                &maps,
                size[1],
                at,
                |bias| [f64::from(bias), f64::from(bias.abs())],
                |[sum, sizes], w, x| {
                    let product = f64::from(w) * f64::from(x);
                    [sum + product, sizes + product.abs()]
                },
            );
            let bound = steps * f64::from(f32::EPSILON / 2.0) * sizes;
            assert!((f64::from(*found) - exact).abs() <= bound, "{kernel:?}: {found} {exact}");
        }
    }
}

#[test]
fn run_touched_equals_run_where_the_image_is_nonzero() {
    for size in [[100, 130], [TILE_PX, TILE_PX], [7, 200]] {
        let mut numbers = Numbers(21);
        let network = network(&four_convolutions(&mut numbers, 10, true));
        let image = image(&mut numbers, size, true);
        let all = network.run(&image, size[1]).unwrap();
        let touched = network.run_nonzero(&image, size[1]).unwrap();
        let mut evaluated = 0;
        for ((image, all), touched) in image.iter().zip(&all).zip(&touched) {
            let wanted = if *image == 0.0 { 0.0f32 } else { *all };
            assert_eq!(touched.to_bits(), wanted.to_bits());
            evaluated += usize::from(*image != 0.0);
        }
        assert!(evaluated > 0 && evaluated < image.len() / 2);
    }
    let network = network(&four_convolutions(&mut Numbers(22), 4, false));
    assert_eq!(network.run_nonzero(&[0.0; 60], 6).unwrap(), [0.0; 60]);
    assert!(network.run(&[0.0; 60], 6).unwrap().iter().any(|value| *value != 0.0));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let mut numbers = Numbers(31);
    let network = network(&four_convolutions(&mut numbers, 7, false));
    let image = image(&mut numbers, [150, 170], true);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let [all, touched] = [network.run(&image, 170), network.run_nonzero(&image, 170)];
            (bits(&all.unwrap()), bits(&touched.unwrap()))
        })
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(8));
}

#[test]
fn numbers_between_layers_are_scaled_and_cut_off() {
    let three = ChainLayer::convolution([3, 1, 1, 1], 1, &[1.0, 2.0, 3.0], &[0.0; 3]);
    let sum = ChainLayer::convolution([1, 3, 1, 1], 1, &[1.0; 3], &[0.0]);
    let file = write_chain(&[
        ChainLayer::operator("Mul").with_constant(&[], &[10.0]),
        three,
        ChainLayer::operator("Sub").with_constant(&[1, 3, 1, 1], &[1.0, 2.0, 3.0]),
        ChainLayer::operator("Div").with_constant(&[3, 1, 1], &[1.0, 2.0, 4.0]),
        ChainLayer::operator("Add").with_constant(&[1], &[0.5]),
        ChainLayer::operator("Clip").with_constant(&[], &[0.0]).with_constant(&[], &[6.0]),
        ChainLayer::operator("Identity"),
        sum,
        ChainLayer::operator("Sigmoid"),
    ]);
    let network = Network::read(&file).unwrap();
    let found = network.run(&[0.2, -1.0], 2).unwrap();
    let of = |x: f32| {
        let x = 10.0 * x;
        let maps = [x - 1.0, (2.0 * x - 2.0) / 2.0, (3.0 * x - 3.0) / 4.0];
        let sum: f32 = maps.iter().map(|x| (x + 0.5).clamp(0.0, 6.0)).sum();
        1.0 / (1.0 + (-sum).exp())
    };
    for (found, x) in found.iter().zip([0.2, -1.0]) {
        assert!((found - of(x)).abs() < 1e-6, "{found} {}", of(x));
    }
    assert_eq!((network.parameters(), network.multiplications_per_pixel()), (10, 6));
    assert_eq!(network.reach_px(), [0, 0]);
}

#[test]
fn malformed_images_are_refused() {
    let network = network(&four_convolutions(&mut Numbers(41), 2, true));
    assert_eq!(network.reach_px(), [4, 5]);
    let told = |image: &[f32], columns| network.run(image, columns).unwrap_err().to_string();
    assert_eq!(told(&[0.0; 7], 2), "7 values are no image of 2 columns");
    assert_eq!(told(&[0.0; 7], 0), "7 values are no image of 0 columns");
    assert_eq!(told(&[f32::NAN; 4], 2), "the image has a value that is not finite");
    assert_eq!(network.run(&[], 3).unwrap(), []);
}

#[test]
fn unsupported_graphs_are_refused_with_the_node_named() {
    let one = |shape: [usize; 4]| {
        ChainLayer::convolution(shape, 1, &vec![1.0; shape.iter().product()], &vec![0.0; shape[0]])
    };
    let told = |layers: &[ChainLayer]| Network::read(&write_chain(layers)).unwrap_err().to_string();
    for (layers, wanted) in [
        (
            vec![one([1, 1, 3, 3]), ChainLayer::operator("MaxPool")],
            "node 2 `n1`: MaxPool is not known; a chain of Conv, Relu, Clip, Sigmoid, Identity, and Add, Sub, Mul, Div with \
             a constant is",
        ),
        (
            vec![one([1, 1, 3, 3]).with_attribute("strides", &[2, 2])],
            "node 1 `n0`: Conv with strides [2, 2]; 1 is accepted",
        ),
        (
            vec![one([1, 1, 3, 3]).with_attribute("dilations", &[1, 2])],
            "node 1 `n0`: Conv with dilations [1, 2]; 1 is accepted",
        ),
        (
            vec![one([1, 1, 3, 3]).with_attribute("pads", &[0, 0, 0, 0])],
            "node 1 `n0`: Conv with pads [0, 0, 0, 0]; [1, 1, 1, 1]: maps keep their size is accepted",
        ),
        (
            vec![one([1, 1, 2, 2])],
            "node 1 `n0`: Conv with a kernel of 2 x 2; an odd size is accepted",
        ),
        (
            vec![one([2, 1, 1, 1]), one([1, 3, 1, 1])],
            "node 2 `n1`: Conv with 1 x 3 channels in 1 groups after 2 channels; as many inputs as there are, groups of \
             equal size is accepted",
        ),
        (vec![one([2, 1, 1, 1])], "the network gives 2 channels; one is accepted: depth"),
        (
            vec![one([1, 1, 1, 131])],
            "the network has a reach of 65 px to each side; at most 64 are accepted",
        ),
        (
            vec![one([1, 1, 1, 1]), ChainLayer::operator("Add")],
            "node 2 `n1`: Add with one input; one map and one constant is accepted",
        ),
        (
            vec![
                one([2, 1, 1, 1]),
                ChainLayer::operator("Mul").with_constant(&[2], &[1.0, 2.0]),
                one([1, 2, 1, 1]),
            ],
            "node 2 `n1`: Mul with a constant of shape [2]; one number, or 2 x 1 x 1: one for each channel is accepted",
        ),
        (
            vec![ChainLayer::convolution([1, 1, 1, 1], 1, &[f32::NAN], &[0.0])],
            "constant `c0.0`: a number is not finite; as many finite 32 bit numbers as its shape says, in this file, are \
             accepted",
        ),
    ] {
        assert_eq!(told(&layers), wanted);
    }
    let whole = write_chain(&[one([1, 1, 3, 3])]);
    assert_eq!(
        Network::read(b"PK\x03\x04 is another kind of file").unwrap_err().to_string(),
        "this is no ONNX file: its bytes are not those of a model"
    );
    let cut = Network::read(&whole[..whole.len() / 2]).unwrap_err().to_string();
    assert_eq!(cut, "the file ends within a value: it is cut off");
    assert!(Network::read(&[]).is_err());
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Network::read(&bytes);
    }

    #[test]
    fn corrupted_networks_are_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut numbers = Numbers(51);
        let plain = four_convolutions(&mut numbers, 2, true);
        let layers: Vec<ChainLayer> = plain.iter().map(Plain::layer).collect();
        let mut bytes = write_chain(&layers);
        prop_assert!(Network::read(&bytes).is_ok());
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate(bytes.len().min(bytes.len() / 2 + cut.index(bytes.len())));
        if let Ok(network) = Network::read(&bytes) {
            let _ = network.run(&[1.0; 12], 3);
        }
    }
}
