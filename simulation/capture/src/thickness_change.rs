//! Change of the layers' thickness with indentation. The layers below are compressed too, so a layer thins by less than
//! the indentation.

use fabkit_depth::ground_truth::SurfaceDisplacement as _;
use fabkit_files::Error;
use fabkit_fixtures::PressBody;
use fabkit_geometry::{Point3, Pose, Sensor, Solid, SurfacePoints, TouchSurface, Vector3};
use fabkit_scene::press_simulation::{ElasticSolver, resources};

use super::layers::LayerScene;
use super::scene::surface_middle;

/// Polar angles of the table on a dome, deg.
const POLAR_DEG: [f64; 8] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
/// Radius of the ball that is pressed in, mm, and its depth as a share of the soft layers' thickness.
pub(super) const BALL_MM: f64 = 2.5;
const DEPTH_SHARE: f64 = 0.4;

/// A point of the undeformed surface with its outward unit normal.
pub(super) type Place = (Point3<f64>, Vector3<f64>);

/// Result of one press of the ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct BallPress {
    /// Polar angle from +z about a dome's centre, deg; 0 in the middle of a pad.
    pub polar_deg: f64,
    pub at: Place,
    /// Loss of thickness per millimetre of indentation.
    pub loss_per_mm: f64,
}

/// Loss of the layers' thickness per millimetre of indentation by an indenter of a fingertip's size, over the surface.
#[derive(Clone, Debug)]
pub struct ThicknessChange {
    /// Presses by ascending polar angle.
    places: Vec<BallPress>,
    /// Centre of the dome; `None` for a pad.
    centre: Option<Point3<f64>>,
}

impl ThicknessChange {
    /// Computes the table from presses of a ball at some places.
    ///
    /// # Errors
    /// Returns an error if the layers cannot be pressed.
    pub fn compute(layers: &LayerScene<'_>, sensor: &Sensor) -> Result<Self, Error> {
        let touch = layers.scene.touch;
        let points = SurfacePoints::new(touch).map_err(Error::bug)?;
        let (places, centre): (Vec<(f64, Place)>, _) = match &points {
            SurfacePoints::Dome(dome) => {
                let place = |deg: f64| Some((deg, dome.point_in_direction(deg.to_radians(), 0.0)?));
                (POLAR_DEG.into_iter().filter_map(place).collect(), Some(dome.centre()))
            }
            SurfacePoints::Plane(_) => {
                (surface_middle(touch).map(|place| (0.0, place)).into_iter().collect(), None)
            }
        };
        // One setup serves all places.
        let ready = ElasticSolver::for_any_press(sensor, None, false, resources())?;
        let pressed = |(polar_deg, at): (f64, Place)| {
            let thins = compute_loss_per_mm(layers, touch, &ready, &at)?;
            Ok(BallPress { polar_deg, at, loss_per_mm: thins })
        };
        let places = places.into_iter().map(pressed).collect::<Result<_, Error>>()?;
        Ok(Self { places, centre })
    }

    pub(super) fn places(&self) -> &[BallPress] {
        &self.places
    }

    /// Returns the loss of thickness per millimetre of indentation at a point, interpolated over the polar angle and
    /// constant beyond the last press.
    pub fn at(&self, point: &Point3<f64>) -> f64 {
        let Some(centre) = self.centre else {
            return self.places.first().map_or(1.0, |p| p.loss_per_mm);
        };
        let deg = (point - centre).angle(&Vector3::z()).to_degrees();
        let after = self.places.partition_point(|place| place.polar_deg < deg);
        let last = self.places.len().saturating_sub(1);
        let [Some(from), Some(to)] =
            [after.saturating_sub(1), after.min(last)].map(|i| self.places.get(i))
        else {
            return 1.0;
        };
        let width = to.polar_deg - from.polar_deg;
        let part = if width > 0.0 { ((deg - from.polar_deg) / width).clamp(0.0, 1.0) } else { 0.0 };
        from.loss_per_mm + part * (to.loss_per_mm - from.loss_per_mm)
    }
}

fn compute_loss_per_mm(
    layers: &LayerScene<'_>,
    touch: &TouchSurface,
    ready: &ElasticSolver,
    (point, outward): &Place,
) -> Result<f64, Error> {
    let depth_mm = DEPTH_SHARE * touch.max_indentation_mm();
    // The ball's lowest point then lies `depth_mm` below the surface.
    let centre = point + (BALL_MM - depth_mm) * outward;
    let ball = PressBody {
        name: "ball".to_owned(),
        solid: Solid::sphere(BALL_MM),
        sensor_from_body: Pose::z_to(*outward, centre),
    };
    let answer = ready.solve_contact(touch, &[ball], [0.0; 2], None)?;
    let outwards_mm = answer.outwards_mm(point, outward);
    let lower = answer.lower_face(layers.scene.innermost());
    let lower_mm = lower.map_or(0.0, |lower| lower.outwards_mm(point));
    // Both displacements are along the normal: the layer loses the surface's minus the lower face's.
    Ok(1.0 - lower_mm / outwards_mm)
}
