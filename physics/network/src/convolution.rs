//! Convolution at any list of pixels.
//!
//! Maps have their channels fastest (rows x columns x channels), so that a row of the window is contiguous, and the
//! outputs at one pixel are adjacent. A panel is a group of outputs that fills one or two registers. Several pixels at
//! once are summed over the whole window in registers. Each output is one sum, in the order of the window's rows,
//! columns and channels, of fused multiply-adds that round once. The result therefore does not depend on which pixels
//! are evaluated together, on the width of registers, or on the threads.

use pulp::{Arch, Simd, WithSimd};

use crate::pointwise::{Pointwise, apply};

/// Pixels processed before the next panel of weights is loaded: their sums stay in the first-level cache.
const PIXELS_PER_BLOCK: usize = 96;
/// Pixels whose sums are in registers at once, for a panel that is two registers wide. Of sixteen registers, three are
/// left for weights and inputs.
const TWO_WIDE: usize = 6;
/// Pixels whose sums are in registers at once, for a panel that is one register wide.
const ONE_WIDE: usize = 8;

/// Maximum size of a panel's weights that stay in the first-level cache beside everything else, bytes.
const L1_WEIGHT_BYTES: usize = 16 << 10;

/// Convolution, with its weights in the order in which they are read.
#[derive(Clone, Debug)]
pub struct Convolution {
    /// Rows and columns of the window, odd.
    pub kernel: [usize; 2],
    /// Number of input and output channels.
    pub inputs: usize,
    pub outputs: usize,
    groups: usize,
    /// True if each output has exactly one input channel of its own.
    is_depthwise: bool,
    /// Width of a panel, in registers and in numbers.
    registers: usize,
    width: usize,
    /// Weights, ordered by panel, position in the window, input and output; 0 beyond the last output.
    weights: Vec<f32>,
    /// Biases, padded to the width of all panels.
    bias: Vec<f32>,
}

/// Outputs of one group that are computed together.
#[derive(Clone, Copy, Debug)]
struct Panel {
    group: usize,
    /// First output.
    output: usize,
    /// Number of outputs.
    count: usize,
}

/// Contiguous numbers in the map that belong to contiguous weights.
#[derive(Clone, Copy, Debug)]
struct ContiguousRun {
    /// Offset from the start of the window.
    offset: usize,
    count: usize,
}

/// Pixels at which a convolution is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationPixels<'a> {
    /// Input map, and its number of columns.
    pub map: &'a [f32],
    pub columns: usize,
    /// First pixel of each window in the input map.
    pub windows: &'a [usize],
    /// Pixel of the output map for each window.
    pub pixels: &'a [usize],
}

/// Query for the number of `f32` lanes in a register of this machine.
struct LaneCount;

impl WithSimd for LaneCount {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

impl Convolution {
    /// Creates a convolution from weights (outputs x inputs of a group x rows x columns) and one bias for each output.
    pub fn new(weights: &[f32], bias: &[f32], shape: [usize; 4], groups: usize) -> Self {
        let [outputs, per_group, rows, columns] = shape;
        let lanes = Arch::new().dispatch(LaneCount);
        let is_depthwise = per_group == 1 && outputs == groups && groups > 1;
        // In a depthwise convolution, inputs occupy registers too.
        let registers = if is_depthwise || outputs / groups <= lanes { 1 } else { 2 };
        let width = registers * lanes;
        let mut this = Self {
            kernel: [rows, columns],
            inputs: per_group * groups,
            outputs,
            groups,
            is_depthwise,
            registers,
            width,
            weights: Vec::new(),
            bias: Vec::new(),
        };
        let places = rows * columns;
        for Panel { output, count, .. } in this.panels() {
            let padded = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
                (0..width).map(|j| if j < count { value(output + j) } else { 0.0 }).collect()
            };
            for (place, input) in
                (0..places).flat_map(|place| (0..per_group).map(move |i| (place, i)))
            {
                let of = |output: usize| weights[(output * per_group + input) * places + place];
                this.weights.extend(padded(&of));
            }
            this.bias.extend(padded(&|output| bias[output]));
        }
        this
    }

    /// Returns the number of multiplications per pixel.
    pub fn multiplications_per_pixel(&self) -> u64 {
        let [rows, columns] = self.kernel;
        (rows * columns * self.outputs * (self.inputs / self.groups)) as u64
    }

    /// Lists the panels of all groups.
    fn panels(&self) -> impl Iterator<Item = Panel> + use<> {
        let groups = if self.is_depthwise { 1 } else { self.groups };
        let (of_group, width) = (self.outputs / groups, self.width);
        (0..groups).flat_map(move |group| {
            (0..of_group).step_by(width).map(move |first| Panel {
                group,
                output: group * of_group + first,
                count: width.min(of_group - first),
            })
        })
    }

    /// Lists the contiguous parts of a window, in the order of the weights.
    fn runs(&self, columns: usize, panel: Panel) -> Vec<ContiguousRun> {
        let ([high, wide], inputs) = (self.kernel, self.inputs);
        if self.groups == 1 {
            let of = |row| ContiguousRun { offset: row * columns * inputs, count: wide * inputs };
            return (0..high).map(of).collect();
        }
        let of_group = inputs / self.groups;
        let first = if self.is_depthwise { panel.output } else { panel.group * of_group };
        let of = |row, column| ContiguousRun {
            offset: (row * columns + column) * inputs + first,
            count: of_group,
        };
        (0..high).flat_map(|row| (0..wide).map(move |column| of(row, column))).collect()
    }

    /// Evaluates the convolution at `places` and writes each result, after the pointwise operations `then`, into a map
    /// with `outputs` channels.
    pub fn evaluate(&self, places: EvaluationPixels, then: &[Pointwise], into: &mut [f32]) {
        Arch::new().dispatch(Evaluation { convolution: self, places, then, into });
    }
}

/// Evaluation of a convolution, compiled for each width of registers.
struct Evaluation<'a> {
    convolution: &'a Convolution,
    places: EvaluationPixels<'a>,
    then: &'a [Pointwise],
    into: &'a mut [f32],
}

impl WithSimd for Evaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { convolution, places, then, into } = self;
        let Convolution { inputs, outputs, width, .. } = *convolution;
        let panels: Vec<(Panel, Vec<ContiguousRun>)> = convolution
            .panels()
            .map(|panel| (panel, convolution.runs(places.columns, panel)))
            .collect();
        // All panels have the same number of weights, thanks to padding.
        let weights_of = convolution.weights.len() / panels.len();
        let mut sums = vec![0.0; PIXELS_PER_BLOCK * width];
        let mut starts = [0; PIXELS_PER_BLOCK];
        for (windows, pixels) in
            places.windows.chunks(PIXELS_PER_BLOCK).zip(places.pixels.chunks(PIXELS_PER_BLOCK))
        {
            // An incomplete last block repeats its last pixel; these results are not read.
            let last = windows[windows.len() - 1];
            for (i, start) in starts.iter_mut().enumerate() {
                *start = windows.get(i).unwrap_or(&last) * inputs;
            }
            let rounded = |by: usize| windows.len().next_multiple_of(by);
            for (i, (panel, runs)) in panels.iter().enumerate() {
                let weights = &convolution.weights[i * weights_of..][..weights_of];
                let bias = &convolution.bias[i * width..][..width];
                let map = places.map;
                if convolution.is_depthwise {
                    let starts = &starts[..rounded(ONE_WIDE)];
                    depthwise::<S>(
                        simd,
                        [weights, bias],
                        (map, inputs),
                        (runs, panel.count),
                        starts,
                        &mut sums,
                    );
                } else if convolution.registers == 1 {
                    let starts = &starts[..rounded(ONE_WIDE)];
                    dense::<S, ONE_WIDE, 1>(simd, weights, bias, map, runs, starts, &mut sums);
                } else {
                    let starts = &starts[..rounded(TWO_WIDE)];
                    dense::<S, TWO_WIDE, 2>(simd, weights, bias, map, runs, starts, &mut sums);
                }
                apply(then, &mut sums[..windows.len() * width], width, panel.output);
                let place = [outputs, panel.output];
                // Constant lengths for the usual panel widths; see [`scatter`].
                match panel.count {
                    16 => scatter::<16>(&sums, width, pixels, place, into),
                    8 => scatter::<8>(&sums, width, pixels, place, into),
                    1 => scatter::<1>(&sums, width, pixels, place, into),
                    count => {
                        for (pixel, sums) in pixels.iter().zip(sums.chunks_exact(width)) {
                            let into = &mut into[pixel * outputs + panel.output..][..count];
                            into.copy_from_slice(&sums[..count]);
                        }
                    }
                }
            }
        }
    }
}

/// Sums a panel that is `WIDE` registers wide. The number of pixels is a multiple of `AT_ONCE`.
#[inline(always)]
fn dense<S: Simd, const AT_ONCE: usize, const WIDE: usize>(
    simd: S,
    weights: &[f32],
    bias: &[f32],
    map: &[f32],
    runs: &[ContiguousRun],
    starts: &[usize],
    sums: &mut [f32],
) {
    let mut weights = S::as_simd_f32s(weights).0.as_chunks::<WIDE>().0;
    let bias = S::as_simd_f32s(bias).0.as_chunks::<WIDE>().0[0];
    let sums = S::as_mut_simd_f32s(sums).0.as_chunks_mut::<WIDE>().0;
    // Weights that fit in the first-level cache are used all at once, otherwise run by run.
    let at_once = if size_of_val(weights) <= L1_WEIGHT_BYTES { runs.len() } else { 1 };
    for (i, runs) in runs.chunks(at_once).enumerate() {
        let count = runs.iter().map(|run| run.count).sum();
        let (of_runs, rest) = weights.split_at(count);
        weights = rest;
        let some = starts.as_chunks::<AT_ONCE>().0.iter();
        for (starts, sums) in some.zip(sums.as_chunks_mut::<AT_ONCE>().0) {
            // Later runs continue the sums of earlier ones.
            let mut sum = if i == 0 { [bias; AT_ONCE] } else { *sums };
            let mut left = of_runs;
            for run in runs {
                let (of_run, rest) = left.split_at(run.count);
                left = rest;
                let mut inputs = [&map[..0]; AT_ONCE];
                for p in 0..AT_ONCE {
                    inputs[p] = &map[starts[p] + run.offset..][..of_run.len()];
                }
                for k in 0..of_run.len() {
                    for p in 0..AT_ONCE {
                        let input = simd.splat_f32s(inputs[p][k]);
                        for n in 0..WIDE {
                            sum[p][n] = simd.mul_add_f32s(input, of_run[k][n], sum[p][n]);
                        }
                    }
                }
            }
            *sums = sum;
        }
    }
}

/// Sums a panel of `count` outputs that each have their own input channel; `inputs` is the number of channels of the
/// map.
#[inline(always)]
fn depthwise<S: Simd>(
    simd: S,
    [weights, bias]: [&[f32]; 2],
    (map, inputs): (&[f32], usize),
    (runs, count): (&[ContiguousRun], usize),
    starts: &[usize],
    sums: &mut [f32],
) {
    let weights = S::as_simd_f32s(weights).0;
    let bias = S::as_simd_f32s(bias).0[0];
    let sums = S::as_mut_simd_f32s(sums).0;
    let some = starts.as_chunks::<ONE_WIDE>().0.iter();
    // If the channels fill whole registers, the map can be read register by register.
    let fills = inputs.is_multiple_of(S::F32_LANES);
    let registers = S::as_simd_f32s(map).0;
    for (starts, sums) in some.zip(sums.as_chunks_mut::<ONE_WIDE>().0) {
        let mut sum = [bias; ONE_WIDE];
        if fills {
            let starts = starts.map(|start| start / S::F32_LANES);
            for (run, weight) in runs.iter().zip(weights) {
                let offset = run.offset / S::F32_LANES;
                for p in 0..ONE_WIDE {
                    sum[p] = simd.mul_add_f32s(registers[starts[p] + offset], *weight, sum[p]);
                }
            }
        } else {
            for (run, weight) in runs.iter().zip(weights) {
                for p in 0..ONE_WIDE {
                    let input = simd.partial_load_f32s(&map[starts[p] + run.offset..][..count]);
                    sum[p] = simd.mul_add_f32s(input, *weight, sum[p]);
                }
            }
        }
        *sums = sum;
    }
}

/// Copies the `N` results of each pixel to its channels in the map. The constant length avoids a call to `memcpy`.
#[inline(always)]
fn scatter<const N: usize>(
    sums: &[f32],
    width: usize,
    pixels: &[usize],
    [outputs, first]: [usize; 2],
    into: &mut [f32],
) {
    for (pixel, sums) in pixels.iter().zip(sums.chunks_exact(width)) {
        let into = into[pixel * outputs + first..].first_chunk_mut::<N>();
        if let (Some(into), Some(sums)) = (into, sums.first_chunk::<N>()) {
            *into = *sums;
        }
    }
}
