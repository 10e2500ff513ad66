//! Text on a plane of a part: cut into it, or standing on it.

mod lettering;

use std::collections::BTreeSet;

use fabkit_geometry::{CUT_OVERLAP_MM, CutFeature, Pose, Solid};

pub use lettering::{Lettering, NoGlyph};

use super::INTO_MM;

/// Smallest legible height of printed letters, mm: of resin; filament needs 3 mm.
pub const LEAST_HEIGHT_MM: f64 = 2.5;

/// Default width of strokes, mm: two lines of a 0.4 mm nozzle.
const STROKE_MM: f64 = super::PRINTED_WALL_MM;

/// Largest width of strokes, as a fraction of the height: wider ones close the holes of letters.
const MOST_STROKE: f64 = 0.18;

/// Default depth or height of letters, mm: two layers.
const DEPTH_MM: f64 = 0.4;

/// Text on a plane, with strokes that print.
///
/// Lower-case Latin letters are written as capitals.
///
/// ```
/// use fabkit_designs::blocks::label::Label;
/// use fabkit_geometry::{Body, Pose, Process, Solid};
/// // On the front of a lid of 40 x 8 x 3 mm, that is read from -y.
/// let upright = Pose::rotation_x(fabkit_geometry::Angle::from_deg(90.0).ok_or("not finite")?);
/// let front = Pose::translation(0.0, -4.0, 1.5).then_in(upright);
/// # assert!(Label::new("lid-2", 2.0, front).is_err());
/// let lid = Solid::cuboid_between([-20.0, -4.0, -3.0], [20.0, 4.0, 6.0]);
/// let label = Label::new("lid-2", 5.0, front)?;
/// assert!(label.size_mm()[0] < 40.0 - 2.0);
/// let lid = Body::made("lid", "closes the box", Process::Fdm, lid).cut(label.sunken());
/// # assert!(lid.solid.validate().is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    text: String,
    font: Lettering,
    depth_mm: f64,
    pose: Pose,
}

/// Reason why a text cannot become a label.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LabelError {
    /// Characters that the font does not have, each once.
    #[error(
        "label `{text}`: there are no letters for {}; write A to Z, 0 to 9, `-`, `.`, `/` and spaces",
        listed(.missing)
    )]
    NoGlyphs {
        /// Text of the label.
        text: String,
        /// Missing characters.
        missing: BTreeSet<char>,
    },
    /// No characters except spaces.
    #[error("a label without letters; write at least one")]
    Empty,
    /// Letters too low to be legible; holds their height, mm.
    #[error(
        "letters of a label are {0} mm high; below {LEAST_HEIGHT_MM} mm they cannot be read when they \
         are printed; write {LEAST_HEIGHT_MM} mm or more"
    )]
    Low(f64),
    /// Strokes so wide that the holes of letters close, or of no width.
    #[error(
        "strokes of a label are {stroke_mm} mm wide; letters {height_mm} mm high take more than 0 and \
         at most {most:.2} mm; write thinner strokes or higher letters",
        most = MOST_STROKE * .height_mm
    )]
    Stroke {
        /// Requested width of the strokes, mm.
        stroke_mm: f64,
        /// Height of the letters, mm.
        height_mm: f64,
    },
    /// Depth that is not positive, mm.
    #[error("letters of a label are {0} mm deep; write more than 0 mm, for example {DEPTH_MM} mm")]
    Depth(f64),
}

/// Formats characters for messages, such as `&` and `ä`.
fn listed(characters: &BTreeSet<char>) -> String {
    let quoted: Vec<String> = characters.iter().map(|c| format!("`{c}`")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

impl Label {
    /// Creates a label of that height (mm) around the origin of the pose: x along the text, y up, z out of the face
    /// that carries it, towards the reader. Strokes are 0.8 mm wide if the letters are high enough for that, and 0.4 mm
    /// deep.
    ///
    /// # Errors
    /// Characters that the font does not have, no letters, or letters that are too low.
    pub fn new(text: &str, height_mm: f64, pose: Pose) -> Result<Self, LabelError> {
        let capitals = text.to_ascii_uppercase();
        let missing: BTreeSet<char> =
            capitals.chars().filter(|c| *c != ' ' && !Lettering::has(*c)).collect();
        if !missing.is_empty() {
            return Err(LabelError::NoGlyphs { text: text.into(), missing });
        }
        if capitals.chars().all(|c| c == ' ') {
            return Err(LabelError::Empty);
        }
        // Written so that NaN is refused too.
        if !(height_mm >= LEAST_HEIGHT_MM && height_mm.is_finite()) {
            return Err(LabelError::Low(height_mm));
        }
        let stroke_mm = STROKE_MM.min(MOST_STROKE * height_mm);
        let font = Lettering { height_mm, stroke_mm };
        Ok(Self { text: capitals, font, depth_mm: DEPTH_MM, pose })
    }

    /// Sets the width of the strokes, mm.
    ///
    /// # Errors
    /// Strokes that close the holes of letters.
    pub fn with_stroke(mut self, stroke_mm: f64) -> Result<Self, LabelError> {
        let height_mm = self.font.height_mm;
        // Written so that NaN is refused too.
        if !(stroke_mm > 0.0 && stroke_mm <= MOST_STROKE * height_mm) {
            return Err(LabelError::Stroke { stroke_mm, height_mm });
        }
        self.font.stroke_mm = stroke_mm;
        Ok(self)
    }

    /// Sets the depth of sunken letters or the height of raised ones, mm.
    ///
    /// # Errors
    /// A depth that is not positive.
    pub fn with_depth(self, depth_mm: f64) -> Result<Self, LabelError> {
        if depth_mm > 0.0 && depth_mm.is_finite() {
            Ok(Self { depth_mm, ..self })
        } else {
            Err(LabelError::Depth(depth_mm))
        }
    }

    /// Sets the pose.
    #[must_use]
    pub fn at(self, pose: Pose) -> Self {
        Self { pose, ..self }
    }

    /// Returns the text in capitals.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the edges of the smallest rectangle centred on the pose's origin that holds all letters: width and
    /// height, mm.
    pub fn size_mm(&self) -> [f64; 2] {
        let letters = self.font.profiles(&self.text).unwrap_or_default();
        let bounds = letters.iter().flat_map(|letter| letter.bounds_mm());
        // Letters are not symmetric about the origin: the farther side counts twice.
        let far =
            bounds.fold([0.0_f64; 2], |far, [x, y]| [far[0].max(x.abs()), far[1].max(y.abs())]);
        far.map(|far| 2.0 * far)
    }

    /// Returns letters cut into the body. They pass through nothing, so that they add no handles.
    pub fn sunken(&self) -> CutFeature {
        CutFeature {
            tools: vec![self.between(-self.depth_mm, CUT_OVERLAP_MM)],
            ..CutFeature::default()
        }
    }

    /// Returns letters that stand on the body, to be united with it; they reach into it, so that no faces coincide.
    /// They add no handles either.
    pub fn raised(&self) -> Solid {
        self.between(-INTO_MM, self.depth_mm)
    }

    /// Returns the letters between two heights above the face.
    fn between(&self, low_mm: f64, high_mm: f64) -> Solid {
        let letters = self.font.between(&self.text, low_mm, high_mm);
        letters.expect("checked when the label was made").placed(self.pose).named("label")
    }
}
