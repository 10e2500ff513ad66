//! One convolution, at any list of places.
//!
//! Maps have their channels fastest (rows x columns x channels), so that a row of the window is one run of numbers, and
//! the numbers of some outputs at one place lie together. A panel is so many outputs as some registers hold; some places
//! at once are summed over the whole window in registers. Each output is one sum, in the order of the window's rows,
//! columns and channels, by multiplications and additions that round once: it does not matter which places are asked
//! for together, how wide registers are, or which thread works.

use pulp::{Arch, Simd, WithSimd};

use crate::pointwise::{Pointwise, apply};

/// Places worked on before the next panel of weights is taken: what they sum up stays in the nearest cache.
const BLOCK: usize = 96;
/// Places whose sums are in registers at once, where a panel is two registers wide; three registers are left for
/// weights and inputs, of sixteen.
const TWO_WIDE: usize = 6;
/// The same for a panel that is one register wide.
const ONE_WIDE: usize = 8;

/// Weights of a panel that the nearest cache holds beside all else, bytes.
const NEAR_BYTES: usize = 16 << 10;

/// Weights in the order in which they are read.
#[derive(Clone, Debug)]
pub struct Convolution {
    /// Rows and columns of the window, odd.
    pub kernel: [usize; 2],
    /// Channels before and after.
    pub inputs: usize,
    pub outputs: usize,
    groups: usize,
    /// Each output has one input, which is its own.
    is_depthwise: bool,
    /// Registers that a panel is wide, and numbers.
    registers: usize,
    width: usize,
    /// One after the other: panels, places of the window with their inputs, outputs; 0 beyond the last output.
    weights: Vec<f32>,
    /// As wide as all panels together.
    bias: Vec<f32>,
}

/// Some outputs of one group.
#[derive(Clone, Copy, Debug)]
struct Panel {
    group: usize,
    /// The first of them.
    output: usize,
    /// How many.
    count: usize,
}

/// Numbers in the map that lie together, and belong to weights that do.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// From where the window begins.
    offset: usize,
    count: usize,
}

/// Where a convolution is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// The map before, and how many columns it has.
    pub map: &'a [f32],
    pub columns: usize,
    /// Where each window begins, as a pixel of the map before.
    pub windows: &'a [usize],
    /// Where what it gives belongs, as a pixel of the map after.
    pub pixels: &'a [usize],
}

/// How many numbers a register holds here.
struct Lanes;

impl WithSimd for Lanes {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F32_LANES
    }
}

impl Convolution {
    /// Of weights (outputs x inputs of a group x rows x columns) and one offset for each output.
    pub fn new(weights: &[f32], bias: &[f32], shape: [usize; 4], groups: usize) -> Self {
        let [outputs, per_group, rows, columns] = shape;
        let lanes = Arch::new().dispatch(Lanes);
        let is_depthwise = per_group == 1 && outputs == groups && groups > 1;
        // Inputs of a depthwise convolution take registers, too.
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

    /// Multiplications for each pixel.
    pub fn products(&self) -> u64 {
        let [rows, columns] = self.kernel;
        (rows * columns * self.outputs * (self.inputs / self.groups)) as u64
    }

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

    /// What lies together of a window, in the order of the weights.
    fn runs(&self, columns: usize, panel: Panel) -> Vec<Run> {
        let ([high, wide], inputs) = (self.kernel, self.inputs);
        if self.groups == 1 {
            let of = |row| Run { offset: row * columns * inputs, count: wide * inputs };
            return (0..high).map(of).collect();
        }
        let of_group = inputs / self.groups;
        let first = if self.is_depthwise { panel.output } else { panel.group * of_group };
        let of = |row, column| Run {
            offset: (row * columns + column) * inputs + first,
            count: of_group,
        };
        (0..high).flat_map(|row| (0..wide).map(move |column| of(row, column))).collect()
    }

    /// Writes what comes out at `places` into a map of `outputs` channels, each number taken through `then`.
    pub fn evaluate(&self, places: Places, then: &[Pointwise], into: &mut [f32]) {
        Arch::new().dispatch(Evaluation { convolution: self, places, then, into });
    }
}

struct Evaluation<'a> {
    convolution: &'a Convolution,
    places: Places<'a>,
    then: &'a [Pointwise],
    into: &'a mut [f32],
}

impl WithSimd for Evaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { convolution, places, then, into } = self;
        let Convolution { inputs, outputs, width, .. } = *convolution;
        let panels: Vec<(Panel, Vec<Run>)> = convolution
            .panels()
            .map(|panel| (panel, convolution.runs(places.columns, panel)))
            .collect();
        let weights_of = convolution.weights.len() / panels.len();
        let mut sums = vec![0.0; BLOCK * width];
        let mut starts = [0; BLOCK];
        for (windows, pixels) in places.windows.chunks(BLOCK).zip(places.pixels.chunks(BLOCK)) {
            // A last block that is not full looks at its last place again and again; nobody reads that.
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

/// Sums of a panel that is `WIDE` registers wide; `AT_ONCE` divides how many places there are.
#[inline(always)]
fn dense<S: Simd, const AT_ONCE: usize, const WIDE: usize>(
    simd: S,
    weights: &[f32],
    bias: &[f32],
    map: &[f32],
    runs: &[Run],
    starts: &[usize],
    sums: &mut [f32],
) {
    let mut weights = S::as_simd_f32s(weights).0.as_chunks::<WIDE>().0;
    let bias = S::as_simd_f32s(bias).0.as_chunks::<WIDE>().0[0];
    let sums = S::as_mut_simd_f32s(sums).0.as_chunks_mut::<WIDE>().0;
    // Weights that stay in the nearest cache anyway need not be taken run by run.
    let at_once = if size_of_val(weights) <= NEAR_BYTES { runs.len() } else { 1 };
    for (i, runs) in runs.chunks(at_once).enumerate() {
        let count = runs.iter().map(|run| run.count).sum();
        let (of_runs, rest) = weights.split_at(count);
        weights = rest;
        let some = starts.as_chunks::<AT_ONCE>().0.iter();
        for (starts, sums) in some.zip(sums.as_chunks_mut::<AT_ONCE>().0) {
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

/// Sums of a panel of `count` outputs that have inputs of their own; `inputs` is how many channels the map has.
#[inline(always)]
fn depthwise<S: Simd>(
    simd: S,
    [weights, bias]: [&[f32]; 2],
    (map, inputs): (&[f32], usize),
    (runs, count): (&[Run], usize),
    starts: &[usize],
    sums: &mut [f32],
) {
    let weights = S::as_simd_f32s(weights).0;
    let bias = S::as_simd_f32s(bias).0[0];
    let sums = S::as_mut_simd_f32s(sums).0;
    let some = starts.as_chunks::<ONE_WIDE>().0.iter();
    // Where channels fill registers, the map is one of registers.
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

/// Copies `N` numbers of each pixel's panel to where its channels are; a length that is known needs no call.
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
