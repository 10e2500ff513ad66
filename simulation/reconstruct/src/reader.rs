//! All that pictures of one sensor show: depth, where its light or a network tells it, and marks, where there are any.

use std::path::Path;

use fabkit_capture::{LightConstants, Taken};
use fabkit_files::Error;
use fabkit_geometry::{Lighting, Sensor};
use fabkit_scene::SensorView;
use fabkit_scene::ground_truth::Viewpoint;

use super::{
    DepthNetwork, Followed, MarkFollower, ReconstructError, Reconstructed, Reconstructor,
    hides_marks, npz_of, shows_depth,
};

/// Knows a sensor at rest, and reads what presses it from pictures.
#[derive(Debug)]
pub struct PictureReader {
    size_px: [usize; 2],
    depth: Option<Reconstructor>,
    /// What the camera sees, where depth is read.
    pub scene: Option<SensorView>,
    /// What follows the marks, if there are any.
    pub marks: Option<MarkFollower>,
    /// What pictures do not show, and why.
    pub left_out: Vec<String>,
}

/// What a picture shows.
#[derive(Debug)]
pub struct PictureRead {
    /// Depth, where it is read.
    pub shown: Option<Reconstructed>,
    /// Marks, where they are followed.
    pub followed: Option<Followed>,
}

/// How many pictures one core reads in a second, decoding apart.
#[derive(Clone, Copy, Debug)]
pub struct ReadingRates {
    /// Whatever is read of them.
    pub pictures_per_s: f64,
    /// Only their marks.
    pub marks_per_s: Option<f64>,
}

impl PictureReader {
    /// From the picture at rest; depth by a network, if there is one, of the sensor as `view` shows it.
    ///
    /// # Errors
    /// Light that shows neither depth nor marks, and as for [`Reconstructor::new`] and [`MarkFollower::new`].
    pub fn new(
        (sensor, viewpoint): (&Sensor, &Viewpoint),
        view: impl FnOnce() -> Result<SensorView, Error>,
        (lighting, constants): (&Lighting, &LightConstants),
        network: Option<&DepthNetwork>,
        reference: (&Path, &Taken),
    ) -> Result<Self, Error> {
        let camera = viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()].map(|px| px as usize);
        let mut left_out = Vec::new();
        let (mut depth, mut scene) = (None, None);
        if network.is_some() || shows_depth(lighting) || hides_marks(sensor, lighting).is_some() {
            let view = view()?;
            depth = Some(match network {
                Some(network) => Reconstructor::with_network(&view, network, reference)?,
                None => Reconstructor::new(&view, lighting, constants, reference)?,
            });
            scene = Some(view);
        } else {
            let (sensor, light) = (sensor.name.clone(), lighting.name);
            left_out.push(ReconstructError::OtherLight { sensor, light }.to_string());
        }
        let marks = match MarkFollower::new(sensor, viewpoint, lighting, reference) {
            Ok(marks) => Some(marks),
            // Depth needs none, and a picture without marks still shows it.
            Err(error) if depth.is_some() => match error.downcast_ref() {
                Some(few @ ReconstructError::FewMarks { .. }) => {
                    left_out.push(format!("{few}: they are not followed"));
                    None
                }
                Some(none @ ReconstructError::NoMarks { .. }) => {
                    left_out.push(none.to_string());
                    None
                }
                _ => return Err(error),
            },
            Err(error) => return Err(error),
        };
        Ok(Self { size_px, depth, scene, marks, left_out })
    }

    /// Width and height of pictures, px.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// What a picture shows, which came from `file`.
    ///
    /// # Errors
    /// A picture of another size, or without colours where they are needed.
    pub fn read(&self, file: &Path, picture: Taken) -> Result<PictureRead, Error> {
        let followed = self.marks.as_ref().map(|marks| marks.follow(file, &picture)).transpose()?;
        let shown =
            self.depth.as_ref().map(|depth| depth.reconstruct(file, picture)).transpose()?;
        Ok(PictureRead { shown, followed })
    }

    /// For `numpy.load`: as [`npz_of`].
    ///
    /// # Errors
    /// Arrays that are larger than their file can be.
    pub fn npz(&self, read: &PictureRead) -> Result<Vec<u8>, Error> {
        let of_marks = self.marks.as_ref().zip(read.followed.as_ref());
        let arrays = of_marks.map_or_else(Vec::new, |(marks, followed)| marks.arrays(followed));
        npz_of(self.size_px, read.shown.as_ref(), arrays)
    }

    /// How far the mark goes that goes farthest, px.
    pub fn farthest_px(&self, read: &PictureRead) -> Option<f64> {
        let (marks, followed) = self.marks.as_ref().zip(read.followed.as_ref())?;
        let moved = marks.moved_px(followed).into_iter().flatten();
        Some(moved.map(|[x, y]| x.hypot(y)).fold(0.0, f64::max))
    }

    /// How fast pictures like this one are read.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn rates(&self, file: &Path, picture: &Taken) -> Result<ReadingRates, Error> {
        let of_depth = self.depth.as_ref().map(|depth| depth.pictures_per_s(file, picture));
        let of_marks = self.marks.as_ref().map(|marks| marks.pictures_per_s(file, picture));
        let (of_depth, marks_per_s) = (of_depth.transpose()?, of_marks.transpose()?);
        let rates = [of_depth, marks_per_s].into_iter().flatten();
        Ok(ReadingRates { pictures_per_s: rates.map(f64::recip).sum::<f64>().recip(), marks_per_s })
    }
}

impl PictureRead {
    /// Pixels that see what presses, where depth is read.
    pub fn contact_px(&self) -> Option<usize> {
        let shown = self.shown.as_ref()?;
        Some(shown.contact.iter().filter(|contact| **contact).count())
    }
}
