//! What is done to each number on its own.

/// A constant for all channels, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub enum Constant {
    Same(f32),
    Channels(Vec<f32>),
}

impl Constant {
    /// With the other sign.
    pub fn negative(self) -> Self {
        match self {
            Self::Same(value) => Self::Same(-value),
            Self::Channels(values) => Self::Channels(values.iter().map(|value| -value).collect()),
        }
    }

    /// Applies `f` to each number and its constant; `values` are pixels of `width` channels from channel `first`.
    #[inline(always)]
    fn each(&self, values: &mut [f32], width: usize, first: usize, f: impl Fn(f32, f32) -> f32) {
        match self {
            Self::Same(constant) => {
                values.iter_mut().for_each(|value| *value = f(*value, *constant))
            }
            Self::Channels(constants) => {
                for pixel in values.chunks_exact_mut(width) {
                    // A panel may be wider than what is left of the channels; nobody reads that.
                    for (value, constant) in pixel.iter_mut().zip(&constants[first..]) {
                        *value = f(*value, *constant);
                    }
                }
            }
        }
    }
}

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub enum Pointwise {
    /// Not below the one, not above the other.
    Clip {
        least: f32,
        most: f32,
    },
    /// 1 / (1 + exp(-x)).
    Sigmoid,
    Add(Constant),
    Multiply(Constant),
    Divide(Constant),
}

/// Does all steps; `values` are pixels of `width` channels, of which the first is channel `first`.
#[inline(always)]
pub fn apply(steps: &[Pointwise], values: &mut [f32], width: usize, first: usize) {
    for step in steps {
        match step {
            Pointwise::Clip { least, most } => {
                // Comparisons that are one instruction each, where `max` and `min` would look for what is no number.
                for value in values.iter_mut() {
                    let above = if *value > *least { *value } else { *least };
                    *value = if above < *most { above } else { *most };
                }
            }
            Pointwise::Sigmoid => {
                values.iter_mut().for_each(|value| *value = 1.0 / (1.0 + (-*value).exp()));
            }
            Pointwise::Add(by) => by.each(values, width, first, |value, by| value + by),
            Pointwise::Multiply(by) => by.each(values, width, first, |value, by| value * by),
            Pointwise::Divide(by) => by.each(values, width, first, |value, by| value / by),
        }
    }
}
