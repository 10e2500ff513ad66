//! Central lens models: maps from directions to pixels and back.
//!
//! Every model maps a direction to the *normalised plane*, where a pinhole would have `(x/z, y/z)`, and [`Intrinsics`]
//! map that plane to pixels. Each model has its own file, which knows nothing of pixels.

mod double_sphere;
mod eucm;
mod kannala_brandt;
mod model;
mod opencv;
mod unified;

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

pub use double_sphere::DoubleSphere;
pub use eucm::Eucm;
pub use kannala_brandt::KannalaBrandt;
pub use model::LensModel;
pub use opencv::OpenCv;

use crate::error::{InvalidCamera, OutsideDomain, ViolationCollector};

/// Largest number of coefficients of a model besides its [`Intrinsics`].
pub(crate) const MAX_COEFFICIENTS: usize = 8;

/// Names of the intrinsics, in their order.
pub(crate) const INTRINSICS: [&str; 4] = ["fx_px", "fy_px", "cx_px", "cy_px"];

/// Smallest accepted incidence angle limit, radians. A lens that ends closer to its axis has mistyped coefficients.
const LEAST_ANGLE_LIMIT_RAD: f64 = 0.01;

/// Focal lengths and principal point: `column = fx_px * x + cx_px`, `row = fy_px * y + cy_px`.
///
/// ```
/// use fabkit_camera::{Camera, Interface, Intrinsics, Lens, OpenCv, Point2, Point3};
/// let intrinsics = Intrinsics { fx_px: 500.0, fy_px: 400.0, cx_px: 319.5, cy_px: 239.5 };
/// let pinhole = Lens::OpenCv(OpenCv::new(intrinsics, &[])?);
/// let camera = Camera::new(640, 480, pinhole, Interface::None)?;
/// // x/z = 0.1 and y/z = 0.2; +y is down, towards larger rows.
/// let pixel = camera.project(&Point3::new(1.0, 2.0, 10.0))?;
/// assert!((pixel - Point2::new(319.5 + 50.0, 239.5 + 80.0)).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Columns per unit of the normalised plane.
    pub fx_px: f64,
    /// Rows per unit of the normalised plane.
    pub fy_px: f64,
    /// Column of the optical axis; the first pixel's centre is 0.
    pub cx_px: f64,
    /// Row of the optical axis.
    pub cy_px: f64,
}

impl Intrinsics {
    fn values(&self) -> [f64; 4] {
        [self.fx_px, self.fy_px, self.cx_px, self.cy_px]
    }

    fn from_values(values: &[f64; 4]) -> Self {
        let [fx_px, fy_px, cx_px, cy_px] = *values;
        Self { fx_px, fy_px, cx_px, cy_px }
    }

    fn pixel(&self, normalised: &Vector2<f64>) -> Point2<f64> {
        Point2::new(self.fx_px * normalised.x + self.cx_px, self.fy_px * normalised.y + self.cy_px)
    }

    fn normalised(&self, pixel: &Point2<f64>) -> Vector2<f64> {
        Vector2::new((pixel.x - self.cx_px) / self.fx_px, (pixel.y - self.cy_px) / self.fy_px)
    }
}

/// Point of the normalised plane with its derivatives.
pub(crate) struct Normalised {
    pub at: Vector2<f64>,
    pub by_direction: Matrix2x3<f64>,
    /// Derivative by each coefficient; zero beyond the model's number of coefficients.
    pub by_coefficients: [Vector2<f64>; MAX_COEFFICIENTS],
}

/// Interface of a lens model. Directions need not have unit length, but must not be zero.
pub(crate) trait Projector: Sized {
    /// Name of the model in messages and files.
    const NAME: &'static str;
    /// Name of the model in Kalibr, if Kalibr has it without distortion.
    const KALIBR: Option<&'static str> = None;

    /// Creates a lens from coefficients; missing ones become NaN, which the constructors refuse.
    ///
    /// # Errors
    /// Fails as the model's own constructor.
    fn from_coefficients(
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Result<Self, InvalidCamera>;
    /// Names of the coefficients, in their order.
    fn names(&self) -> &'static [&'static str];
    /// Coefficients of the model, in the order of their names.
    fn coefficients(&self) -> &[f64];
    /// Largest incidence angle, radians, up to which the map is one to one.
    fn limit_rad(&self) -> f64;
    /// Returns whether a direction lies in the domain.
    fn contains(&self, direction: &Vector3<f64>) -> bool;
    /// Maps a direction to the normalised plane. Only for directions inside the domain ([`Projector::contains`]).
    fn normalise(&self, direction: &Vector3<f64>) -> Vector2<f64>;
    /// Computes [`Projector::normalise`] with derivatives. Only for directions inside the domain.
    fn differentiate(&self, direction: &Vector3<f64>) -> Normalised;
    /// Inverts [`Projector::normalise`]. The direction has any length; `None` outside the domain.
    fn direction(&self, normalised: &Vector2<f64>) -> Option<Vector3<f64>>;
}

/// Calls a macro with all lens models. A new model is registered here and in [`LensModel::ALL`].
macro_rules! for_all_models {
    ($then:ident $($more:tt)*) => {
        $then! {
            [
                /// Pinhole with OpenCV's radial and tangential distortion.
                OpenCv
                /// Polynomial in the incidence angle; OpenCV's `fisheye`, Kalibr's `equidistant`.
                KannalaBrandt
                /// Double sphere: projection through two unit spheres.
                DoubleSphere
                /// Extended unified camera model.
                Eucm
            ]
            $($more)*
        }
    };
}

impl LensModel {
    /// All models. Of two that have equally many coefficients and explain the images equally well, the first is chosen:
    /// the EUCM before the double sphere, because its focal length is the scale on the axis, whatever its coefficients
    /// are.
    pub const ALL: [Self; 5] =
        [Self::KannalaBrandt, Self::Eucm, Self::DoubleSphere, Self::OpenCv5, Self::OpenCv8];
}

macro_rules! declare_lens {
    ([$($(#[$doc:meta])+ $model:ident)+]) => {
        /// Lens: map from directions to pixels.
        ///
        /// ```
        /// use fabkit_camera::{Eucm, Intrinsics, Lens};
        /// let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 319.5, cy_px: 239.5 };
        /// let lens = Lens::Eucm(Eucm::new(intrinsics, 0.6, 1.1)?);
        /// assert_eq!(lens.model_name(), "eucm");
        /// assert_eq!(lens.coefficient_names(), ["alpha", "beta"]);
        /// assert_eq!(lens.coefficients(), [0.6, 1.1]);
        /// # Ok::<(), fabkit_camera::InvalidCamera>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Lens {
            $($(#[$doc])+ $model($model),)+
        }

        /// Constructor of a lens from intrinsics and coefficients.
        type Make = fn(Intrinsics, &[f64]) -> Result<Lens, InvalidCamera>;

        /// Constructor of each model by its name.
        const MAKERS: &[(&str, Make)] = &[
            $((
                $model::NAME,
                |intrinsics, k| $model::from_coefficients(intrinsics, k).map(Lens::$model),
            ),)+
        ];
    };
}
for_all_models!(declare_lens);

/// A pixel with its derivatives by direction and by the lens's own parameters.
pub(crate) struct LensProjection {
    pub pixel: Point2<f64>,
    pub by_direction: Matrix2x3<f64>,
    pub by_coefficients: [Vector2<f64>; MAX_COEFFICIENTS],
    pub normalised: Vector2<f64>,
}

/// Calls the model behind a lens without the cost of a virtual call.
macro_rules! with_model {
    ($lens:expr, $model:ident => $answer:expr) => {
        for_all_models!(match_model $lens, $model => $answer)
    };
}

macro_rules! match_model {
    ([$($(#[$doc:meta])+ $kind:ident)+] $lens:expr, $model:ident => $answer:expr) => {
        match $lens {
            $(Lens::$kind($model) => $answer,)+
        }
    };
}

fn name_of<P: Projector>(_: &P) -> &'static str {
    P::NAME
}

fn kalibr_name_of<P: Projector>(_: &P) -> Option<&'static str> {
    P::KALIBR
}

impl Lens {
    /// Focal lengths and principal point.
    pub fn intrinsics(&self) -> Intrinsics {
        with_model!(self, model => model.intrinsics)
    }

    /// Names of the coefficients, in the order of [`Lens::coefficients`].
    pub fn coefficient_names(&self) -> &'static [&'static str] {
        with_model!(self, model => model.names())
    }

    /// Coefficients of the model, without its intrinsics.
    pub fn coefficients(&self) -> &[f64] {
        with_model!(self, model => model.coefficients())
    }

    /// Largest incidence angle, radians, up to which directions and pixels determine each other. Computed when the lens
    /// is created.
    ///
    /// ```
    /// use fabkit_camera::{Intrinsics, Lens, OpenCv};
    /// let intrinsics = Intrinsics { fx_px: 286.0, fy_px: 286.0, cx_px: 319.5, cy_px: 239.5 };
    /// let k1 = -1.0 / 3.0;
    /// let lens = Lens::OpenCv(OpenCv::new(intrinsics, &[k1, 0.0, 0.0, 0.0])?);
    /// // r + k1 r^3 ceases to grow at r = tan(theta) = 1: farther out the image folds back.
    /// assert!((lens.angle_limit_rad().to_degrees() - 45.0).abs() < 1e-6);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    pub fn angle_limit_rad(&self) -> f64 {
        with_model!(self, model => model.limit_rad())
    }

    /// Name of the model in messages and files.
    pub fn model_name(&self) -> &'static str {
        with_model!(self, model => name_of(model))
    }

    /// Name of the model in Kalibr, if Kalibr has it without distortion.
    pub(crate) fn kalibr_name(&self) -> Option<&'static str> {
        with_model!(self, model => kalibr_name_of(model))
    }

    /// Creates a lens of the model with this name; `None` if no model has the name.
    pub(crate) fn from_model_name(
        name: &str,
        intrinsics: Intrinsics,
        coefficients: &[f64],
    ) -> Option<Result<Self, InvalidCamera>> {
        let maker = MAKERS.iter().find(|(known, _)| *known == name);
        maker.map(|(_, make)| make(intrinsics, coefficients))
    }

    /// Returns the same model with other parameter values: intrinsics first, then the coefficients.
    pub(crate) fn with_parameters(&self, parameters: &[f64]) -> Result<Self, InvalidCamera> {
        let mut first = [f64::NAN; 4];
        // Too few values become NaN, so that the constructor reports them.
        let split = parameters.len().min(4);
        first[..split].copy_from_slice(&parameters[..split]);
        let (intrinsics, rest) = (Intrinsics::from_values(&first), &parameters[split..]);
        Self::from_model_name(self.model_name(), intrinsics, rest).expect("its own model is known")
    }

    /// Returns names and values of all parameters, intrinsics first.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let coefficients = self.coefficient_names().iter().zip(self.coefficients());
        let intrinsics = INTRINSICS.into_iter().zip(self.intrinsics().values());
        intrinsics.chain(coefficients.map(|(name, value)| (*name, *value)))
    }

    /// Projects a direction, of any length but zero, to a pixel.
    #[inline]
    pub(crate) fn project(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, OutsideDomain> {
        with_model!(self, model => {
            if !model.contains(direction) {
                return Err(outside(direction, model.limit_rad()));
            }
            let pixel = model.intrinsics.pixel(&model.normalise(direction));
            // `x / inf` is 0: a direction at infinite z would pass for the axis.
            if !is_finite(&pixel) || direction.z.is_infinite() {
                return Err(OutsideDomain::NoDirection);
            }
            Ok(pixel)
        })
    }

    /// Computes [`Lens::project`] with derivatives by the direction and by the coefficients.
    pub(crate) fn differentiate(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<LensProjection, OutsideDomain> {
        with_model!(self, model => {
            if !model.contains(direction) {
                return Err(outside(direction, model.limit_rad()));
            }
            let Normalised { at, mut by_direction, mut by_coefficients } =
                model.differentiate(direction);
            let scale = Vector2::new(model.intrinsics.fx_px, model.intrinsics.fy_px);
            // From the normalised plane to pixels.
            by_direction.column_iter_mut().for_each(|mut c| c.component_mul_assign(&scale));
            by_coefficients.iter_mut().for_each(|c| c.component_mul_assign(&scale));
            let pixel = model.intrinsics.pixel(&at);
            if !is_finite(&pixel) || direction.z.is_infinite() {
                return Err(OutsideDomain::NoDirection);
            }
            Ok(LensProjection { pixel, by_direction, by_coefficients, normalised: at })
        })
    }

    /// Computes the unit direction in front of the lens that projects to a pixel.
    #[inline]
    pub(crate) fn unproject(&self, pixel: &Point2<f64>) -> Result<Vector3<f64>, OutsideDomain> {
        if !is_finite(pixel) {
            return Err(OutsideDomain::NoDirection);
        }
        with_model!(self, model => {
            let direction = model.direction(&model.intrinsics.normalised(pixel));
            let unit = direction.map(|d| d.normalize());
            // At pixels so far out that their squares overflow, the direction is not finite.
            unit.filter(|d| d.x.is_finite() && d.y.is_finite() && d.z.is_finite()).ok_or(
                OutsideDomain::Pixel {
                    x_px: pixel.x,
                    y_px: pixel.y,
                    limit_rad: model.limit_rad(),
                },
            )
        })
    }
}

/// Returns whether a pixel is finite. It is not if coordinates are not, or if their squares overflow or vanish.
fn is_finite(pixel: &Point2<f64>) -> bool {
    pixel.x.is_finite() && pixel.y.is_finite()
}

/// Returns the error of a direction outside the domain.
#[cold]
fn outside(direction: &Vector3<f64>, limit_rad: f64) -> OutsideDomain {
    let across = direction.x.hypot(direction.y);
    // An error of its own: such a direction has no angle.
    if !(across.is_finite() && direction.z.is_finite()) || (across == 0.0 && direction.z == 0.0) {
        return OutsideDomain::NoDirection;
    }
    OutsideDomain::Angle { angle_rad: across.atan2(direction.z), limit_rad }
}

/// Returns the first `N` values of a slice. Missing ones become NaN, which every constructor refuses.
fn array<const N: usize>(values: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| values.get(i).copied().unwrap_or(f64::NAN))
}

/// Checks the parameters that every lens must have before its domain can be computed.
fn check(
    intrinsics: &Intrinsics,
    names: &[&'static str],
    coefficients: &[f64],
) -> ViolationCollector {
    /// Largest focal length and distance of the principal point, px: more than any camera of 64 Mpx has.
    const MOST_PX: f64 = 1e6;
    let mut rules = ViolationCollector::default();
    rules.above("fx_px", intrinsics.fx_px, 0.0, MOST_PX);
    rules.above("fy_px", intrinsics.fy_px, 0.0, MOST_PX);
    rules.within("cx_px", intrinsics.cx_px, -MOST_PX, MOST_PX);
    rules.within("cy_px", intrinsics.cy_px, -MOST_PX, MOST_PX);
    for (name, value) in names.iter().zip(coefficients) {
        rules.within(name, *value, -1e6, 1e6);
    }
    rules
}

/// Refuses a lens with a domain below [`LEAST_ANGLE_LIMIT_RAD`], naming its first coefficient.
fn check_limit(
    first_coefficient: (&'static str, f64),
    limit_rad: f64,
) -> Result<(), InvalidCamera> {
    let mut rules = ViolationCollector::default();
    let (field, value) = first_coefficient;
    rules.require(
        limit_rad >= LEAST_ANGLE_LIMIT_RAD,
        field,
        value,
        format!(
            "with these coefficients the image folds back on itself {:.4} degrees off the axis; \
             at least {:.2} are needed",
            limit_rad.to_degrees(),
            LEAST_ANGLE_LIMIT_RAD.to_degrees()
        ),
    );
    rules.finish()
}
