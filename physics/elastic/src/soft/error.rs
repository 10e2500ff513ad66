//! Errors of building or pressing a sensor's soft layers.

use fabkit_geometry::InvalidSolid;

use crate::ElasticError;

/// Error of building or pressing a sensor's soft layers.
///
/// ```
/// # use fabkit_geometry::{Angle, NominalCamera, Pose, Sensor};
/// # let camera = NominalCamera {
/// #     sensor_from_camera: Pose::identity(), width_px: 640, height_px: 480,
/// #     field_of_view: Angle::from_deg(90.0).unwrap(), lens: Default::default(),
/// # };
/// use fabkit_elastic::SoftStack;
///
/// // A sensor without bodies.
/// let error = SoftStack::at_tip(&Sensor::new("air", "Air", "", camera, [])).unwrap_err();
/// assert_eq!(error.to_string(), "nothing of known elasticity lies below the surface of air");
/// ```
#[derive(Debug, thiserror::Error)]
pub enum SoftError {
    /// No material of known elasticity below the surface.
    #[error("nothing of known elasticity lies below the surface of {sensor}")]
    NothingSoft {
        /// Name of the sensor.
        sensor: String,
    },
    /// Layers that give way, of materials whose elasticity nobody states.
    #[error(
        "the Young's modulus of {layers} is not known; state `youngs_modulus`, `modulus` or `hardness` of the material \
         below `materials:`"
    )]
    UnknownElasticity {
        /// Names of the layers with their materials.
        layers: String,
    },
    /// Soft layers that nothing rigid holds.
    #[error("nothing stiff holds the soft layers: neither from inside nor at their rim")]
    NotHeld,
    /// Channel that is pressed shut.
    #[error(
        "channel {channel} is pressed shut: its cover would come down by {closes_mm:.3} mm, but the channel is \
         {height_mm} mm high"
    )]
    ChannelClosed {
        /// Name of the channel.
        channel: String,
        /// Approach of the cover to the floor, mm.
        closes_mm: f64,
        /// Height of the channel, mm.
        height_mm: f64,
    },
    /// Invalid solid.
    #[error(transparent)]
    Solid(#[from] InvalidSolid),
    /// Error of the elastic solver.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
}
