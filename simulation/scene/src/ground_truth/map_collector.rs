//! Assembly of output files from a depth map that is cast in bands, from the top down, so that large data is in memory
//! only once.

use fabkit_depth::ground_truth::{DepthMap, NO_LABEL, StandardDeviations};
use fabkit_export::{ExportError, NpzWriter, PointCloud, grey8_png, png};

use super::files::{self, MapQuantity};
use super::{DeepestContact, arrays};

/// Selection of the files to write.
#[derive(Clone, Copy, Debug, Default)]
pub struct FileSelection {
    /// All maps as an NPZ file for NumPy.
    pub npz: bool,
    /// Quantity that the images and the TIFF show.
    pub quantity: Option<MapQuantity>,
    /// A false-colour image.
    pub png: bool,
    /// A 16-bit greyscale image.
    pub grey: bool,
    /// A floating-point TIFF.
    pub tiff: bool,
    /// A mask of the pixels that see the surface.
    pub mask: bool,
    /// A point cloud.
    pub cloud: bool,
}

/// Names of the standard deviations of ranges and of points among [`arrays`].
const SIGMAS: [&str; 2] = ["sigma_mm", "point_sigma_mm"];
/// Suffix of the arrays of names, which do not grow with the rows.
const NAMES: &str = "_names";

/// Data of a whole map, as far as the selected files need it.
#[derive(Debug)]
pub struct MapCollector {
    wanted: FileSelection,
    size_px: [u32; 2],
    npz: Option<NpzWriter>,
    sigmas_at: [usize; 2],
    /// Standard deviations of ranges and of points, mm; used only without `npz`, which has them as arrays.
    sigmas_mm: [Vec<f64>; 2],
    shown_mm: Vec<f64>,
    /// Mask intensities: 255 where the surface is seen, else 0.
    mask: Vec<u8>,
    cloud: Option<PointCloud>,
    /// Names of the labels.
    pub names: Vec<String>,
    /// Deepest contact; `None` without contact.
    pub deepest: Option<DeepestContact>,
    /// Number of pixels that see the surface.
    pub surface_px: usize,
    /// Number of pixels that see an indenter.
    pub contact_px: usize,
}

impl FileSelection {
    /// Returns an upper bound of the memory that the files and their sources take for each ray, bytes.
    pub fn bytes_per_ray(self) -> u64 {
        let if_so = |so: bool, bytes: u64| if so { bytes } else { 0 };
        // With `npz` all arrays are kept, otherwise two standard deviations of 8 bytes each.
        let maps = if self.npz { 116 } else { 16 };
        let shown = if_so(self.quantity.is_some(), 8);
        // Finished files stay in memory; at worst they are as large as their contents.
        let files =
            [(self.png, 3), (self.grey, 2), (self.tiff, 4), (self.mask, 2), (self.cloud, 53)];
        let files: u64 = files.map(|(so, bytes)| if_so(so, bytes)).iter().sum();
        // Files are encoded one after the other, so only the largest pair of raw and filtered values counts.
        let passing = [(self.png, 6), (self.grey, 6), (self.tiff, 4)];
        let passing = passing.map(|(so, bytes)| if_so(so, bytes)).into_iter().max();
        maps + shown + files + passing.unwrap_or_default()
    }
}

impl MapCollector {
    /// Creates an empty collection for a map of `size_px`, width and height.
    pub fn new(wanted: FileSelection, size_px: [u32; 2]) -> Self {
        Self {
            wanted,
            size_px,
            npz: None,
            sigmas_at: [0; 2],
            sigmas_mm: Default::default(),
            shown_mm: Vec::new(),
            mask: Vec::new(),
            cloud: wanted.cloud.then(files::empty_cloud),
            names: Vec::new(),
            deepest: None,
            surface_px: 0,
            contact_px: 0,
        }
    }

    /// Adds the next rows of the map, with their standard deviations.
    ///
    /// # Errors
    /// Returns an error if an array becomes larger than its file can be.
    pub fn add(&mut self, map: &DepthMap, sigmas: &StandardDeviations) -> Result<(), ExportError> {
        if self.names.is_empty() {
            self.names = map.names().to_vec();
        }
        self.contact_px += map.contact().filter(|contact| *contact).count();
        if self.wanted.npz {
            self.add_arrays(map, sigmas)?;
        } else {
            let [ranges, points] = &mut self.sigmas_mm;
            ranges.extend(sigmas.range_mm());
            points.extend(sigmas.point_mm());
        }
        if let Some(shown) = self.wanted.quantity {
            self.shown_mm.extend(shown.values_mm(map, sigmas));
        }
        if self.wanted.mask {
            self.mask.extend(
                map.label().iter().map(|&label| if label == NO_LABEL { 0 } else { u8::MAX }),
            );
        }
        if let Some(cloud) = &mut self.cloud {
            files::add_points(map, cloud);
        }
        Ok(())
    }

    fn add_arrays(
        &mut self,
        map: &DepthMap,
        sigmas: &StandardDeviations,
    ) -> Result<(), ExportError> {
        let pieces = arrays(map, sigmas);
        let is_first = self.npz.is_none();
        let npz = match &mut self.npz {
            Some(npz) => npz,
            none => {
                let height = self.size_px[1] as usize;
                let rows = pieces
                    .iter()
                    .map(|array| if array.name.ends_with(NAMES) { array.shape[0] } else { height });
                self.sigmas_at = SIGMAS
                    .map(|name| pieces.iter().position(|array| array.name == name).unwrap_or(0));
                none.insert(NpzWriter::new(&pieces, &rows.collect::<Vec<_>>())?)
            }
        };
        // Arrays of names are the same in every band and are written once.
        let new = |name: &str| is_first || !name.ends_with(NAMES);
        for (index, array) in pieces.iter().enumerate().filter(|(_, array)| new(&array.name)) {
            npz.push(index, &array.values)?;
        }
        Ok(())
    }

    /// Returns the medians of all standard deviations of ranges and of points, mm; NaN if there are none.
    pub fn median_sigmas_mm(&self) -> [f64; 2] {
        [0, 1].map(|which| match &self.npz {
            Some(npz) => median(|| npz.values_f64(self.sigmas_at[which])),
            None => median(|| self.sigmas_mm[which].iter().copied()),
        })
    }

    /// Returns the bytes of the NPZ file; empty if it was not selected, and on every later call.
    ///
    /// # Errors
    /// Returns an error if rows are missing.
    pub fn take_npz(&mut self) -> Result<Vec<u8>, ExportError> {
        self.npz.take().map_or(Ok(Vec::new()), NpzWriter::finish)
    }

    /// Returns the bytes of the point cloud; empty if it was not selected, and on every later call.
    pub fn take_cloud(&mut self) -> Vec<u8> {
        self.cloud.take().map(PointCloud::finish).unwrap_or_default()
    }

    /// Encodes the false-colour image as PNG.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn false_color_png(&self) -> Result<Vec<u8>, ExportError> {
        let image = files::false_color_image(self.size_px[0], &self.shown_mm);
        png(image.width_px, image.height_px, &image.rgb)
    }

    /// Encodes the 16-bit greyscale image as PNG.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn grey(&self) -> Result<Vec<u8>, ExportError> {
        files::grey(self.size_px[0], self.size_px[1], &self.shown_mm)
    }

    /// Encodes the mask as PNG: white where the surface is seen, black elsewhere.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn mask_png(&self) -> Result<Vec<u8>, ExportError> {
        grey8_png(self.size_px[0], self.size_px[1], &self.mask)
    }

    /// Encodes the floating-point TIFF.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn tiff(&self) -> Result<Vec<u8>, ExportError> {
        files::encode_tiff(self.size_px[0], self.size_px[1], &self.shown_mm)
    }
}

/// Returns the median of the finite values, the upper one of an even number; NaN if there are none. A radix selection
/// of 16 bits at a time: `values` is iterated several times instead of being copied and sorted.
///
/// ```
/// use fabkit_scene::ground_truth::median;
/// let values_mm = [3.0, f64::NAN, 1.0, 2.0, f64::INFINITY];
/// assert_eq!(median(|| values_mm.iter().copied()), 2.0);
/// // Of an even number, the upper one of the two in the middle.
/// assert_eq!(median(|| [1.0, 2.0, 3.0, 4.0].into_iter()), 3.0);
/// assert!(median(|| [f64::NAN].into_iter()).is_nan());
/// ```
pub fn median<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> f64 {
    const SIGN: u64 = 1 << 63;
    // Maps floats to integers in the same order: negative numbers are inverted, positive ones get the sign bit.
    let ordered = |value: f64| match value.to_bits() {
        bits if bits & SIGN != 0 => !bits,
        bits => bits | SIGN,
    };
    let finite = || values().filter(|value| value.is_finite()).map(ordered);
    let mut rank = finite().count() / 2;
    let mut found = 0u64;
    for shift in [48, 32, 16, 0] {
        let mut counts = vec![0usize; 1 << 16];
        // Only values that share all digits found so far take part.
        let is_near = |bits: &u64| shift == 48 || bits >> (shift + 16) == found;
        finite().filter(is_near).for_each(|bits| counts[(bits >> shift & 0xffff) as usize] += 1);
        let Some(digit) = counts.iter().position(|&count| {
            let here = rank < count;
            rank -= if here { 0 } else { count };
            here
        }) else {
            return f64::NAN;
        };
        found = found << 16 | digit as u64;
    }
    f64::from_bits(if found & SIGN != 0 { found ^ SIGN } else { !found })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_a_sorted_list() {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) as f64 - 1e9) * 1e-7
        };
        for count in [0, 1, 2, 3, 100, 1001] {
            let mut values: Vec<f64> = (0..count).map(|_| next()).collect();
            values.extend([f64::NAN, f64::INFINITY]);
            let found = median(|| values.iter().copied());
            values.retain(|value| value.is_finite());
            values.sort_by(f64::total_cmp);
            let wanted = values.get(values.len() / 2).copied().unwrap_or(f64::NAN);
            assert_eq!(found.to_bits(), wanted.to_bits(), "{count}: {found} {wanted}");
        }
    }
}
