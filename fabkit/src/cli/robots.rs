//! What `fabkit export --robot` may name.

use clap::ValueEnum;
use fabkit_application::robots::RobotFormat;

/// A kind of description of robots.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RobotArg {
    /// ROS, PyBullet, TACTO, Drake, SAPIEN
    Urdf,
    /// MuJoCo, with a tactile sensor
    Mjcf,
    /// Gazebo, Drake
    Sdf,
}

impl RobotArg {
    /// What it stands for.
    pub fn format(self) -> RobotFormat {
        match self {
            Self::Urdf => RobotFormat::Urdf,
            Self::Mjcf => RobotFormat::Mjcf,
            Self::Sdf => RobotFormat::Sdf,
        }
    }
}
