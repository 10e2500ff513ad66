//! Values of `fabkit export --robot`.

use clap::ValueEnum;
use fabkit_application::robots::RobotFormat;

/// A robot description format.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RobotArg {
    /// ROS, PyBullet, SAPIEN
    Urdf,
    /// MuJoCo, with a tactile sensor
    Mjcf,
    /// Gazebo
    Sdf,
    /// Isaac Sim, with configurations for TacSL and TacEx
    Usd,
    /// Drake, with tetrahedra of the soft layers
    Drake,
    /// TACTO's renderer
    Tacto,
}

impl RobotArg {
    /// Returns the application's format.
    pub fn format(self) -> RobotFormat {
        match self {
            Self::Urdf => RobotFormat::Urdf,
            Self::Mjcf => RobotFormat::Mjcf,
            Self::Sdf => RobotFormat::Sdf,
            Self::Usd => RobotFormat::Usd,
            Self::Drake => RobotFormat::Drake,
            Self::Tacto => RobotFormat::Tacto,
        }
    }
}
