//! What `fabkit export --robot` may name.

use clap::ValueEnum;
use fabkit_application::robots::RobotFormat;

/// A kind of description of robots.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RobotArg {
    /// ROS, PyBullet, SAPIEN
    Urdf,
    /// MuJoCo, with a tactile sensor
    Mjcf,
    /// Gazebo
    Sdf,
    /// Isaac Sim, and configurations for TacSL and TacEx
    Usd,
    /// Drake, with what gives way as tetrahedra
    Drake,
    /// TACTO's renderer
    Tacto,
}

impl RobotArg {
    /// What it stands for.
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
