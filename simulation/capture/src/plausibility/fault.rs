//! Faults of images and results.

use serde_json::{Value, json};

/// What is wrong with an image, or with what it shows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImageFault {
    /// Values that are infinite or no numbers.
    #[error("{count} of {of} values are no finite numbers")]
    NotFinite {
        /// Number of such values.
        count: usize,
        /// Number of all values.
        of: usize,
    },
    /// An image whose values all lie in the lowest sixteenth of the range.
    #[error(
        "no value exceeds {:.4} of the range (at least {:.4} expected): too dark, or fewer bits than the file has room for, as 12 in 16",
        .largest, .least
    )]
    NarrowRange {
        /// Largest value, as a share of the range.
        largest: f64,
        /// Smallest largest value that is expected.
        least: f64,
    },
    /// An image at rest that is much darker than the drawn light.
    #[error(
        "the surface is {:.2} times as bright as drawn (at least {:.2} expected)", .level, .least
    )]
    Level {
        /// Median brightness of the surface relative to the drawn light.
        level: f64,
        /// Smallest level that is expected.
        least: f64,
    },
    /// An image in colour of a sensor whose light is white.
    #[error(
        "the surface has colours (saturation {:.2}, at most {:.2} expected), and the drawn light has none", .saturation, .most
    )]
    Colored {
        /// Mean saturation.
        saturation: f64,
        /// Largest saturation that is expected.
        most: f64,
    },
    /// An image that fits better when its colours are exchanged or when it is turned.
    #[error(
        "the image fits {against} best {} (similarity {best:.2}; as given {as_given:.2})",
        .changes.join(", or ")
    )]
    Rearranged {
        /// What the image is compared with.
        against: &'static str,
        /// Changes that make it fit, equally good ones.
        changes: Vec<String>,
        /// Similarity after the change.
        best: f64,
        /// Similarity of the image as it is.
        as_given: f64,
    },
    /// An image whose light is not the drawn one.
    #[error(
        "the light is not that of this sensor: similarity {similarity:.2} with the drawn light (at least {least:.2} expected)"
    )]
    OtherLight {
        /// Similarity with the drawn light.
        similarity: f64,
        /// Smallest similarity that is expected.
        least: f64,
    },
    /// An image whose exposure differs from that at rest.
    #[error(
        "most of the image is {ratio:.2} times as bright as at rest ({:.2} to {:.2} expected)", .limits[0], .limits[1]
    )]
    OtherExposure {
        /// Median brightness relative to the image at rest.
        ratio: f64,
        /// Limits of the ratio.
        limits: [f64; 2],
    },
    /// Depth below the bottom of the soft layers.
    #[error("{depth_mm:.2} mm deep at pixel {}, {}: the soft layers end at {limit_mm:.2} mm there", .at_px[0], .at_px[1])]
    TooDeep {
        /// Depth, mm.
        depth_mm: f64,
        /// Depth along this pixel's ray at which the soft layers end, mm.
        limit_mm: f64,
        /// Column and row.
        at_px: [usize; 2],
    },
    /// Contact nearly everywhere.
    #[error("{:.0} % of the surface is in contact (at most {:.0} % expected)", 100.0 * .share, 100.0 * .most)]
    ContactEverywhere {
        /// Share of the surface in contact.
        share: f64,
        /// Largest share that is expected.
        most: f64,
    },
    /// A contact at the rim that is deeper than the deepest one inside.
    #[error(
        "a place in the rim of the surface (pixel {}, {}) reads {rim_mm:.2} mm, and the deepest inside {inside_mm:.2} mm", .at_px[0], .at_px[1]
    )]
    DeepestAtRim {
        /// Depth at the rim, mm.
        rim_mm: f64,
        /// Depth inside, mm.
        inside_mm: f64,
        /// Column and row of the place in the rim.
        at_px: [usize; 2],
    },
    /// A model of light that does not explain its captures.
    #[error(
        "the fitted light leaves {rms:.1} intensities unexplained of {mean:.1} at rest ({:.0} % at most expected)", 100.0 * .most
    )]
    Unexplained {
        /// Root mean square residual, intensities.
        rms: f64,
        /// Mean intensity at rest.
        mean: f64,
        /// Largest share that is expected.
        most: f64,
    },
}

impl ImageFault {
    /// Returns the code that programs can rely on.
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotFinite { .. } => "not_finite",
            Self::NarrowRange { .. } => "narrow_range",
            Self::Level { .. } => "other_level",
            Self::Colored { .. } => "unexpected_colors",
            Self::Rearranged { .. } => "rearranged",
            Self::OtherLight { .. } => "other_light",
            Self::OtherExposure { .. } => "other_exposure",
            Self::TooDeep { .. } => "too_deep",
            Self::ContactEverywhere { .. } => "contact_everywhere",
            Self::DeepestAtRim { .. } => "deepest_at_rim",
            Self::Unexplained { .. } => "unexplained",
        }
    }

    /// Returns what to do about it.
    pub fn advice(&self) -> String {
        match self {
            Self::NotFinite { .. } => "write finite values".to_owned(),
            Self::NarrowRange { largest, .. } => match fitting_bits(*largest) {
                Some(bits) => format!(
                    "if the camera has {bits} bits, multiply the values by {}; else take brighter images",
                    1u32 << (16 - bits)
                ),
                None => "take it with the light on".to_owned(),
            },
            Self::Level { .. } => "take it with the light on, and with a longer exposure".to_owned(),
            Self::Colored { .. } => {
                "name the sensor that took it, or convert the image to grey if the light has this colour".to_owned()
            }
            Self::Rearranged { .. } => {
                "write colours in the order red, green, blue, and images as the drawn camera holds them".to_owned()
            }
            Self::OtherLight { .. } => {
                "name the sensor that took it, or set its lamps as they are built".to_owned()
            }
            Self::OtherExposure { .. } => {
                "take all images with the exposure, gain and white balance of the image at rest".to_owned()
            }
            Self::TooDeep { .. } | Self::ContactEverywhere { .. } => {
                "take image and reference of the same unit, at the same exposure, and look at both".to_owned()
            }
            Self::DeepestAtRim { .. } => {
                "look at the rim: light or camera may have moved since the image at rest".to_owned()
            }
            Self::Unexplained { .. } => {
                "look at the captures: are sensor, scale and ball those of the images?".to_owned()
            }
        }
    }

    /// Returns the figures by name, for documents.
    pub fn figures(&self) -> Value {
        match self {
            Self::NotFinite { count, of } => json!({ "count": count, "of": of }),
            Self::NarrowRange { largest, least } => json!({ "largest": largest, "least": least }),
            Self::Level { level, least } => json!({ "level": level, "least": least }),
            Self::Colored { saturation, most } => json!({ "saturation": saturation, "most": most }),
            Self::Rearranged { against, changes, best, as_given } => json!({
                "against": against, "changes": changes, "best": best, "as_given": as_given,
            }),
            Self::OtherLight { similarity, least } => {
                json!({ "similarity": similarity, "least": least })
            }
            Self::OtherExposure { ratio, limits } => json!({ "ratio": ratio, "limits": limits }),
            Self::TooDeep { depth_mm, limit_mm, at_px } => {
                json!({ "depth_mm": depth_mm, "limit_mm": limit_mm, "at_px": at_px })
            }
            Self::ContactEverywhere { share, most } => json!({ "share": share, "most": most }),
            Self::DeepestAtRim { rim_mm, inside_mm, at_px } => {
                json!({ "rim_mm": rim_mm, "inside_mm": inside_mm, "at_px": at_px })
            }
            Self::Unexplained { rms, mean, most } => {
                json!({ "rms": rms, "mean": mean, "most": most })
            }
        }
    }
}

/// Returns the number of bits, 10 or 12, that values of a 16-bit file up to this share of its range would fill. `None`
/// if they would fill neither by half.
fn fitting_bits(largest: f64) -> Option<u32> {
    let code = largest * f64::from(u16::MAX);
    [10, 12].into_iter().find(|bits| {
        let codes = f64::from(1u32 << bits);
        (0.5 * codes..=codes).contains(&code)
    })
}
