//! The texts that lie over each other.

/// Which text a value comes from; also the order in which problems are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextLayer {
    /// The file that was asked for.
    File,
    /// `--set`.
    Override,
    /// A file of the user's that the file extends, so many steps away.
    Extended(u8),
    /// What is built in: the sensor that it extends, defaults.
    Base,
    /// What holds where nobody says anything, and means that something is as it always was.
    Default,
}

impl TextLayer {
    /// Whether what stands in this text replaces what stands in another.
    pub(crate) fn is_over(self, other: Self) -> bool {
        let height = |layer| match layer {
            Self::Default => 0,
            Self::Base => 1,
            Self::Extended(steps) => 257 - u16::from(steps),
            Self::File => 258,
            Self::Override => 259,
        };
        height(self) > height(other)
    }
}
