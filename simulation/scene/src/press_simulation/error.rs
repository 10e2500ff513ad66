//! Errors of presses on soft layers.

use fabkit_elastic::{ElasticError, SoftError};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_fixtures::PressError;

/// Reason why a press has no result.
#[derive(Debug, thiserror::Error)]
pub enum PressingError {
    /// A sensor without layers that can be pressed.
    #[error(transparent)]
    Soft(SoftError),
    /// An unknown or unreadable press.
    #[error(transparent)]
    Press(#[from] PressError),
    /// An error of the elastic solver.
    #[error(transparent)]
    Elastic(ElasticError),
    /// A displacement along a surface of unknown friction.
    #[error("the friction of {material} is not known")]
    NoFriction {
        /// Name of the material.
        material: String,
    },
    /// A press that the solver for large strain does not support.
    #[error("a press at large strain {what}")]
    Finite {
        /// Restriction that the press violates, as the end of the message.
        what: &'static str,
    },
    /// Contact options that contradict each other.
    #[error("{problem}")]
    Contact {
        /// Description of the contradiction.
        problem: String,
    },
    /// A displacement along the surface with a contact model that is not elastic.
    #[error("shear needs elastic contact, not `{contact}`")]
    RigidShear {
        /// Requested contact model.
        contact: &'static str,
    },
    /// A number or length outside its limits.
    #[error("{what}: {value}; {limit}")]
    Range {
        /// Name of the quantity.
        what: &'static str,
        /// Requested value with its unit.
        value: String,
        /// Allowed range.
        limit: String,
    },
}

impl Explained for PressingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Elastic(
                ElasticError::NoConvergence { .. } | ElasticError::Factorisation { .. },
            ) => ErrorKind::Limit,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Soft(SoftError::NothingSoft { .. }) => {
                "write `youngs_modulus: 70 kPa` for its material in a file of `materials:`"
            }
            Self::Finite { .. } => "ask for `linear` contact, or press at `@0deg,0deg`",
            Self::RigidShear { .. } => "ask for `linear` contact",
            Self::NoFriction { .. } => {
                "write `friction: 1.0` for it in a file of `materials:`, or say how much for this press"
            }
            Self::Soft(SoftError::ChannelClosed { .. }) => "press less deep, or beside the channel",
            Self::Elastic(ElasticError::TooFine { .. }) => "let nodes be further apart",
            Self::Soft(SoftError::NotHeld) => "let the layers stick to a plate or a shell",
            Self::Elastic(ElasticError::NoConvergence { .. }) => {
                "press less deep, or with nodes further apart"
            }
            _ => return None,
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::Press(_) => "unknown_press",
            Self::Range { .. }
            | Self::NoFriction { .. }
            | Self::Contact { .. }
            | Self::Finite { .. }
            | Self::RigidShear { .. } => "out_of_range",
            Self::Elastic(_) => "no_contact_solution",
            Self::Soft(_) => "nothing_soft",
        })
    }
}

/// Depth at which a ball of 4 mm is first noticed by nodes 1 mm apart, mm.
const FIRST_TOUCH_MM: f64 = 0.05;

impl PressingError {
    /// Returns whether the error is that nothing touches the surface.
    ///
    /// ```
    /// use fabkit_geometry::Pose;
    /// use fabkit_scene::press_simulation::ElasticSolver;
    ///
    /// # let yaml = fabkit_designs::builtin_yaml("gelsight-like").ok_or("no such sensor")?;
    /// # let project = fabkit_fixtures::load("gelsight-like.yaml", yaml, &[])?;
    /// let sensor = &project.design.sensor;
    /// let touch = sensor.touch.as_ref().ok_or("no surface")?;
    /// let mut bodies = project.press("ball@0mm,0mm,0.3mm")?.bodies;
    /// let solver = ElasticSolver::for_press(sensor, &bodies, Some(1.0), 1.into())?;
    /// bodies[0].sensor_from_body = Pose::translation(0.0, 0.0, 5.0).then_in(bodies[0].sensor_from_body);
    /// assert!(solver.solve_contact(touch, &bodies, [0.0; 2], None).is_err_and(|error| error.is_no_contact()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_no_contact(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::NoContact { .. }))
    }

    /// Returns whether contact is so shallow that it lies between the surface's nodes: the first touch of a smooth
    /// body.
    pub fn is_first_touch(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::TooCoarse { depth_mm, .. }) if *depth_mm < FIRST_TOUCH_MM)
    }

    /// Returns whether the contact lies between the surface's nodes.
    pub fn is_too_coarse(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::TooCoarse { .. }))
    }
}

impl From<ElasticError> for PressingError {
    fn from(error: ElasticError) -> Self {
        Self::Elastic(error)
    }
}

impl From<SoftError> for PressingError {
    fn from(error: SoftError) -> Self {
        match error {
            SoftError::Elastic(error) => Self::Elastic(error),
            other => Self::Soft(other),
        }
    }
}
