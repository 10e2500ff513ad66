//! Markers followed from image to image.

use std::path::Path;
use std::sync::Arc;

use fabkit_application::capturing::plausibility::{ExpectedLight, ImageGate};
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::scene::SceneError;
use fabkit_application::{capturing, reconstructing};
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::design::Project;
use crate::errors::{Failure, OrRaise};
use crate::running::run_short;
use crate::scene::{Scene, array_image, decide};

/// Follower of markers, see [`reconstructing::MarkFollower`].
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct MarkFollower {
    gate: Arc<ImageGate>,
    force: bool,
    known: Arc<reconstructing::MarkerTracker>,
}

#[pymethods]
impl MarkFollower {
    /// Makes a follower from the image at rest, values from 0 to 1, rows x columns x channels. The camera is the
    /// scene's, or else the one drawn for this light, resized to the image.
    #[new]
    fn new(
        py: Python<'_>,
        project: &Project,
        scene: Option<&Scene>,
        light: Option<String>,
        reference: PyReadonlyArray3<'_, f32>,
        force: bool,
    ) -> PyResult<Self> {
        let project = Arc::clone(&project.project);
        let given = scene.map(|scene| scene.scene.viewpoint.clone());
        let (height, width) = (reference.shape()[0], reference.shape()[1]);
        let size_px = [width, height].map(|px| u32::try_from(px).unwrap_or(u32::MAX));
        let reference = array_image(&reference);
        let known = run_short(py, move || {
            let drawn = &project.design.sensor;
            let lighting = capturing::find_lighting(drawn, light.as_deref())
                .map_err(fabkit_application::Error::from)?;
            let wrong = |error| SceneError::viewpoint(None, error);
            let viewpoint = match given {
                Some(given) => given,
                None => {
                    let camera = lighting.camera.as_ref().unwrap_or(&drawn.camera);
                    Viewpoint::new(camera, None, None).map_err(wrong)?
                }
            };
            let viewpoint = viewpoint.resized(size_px).map_err(wrong)?;
            let expected = ExpectedLight::from_markers([width, height]);
            let gate = decide(ImageGate::new(expected, Path::new("reference"), reference)?, force)?;
            let rest = gate.reference();
            let known = reconstructing::MarkerTracker::new(drawn, &viewpoint, lighting, rest)?;
            Ok::<_, Failure>((gate, known))
        })?;
        let (gate, known) = known.or_raise(py)?;
        Ok(Self { gate: Arc::new(gate), force, known: Arc::new(known) })
    }

    fn names(&self) -> Vec<String> {
        self.known.names().to_vec()
    }

    /// Follows the markers in an image: the marker arrays that `fabkit reconstruct` writes, by name.
    fn follow<'py>(
        &self,
        py: Python<'py>,
        picture: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let picture = array_image(&picture);
        let (known, gate) = (Arc::clone(&self.known), Arc::clone(&self.gate));
        let force = self.force;
        let found = run_short(py, move || {
            let picture = decide(gate.check(Path::new("picture"), picture)?, force)?;
            let followed = known.follow(&picture)?;
            Ok::<_, Failure>(known.arrays(&followed))
        })?;
        arrays::dictionary(py, found.or_raise(py)?)
    }
}
