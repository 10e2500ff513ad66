//! What the design draws between lens and pins, for the solver.

use fabkit_calibration::drawn::DrawnInterface;
use fabkit_calibration::model::Displacements;
use fabkit_camera::Camera;
use fabkit_geometry::{Point3, Pose, Sensor};
use fabkit_optics::{InvalidStack, Sights, Stack, Window};

/// The bodies before a lens.
#[derive(Debug)]
pub struct DrawnBodies {
    sights: Sights,
    window: Window,
    nominal: Pose,
}

impl DrawnBodies {
    /// Those of a sensor, with the lens of a camera where the design puts it.
    ///
    /// # Errors
    /// Bodies that no light can be followed through.
    pub fn of(sensor: &Sensor, camera: &Camera) -> Result<Self, InvalidStack> {
        let sights = Sights::new(Stack::of(sensor)?);
        let sensor_from_camera = &sensor.camera.sensor_from_camera;
        let window = Window::of(&camera.in_air(), sensor_from_camera, &sights);
        Ok(Self { sights, window, nominal: sensor_from_camera.inverse() })
    }

    /// The interface that light passes first, if a solver can have it.
    pub fn interface(&self) -> Option<DrawnInterface> {
        let Window::One { interface, .. } = &self.window else { return None };
        DrawnInterface::new(interface, &self.nominal)
    }

    /// Why there is none, as a sentence.
    pub fn why_not(&self) -> Option<&'static str> {
        match &self.window {
            Window::One { .. } => None,
            Window::Blind => Some(
                "The camera sees nothing of a sensing surface through the drawn bodies, which took no part: the \
                 interface is what the pixels say.",
            ),
            Window::Other => Some(
                "The drawn bodies bend light first at faces that are no plane, pane or sphere; they took no part: \
                 the interface is what the pixels say.",
            ),
        }
    }

    /// How far from where they are contacts seem to be behind that interface, sensor frame, mm.
    pub fn displacements(
        &self,
        camera_from_sensor: &Pose,
        contacts: &[Point3<f64>],
    ) -> Displacements {
        let Window::One { again: true, .. } = self.window else { return Displacements::default() };
        let pupil = camera_from_sensor.inverse().point(Point3::origin());
        let mut seeker = self.sights.seeker();
        Displacements::new(contacts.iter().filter_map(|place| {
            Some((*place, self.window.displacement(&pupil, place, &mut seeker)?))
        }))
    }
}
