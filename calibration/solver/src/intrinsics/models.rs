//! The lens models among which the pictures choose.

use fabkit_camera::{
    Camera, DoubleSphere, Eucm, Interface, Intrinsics, KannalaBrandt, Lens, OpenCv, Point3,
};
use nalgebra::{DMatrix, DVector};

use crate::information::ScaledCholesky;

/// A lens model with its coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensModel {
    /// Kannala and Brandt's polynomial in the angle, `k1` to `k4`; OpenCV's `fisheye`.
    KannalaBrandt,
    /// The double sphere: 2 coefficients.
    DoubleSphere,
    /// The extended unified camera model: 2 coefficients.
    Eucm,
    /// OpenCV's `k1 k2 p1 p2 k3`.
    OpenCv5,
    /// OpenCV's rational model, `k1 k2 p1 p2 k3 k4 k5 k6`.
    OpenCv8,
}

impl LensModel {
    /// All models. Of two that are as simple and explain the pictures equally well the first is
    /// taken: the EUCM before the double sphere, because its focal length is the scale on the axis
    /// whatever its coefficients are.
    pub const ALL: [Self; 5] =
        [Self::KannalaBrandt, Self::Eucm, Self::DoubleSphere, Self::OpenCv5, Self::OpenCv8];

    /// As the command calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::KannalaBrandt => "kannala-brandt",
            Self::DoubleSphere => "double-sphere",
            Self::Eucm => "eucm",
            Self::OpenCv5 => "opencv-5",
            Self::OpenCv8 => "opencv-8",
        }
    }

    /// The model of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }

    /// Numbers to be found: focal lengths, centre and coefficients.
    pub fn parameter_count(self) -> usize {
        4 + match self {
            Self::KannalaBrandt => 4,
            Self::DoubleSphere | Self::Eucm => 2,
            Self::OpenCv5 => 5,
            Self::OpenCv8 => 8,
        }
    }

    /// A lens of this model that is a plain one near its axis.
    fn plain(self, intrinsics: Intrinsics) -> Option<Lens> {
        let lens = match self {
            Self::KannalaBrandt => {
                Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, [0.0; 4]).ok()?)
            }
            Self::DoubleSphere => {
                Lens::DoubleSphere(DoubleSphere::new(intrinsics, 0.0, 0.55).ok()?)
            }
            Self::Eucm => Lens::Eucm(Eucm::new(intrinsics, 0.55, 1.0).ok()?),
            Self::OpenCv5 => Lens::OpenCv(OpenCv::new(intrinsics, &[0.0; 5]).ok()?),
            Self::OpenCv8 => Lens::OpenCv(OpenCv::new(intrinsics, &[0.0; 8]).ok()?),
        };
        Some(lens)
    }

    /// The camera of this model that maps directions up to `angle_rad` off the axis most like
    /// another, to start from. `None` if the model cannot see that far.
    ///
    /// The fit begins with the innermost directions and goes outwards: a plain lens is right near
    /// its axis, and wrong beyond what the model can take in one step.
    pub(super) fn like(self, other: &Camera, angle_rad: f64) -> Option<Camera> {
        let (width_px, height_px) = (other.width_px(), other.height_px());
        let lens = self.plain(other.lens().intrinsics())?;
        let mut camera = Camera::new(width_px, height_px, lens, Interface::None).ok()?;
        for part in 1..=PARTS {
            let limit_rad = angle_rad * f64::from(part) / f64::from(PARTS);
            camera = closest(camera, other, limit_rad)?;
        }
        Some(camera)
    }
}

const PARTS: u32 = 12;
const RINGS: u32 = 24;
const SPOKES: u32 = 8;
const ITERATIONS: usize = 15;

/// Least squares on the pixels of a fan of directions.
fn closest(start: Camera, other: &Camera, limit_rad: f64) -> Option<Camera> {
    let mut fan = Vec::new();
    for ring in 0..RINGS {
        let (s, c) = (limit_rad * f64::from(ring + 1) / f64::from(RINGS)).sin_cos();
        for spoke in 0..SPOKES {
            let turn = std::f64::consts::TAU * f64::from(spoke) / f64::from(SPOKES);
            let direction = Point3::new(s * turn.cos(), s * turn.sin(), c);
            fan.push((direction, other.project(&direction).ok()?));
        }
    }
    let build = |camera: &Camera| {
        let n = camera.parameter_count();
        let (mut cost, mut normal, mut gradient) = (0.0, DMatrix::zeros(n, n), DVector::zeros(n));
        for (direction, pixel) in &fan {
            let projected = camera.project_with_jacobians(direction).ok()?;
            let residual = pixel - projected.pixel;
            cost += residual.norm_squared();
            for (i, by_i) in projected.by_parameters.iter().enumerate() {
                gradient[i] += by_i.dot(&residual);
                for (j, by_j) in projected.by_parameters.iter().enumerate() {
                    normal[(i, j)] += by_i.dot(by_j);
                }
            }
        }
        Some((cost, normal, gradient))
    };
    let mut camera = start;
    let (mut cost, mut normal, mut gradient) = build(&camera)?;
    let mut damping = 1e-6;
    for _ in 0..ITERATIONS {
        let step = ScaledCholesky::damped(&normal, damping)?.solve(&gradient);
        let values = camera.parameters();
        let values: Vec<f64> = values.iter().zip(step.iter()).map(|((_, v), s)| v + s).collect();
        let tried = camera.with_parameters(&values).ok();
        match tried.and_then(|tried| Some((tried, build(&tried)?))) {
            Some((tried, next)) if next.0 <= cost => {
                camera = tried;
                (cost, normal, gradient) = next;
                damping = (damping * 0.1).max(1e-9);
            }
            _ => damping *= 10.0,
        }
    }
    Some(camera)
}
