//! Bodies that several tests press.

use fabkit_elastic::{
    BallIndenter, BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack, LayeredBody,
    MeridianCurve, MeshDensity, Press, PressOutcome,
};
use fabkit_geometry::{Point3, Vector3};

pub fn layer(young_mpa: f64, poisson: f64) -> ElasticLayer {
    let material = ElasticMaterial::new(young_mpa, poisson).expect("a material");
    ElasticLayer { name: format!("{young_mpa} MPa"), material }
}

pub fn down() -> Vector3<f64> {
    -Vector3::z()
}

/// A ball high above a point.
pub fn ball_over(x_mm: f64, y_mm: f64, radius_mm: f64) -> BallIndenter {
    BallIndenter::new(Point3::new(x_mm, y_mm, radius_mm + 50.0), radius_mm).expect("a ball")
}

pub fn press_down(stack: &ElasticStack, radius_mm: f64, depth_mm: f64) -> PressOutcome {
    let press = Press::along(down(), depth_mm).expect("a press");
    stack.press(&ball_over(0.0, 0.0, radius_mm), &press).expect("an outcome")
}

/// A soft gel on a stiffer one, each 1.5 mm, as in domes.
pub fn two_layers() -> LayeredBody {
    LayeredBody::pad(12.0, vec![(layer(0.07, 0.495), 1.5), (layer(1.7, 0.495), 1.5)])
}

/// A layer 3 mm thick on a rigid ball of 9 mm, up to 75 degrees from the tip; its rim is bonded.
pub fn round_layer(poisson: f64) -> LayeredBody {
    let arc = |radius_mm: f64| {
        MeridianCurve::new(move |s| {
            let angle = s * 75_f64.to_radians();
            [radius_mm * angle.sin(), radius_mm * angle.cos()]
        })
    };
    LayeredBody {
        interfaces: vec![arc(12.0), arc(9.0)],
        layers: vec![layer(0.2, poisson)],
        inner: BoundaryCondition::Bonded,
        is_rim_bonded: true,
        kinks: Vec::new(),
    }
}

pub fn stack(body: &LayeredBody, division: MeshDensity) -> ElasticStack {
    ElasticStack::new(body, &division, 2).expect("a stack")
}
