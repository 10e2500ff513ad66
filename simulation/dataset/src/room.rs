//! How much memory a data set takes, from what was measured on each of its steps.

use fabkit_files::memory::{self, Less, MemoryError};
use fabkit_scene::pressing::Contact;
use fabkit_scene::{BENT_BYTES, SensorView};

use super::DatasetRequest;

/// For each pixel, bytes: rays, the surface, the seam, and the reference with the file made of it.
const SHARED: u64 = 24 + 24 + 1 + 8 + 1 + 150;
/// A worker's file of halves, one of them being cast, and all of them packed.
const EACH: u64 = 150;
/// What a transition around contacts adds to the one being cast.
const MEMBRANE: u64 = 200;
/// What a surface that gives way adds, and its table, bytes in all.
const YIELDING: u64 = 60;
const FIELD: u64 = 40 << 20;
/// What a calibration that says how sure it is adds to either: how sure the reference is, and the halves of a file.
const UNSURE_SHARED: u64 = 120;
const UNSURE_EACH: u64 = 230;
/// What samples are stitched from: a half holds half a picture of 5 bytes, packed at worst not at all.
const PART: u64 = 3;
/// A capture in three colours, and as a part.
const CAPTURE: u64 = 3 + 2;
/// Pictures in a sheet, values and colours, and the sheet with the file made of it.
const SHEET: u64 = 12 * (8 + 4 + 3 + 3 + 3);
/// A line of the list of samples.
const LINE: u64 = 200;

/// Memory of a data set, bytes.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    size_px: [u32; 2],
    shared: u64,
    each: u64,
}

impl Room {
    pub(super) fn new(scene: &SensorView, order: &DatasetRequest, patterns: usize) -> Self {
        let camera = scene.viewpoint.camera();
        let size_px = [camera.width_px(), camera.height_px()];
        let pixels: u64 = size_px.map(u64::from).iter().product();
        let (patterns, if_so) =
            (patterns as u64, |so: bool, bytes: u64| if so { bytes } else { 0 });
        let of_halves = if_so(order.materialise, PART)
            + if_so(order.captures.is_some() || order.images.is_some(), CAPTURE);
        let is_unsure = scene.viewpoint.says_how_sure();
        let shared = SHARED
            + if_so(is_unsure, UNSURE_SHARED)
            + if_so(scene.is_unsure_behind_bends(), BENT_BYTES)
            + 2 * patterns * of_halves;
        let (more, field) = match order.contact {
            Contact::Rigid => (0, 0),
            Contact::Membrane(_) => (MEMBRANE, 0),
            Contact::Linear(_) => (YIELDING, FIELD),
        };
        let each = pixels * (EACH + if_so(is_unsure, UNSURE_EACH) + more) + field;
        Self { size_px, shared: pixels * shared + LINE * patterns * patterns, each }
    }

    /// The same with a sheet of samples.
    #[must_use]
    pub fn with_sheet(self) -> Self {
        let pixels: u64 = self.size_px.map(u64::from).iter().product();
        Self { shared: self.shared + pixels * SHEET, ..self }
    }

    /// Works on as many threads as there is memory for.
    ///
    /// # Errors
    /// No room for one; what `work` says.
    pub fn work<R: Send, E: From<MemoryError> + Send>(
        self,
        work: impl FnOnce() -> Result<R, E> + Send,
    ) -> Result<R, E> {
        let [width, height] = self.size_px;
        let what = format!("a data set of {width} x {height} px");
        memory::on_workers(&what, self.shared, self.each, Less::Camera, work)
    }
}
