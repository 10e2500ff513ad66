//! Registered lens models by name and number of coefficients, for files and for the choice of a model.

use super::{Intrinsics, Lens};

/// Lens model with a fixed set of coefficients. Each is declared in the file of its model.
///
/// ```
/// use fabkit_camera::LensModel;
/// let names = LensModel::ALL.map(LensModel::name);
/// assert_eq!(names, ["kannala-brandt", "eucm", "double-sphere", "opencv-5", "opencv-8"]);
/// let model = LensModel::from_name("opencv-8").unwrap();
/// assert_eq!((model, model.parameter_count()), (LensModel::OpenCv8, 4 + 8));
/// assert_eq!(LensModel::from_name("fisheye"), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensModel {
    /// Name on the command line.
    pub(super) name: &'static str,
    /// Name of the model itself, shared by variants with other numbers of coefficients.
    pub(super) family: &'static str,
    /// Names of the coefficients, in their order.
    pub(super) coefficients: &'static [&'static str],
    /// Coefficients of a lens without distortion near its axis, as start values.
    pub(super) start_coefficients: &'static [f64],
}

impl LensModel {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Finds the model with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name == name)
    }

    /// Number of unknowns in a calibration: focal lengths, centre and coefficients.
    pub fn parameter_count(self) -> usize {
        4 + self.coefficients.len()
    }

    /// Creates a lens of this model without distortion near its axis; `None` for impossible intrinsics.
    ///
    /// ```
    /// use fabkit_camera::{Camera, Interface, Intrinsics, LensModel, Point3};
    /// let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 319.5, cy_px: 239.5 };
    /// for model in LensModel::ALL {
    ///     let lens = model.start_lens(intrinsics).unwrap();
    ///     let camera = Camera::new(640, 480, lens, Interface::None)?;
    ///     // A hundredth of a radian off the axis all models agree.
    ///     assert!((camera.project(&Point3::new(0.1, 0.0, 10.0))?.x - (319.5 + 2.86)).abs() < 1e-3);
    /// }
    /// assert!(LensModel::Eucm.start_lens(Intrinsics { fx_px: 0.0, ..intrinsics }).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn start_lens(self, intrinsics: Intrinsics) -> Option<Lens> {
        Lens::from_model_name(self.family, intrinsics, self.start_coefficients)?.ok()
    }

    /// Names of all models in files, those with the most coefficients first.
    pub(crate) fn file_names() -> Vec<&'static str> {
        let mut models = Self::ALL;
        models.sort_by_key(|model| (usize::MAX - model.coefficients.len(), model.family));
        let mut names: Vec<_> = models.iter().map(|model| model.family).collect();
        names.dedup();
        names
    }

    /// Returns the coefficient names that a file must give for this model: of its variants, the one with the most
    /// coefficients whose first additional one is given.
    pub(crate) fn coefficients_in_file(
        name: &str,
        is_given: impl Fn(&str) -> bool,
    ) -> Option<&'static [&'static str]> {
        let mut counts: Vec<_> = Self::ALL.iter().filter(|model| model.family == name).collect();
        counts.sort_by_key(|model| model.coefficients.len());
        let coefficients = counts.iter().map(|model| model.coefficients);
        // Variants of a model share their first coefficients.
        coefficients.reduce(|fewer, more| if is_given(more[fewer.len()]) { more } else { fewer })
    }
}
