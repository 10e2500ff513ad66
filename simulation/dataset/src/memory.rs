//! Memory of a data set, estimated from measurements of each step.

use fabkit_files::memory::{self, MemoryError, MemoryGrant, MemoryHint};
use fabkit_scene::press_simulation::ContactModel;
use fabkit_scene::{REFRACTION_BYTES, SensorView};

use super::DatasetRequest;

/// Memory shared by all workers, bytes per pixel: rays, the surface, the seam, and the reference with the file made of
/// it.
const SHARED_BYTES: u64 = 24 + 24 + 1 + 8 + 1 + 150;
/// Memory of a worker, bytes per pixel: its file of halves, one of them being cast, and all of them packed.
const WORKER_BYTES: u64 = 150;
/// Additional memory of a worker with a membrane around contacts, bytes per pixel.
const MEMBRANE: u64 = 200;
/// Additional memory of a worker with elastic layers, bytes per pixel.
const ELASTIC_BYTES: u64 = 60;
/// Memory of the layers' displacement table for a worker, bytes.
const DISPLACEMENT_TABLE_BYTES: u64 = 40 << 20;
/// Additional shared memory with an uncertain calibration, bytes per pixel: standard deviations of the reference.
const SHARED_SIGMA_BYTES: u64 = 120;
/// Additional memory of a worker with an uncertain calibration, bytes per pixel: standard deviations of the halves of a
/// file.
const WORKER_SIGMA_BYTES: u64 = 230;
/// Memory of a half's part of samples, bytes per pixel: half an image of 5 bytes per pixel, incompressible in the worst
/// case.
const PART: u64 = 3;
/// Memory of a capture in three colours, and of its part of samples, bytes per pixel.
const CAPTURE: u64 = 3 + 2;
/// Memory of a contact sheet, bytes per pixel: its images, values and colours, and the sheet with the file made of it.
const SHEET: u64 = 12 * (8 + 4 + 3 + 3 + 3);
/// Size of a line in the list of samples, bytes.
const LINE: u64 = 200;

/// Estimated memory of a data set, bytes.
#[derive(Clone, Copy, Debug)]
pub struct DatasetMemory {
    size_px: [u32; 2],
    shared: u64,
    each: u64,
}

impl DatasetMemory {
    /// Adds up the memory for a request.
    pub(super) fn new(scene: &SensorView, order: &DatasetRequest, patterns: usize) -> Self {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        let pixels: u64 = size_px.map(u64::from).iter().product();
        let (patterns, if_so) =
            (patterns as u64, |so: bool, bytes: u64| if so { bytes } else { 0 });
        let of_halves = if_so(order.materialise, PART)
            + if_so(order.captures.is_some() || order.images.is_some(), CAPTURE);
        let is_unsure = scene.viewpoint.has_uncertainty();
        let shared = SHARED_BYTES
            + if_so(is_unsure, SHARED_SIGMA_BYTES)
            // Standard deviations through refracting bodies need more memory.
            + if_so(scene.has_refracted_uncertainty(), REFRACTION_BYTES)
            + 2 * patterns * of_halves;
        let (more, field) = match order.contact {
            ContactModel::Rigid => (0, 0),
            ContactModel::Membrane(_) => (MEMBRANE, 0),
            ContactModel::Linear(_) => (ELASTIC_BYTES, DISPLACEMENT_TABLE_BYTES),
        };
        let each = pixels * (WORKER_BYTES + if_so(is_unsure, WORKER_SIGMA_BYTES) + more) + field;
        Self { size_px, shared: pixels * shared + LINE * patterns * patterns, each }
    }

    /// Returns the memory including a contact sheet.
    #[must_use]
    pub fn with_contact_sheet(self) -> Self {
        let pixels: u64 = self.size_px.map(u64::from).iter().product();
        Self { shared: self.shared + pixels * SHEET, ..self }
    }

    /// Requests the memory of a data set with one worker.
    ///
    /// # Errors
    /// Fails if there is not enough memory for one thread.
    pub(super) fn request(self) -> Result<MemoryGrant, MemoryError> {
        let bytes = self.shared.saturating_add(self.each);
        MemoryGrant::request(&self.what(), bytes, MemoryHint::Camera)
    }

    fn what(&self) -> String {
        let [width, height] = self.size_px;
        format!("a data set of {width} x {height} px")
    }

    /// Runs `work` on as many threads as memory allows.
    ///
    /// # Errors
    /// Fails if there is not enough memory for one thread, or as `work` does.
    pub fn run<R: Send, E: From<MemoryError> + Send>(
        self,
        work: impl FnOnce() -> Result<R, E> + Send,
    ) -> Result<R, E> {
        memory::run_on_workers(&self.what(), self.shared, self.each, MemoryHint::Camera, work)
    }
}
