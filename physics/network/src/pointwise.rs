//! Pointwise operations: those on each number by itself.

/// Constant for all channels, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub enum PointwiseConstant {
    Scalar(f32),
    Channels(Vec<f32>),
}

impl PointwiseConstant {
    /// Returns the constant with the opposite sign.
    pub fn negated(self) -> Self {
        match self {
            Self::Scalar(value) => Self::Scalar(-value),
            Self::Channels(values) => Self::Channels(values.iter().map(|value| -value).collect()),
        }
    }

    /// Applies `f` to each number and its constant; `values` are pixels of `width` channels, beginning with channel
    /// `first`.
    #[inline(always)]
    fn apply_each(
        &self,
        values: &mut [f32],
        width: usize,
        first: usize,
        f: impl Fn(f32, f32) -> f32,
    ) {
        match self {
            Self::Scalar(constant) => {
                values.iter_mut().for_each(|value| *value = f(*value, *constant))
            }
            Self::Channels(constants) => {
                for pixel in values.chunks_exact_mut(width) {
                    // A panel may be wider than the remaining channels; the surplus is not read.
                    for (value, constant) in pixel.iter_mut().zip(&constants[first..]) {
                        *value = f(*value, *constant);
                    }
                }
            }
        }
    }
}

/// Pointwise operation.
#[derive(Clone, Debug, PartialEq)]
pub enum Pointwise {
    /// Limits the value to `least` to `most`.
    Clip {
        least: f32,
        most: f32,
    },
    /// Logistic function, 1 / (1 + exp(-x)).
    Sigmoid,
    Add(PointwiseConstant),
    Multiply(PointwiseConstant),
    Divide(PointwiseConstant),
}

/// Applies all operations in order; `values` are pixels of `width` channels, of which the first is channel `first`.
#[inline(always)]
pub fn apply(steps: &[Pointwise], values: &mut [f32], width: usize, first: usize) {
    for step in steps {
        match step {
            Pointwise::Clip { least, most } => {
                // Each comparison is one instruction, whereas `max` and `min` would also handle NaN.
                for value in values.iter_mut() {
                    let above = if *value > *least { *value } else { *least };
                    *value = if above < *most { above } else { *most };
                }
            }
            Pointwise::Sigmoid => {
                values.iter_mut().for_each(|value| *value = 1.0 / (1.0 + (-*value).exp()));
            }
            Pointwise::Add(by) => by.apply_each(values, width, first, |value, by| value + by),
            Pointwise::Multiply(by) => by.apply_each(values, width, first, |value, by| value * by),
            Pointwise::Divide(by) => by.apply_each(values, width, first, |value, by| value / by),
        }
    }
}
