//! Layers of text that override each other.

/// Text that a value comes from. The order is also the order in which problems are reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextLayer {
    /// File that the user named.
    File,
    /// `--set`.
    Override,
    /// User's file that the file extends, this many steps away.
    Extended(u8),
    /// Built-in text: the sensor that is extended, and its defaults.
    Base,
    /// Value that applies where no text says anything, and keeps the behaviour of earlier versions.
    Default,
}

impl TextLayer {
    /// Returns whether values of this layer replace those of another.
    pub(crate) fn overrides(self, other: Self) -> bool {
        let height = |layer| match layer {
            Self::Default => 0,
            Self::Base => 1,
            // A step count is a `u8`, so 257 - 255 is still above `Base`, and 257 - 0 below `File`.
            Self::Extended(steps) => 257 - u16::from(steps),
            Self::File => 258,
            Self::Override => 259,
        };
        height(self) > height(other)
    }
}
