//! Files of a map that comes in pieces, from the top down: what is large is in memory once.

use fabkit_depth::truth::{DepthMap, NO_LABEL, Sigmas};
use fabkit_export::{Cloud, ExportError, NpzPieces, grey8_png, png};

use super::files::{self, Shown};
use super::{Deepest, arrays};

/// Which files are wanted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// All maps for NumPy.
    pub npz: bool,
    /// What pictures and a TIFF show.
    pub shown: Option<Shown>,
    /// A picture in colours.
    pub png: bool,
    /// A picture in grey.
    pub grey: bool,
    /// A TIFF.
    pub tiff: bool,
    /// Which pixels see the surface.
    pub mask: bool,
    /// A cloud of points.
    pub cloud: bool,
}

/// Standard deviations of ranges and of points among [`arrays`].
const SIGMAS: [&str; 2] = ["sigma_mm", "point_sigma_mm"];
/// Of names, which do not grow.
const NAMES: &str = "_names";

/// A whole map, as far as it is wanted.
#[derive(Debug)]
pub struct Collected {
    wanted: Wanted,
    size_px: [u32; 2],
    npz: Option<NpzPieces>,
    sigmas_at: [usize; 2],
    /// Where there are no arrays that have it.
    sigmas_mm: [Vec<f64>; 2],
    shown_mm: Vec<f64>,
    /// White where the surface is seen.
    mask: Vec<u8>,
    cloud: Option<Cloud>,
    /// What labels mean.
    pub names: Vec<String>,
    /// The deepest contact; `None` without contact.
    pub deepest: Option<Deepest>,
    /// How many pixels see the surface.
    pub surface_px: usize,
    /// How many of them see what presses.
    pub contact_px: usize,
}

impl Wanted {
    /// Bytes that files and what they are made from take for each ray, at most.
    pub fn bytes_per_ray(self) -> u64 {
        let if_so = |so: bool, bytes: u64| if so { bytes } else { 0 };
        // Of arrays, or of standard deviations alone.
        let maps = if self.npz { 116 } else { 16 };
        let shown = if_so(self.shown.is_some(), 8);
        // Files that stay, at worst as large as what they hold.
        let files =
            [(self.png, 3), (self.grey, 2), (self.tiff, 4), (self.mask, 2), (self.cloud, 53)];
        let files: u64 = files.map(|(so, bytes)| if_so(so, bytes)).iter().sum();
        // Values to be written and the same filtered, of one file after the other.
        let passing = [(self.png, 6), (self.grey, 6), (self.tiff, 4)];
        let passing = passing.map(|(so, bytes)| if_so(so, bytes)).into_iter().max();
        maps + shown + files + passing.unwrap_or_default()
    }
}

impl Collected {
    /// Of a map of this width and height, px.
    pub fn new(wanted: Wanted, size_px: [u32; 2]) -> Self {
        Self {
            wanted,
            size_px,
            npz: None,
            sigmas_at: [0; 2],
            sigmas_mm: Default::default(),
            shown_mm: Vec::new(),
            mask: Vec::new(),
            cloud: wanted.cloud.then(files::cloud),
            names: Vec::new(),
            deepest: None,
            surface_px: 0,
            contact_px: 0,
        }
    }

    /// Adds the next rows with the standard deviations of their ranges, mm.
    ///
    /// # Errors
    /// Arrays that are larger than their file can be.
    pub fn add(&mut self, map: &DepthMap, sigmas: &Sigmas) -> Result<(), ExportError> {
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
        if let Some(shown) = self.wanted.shown {
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

    fn add_arrays(&mut self, map: &DepthMap, sigmas: &Sigmas) -> Result<(), ExportError> {
        let pieces = arrays(map, sigmas);
        let is_first = self.npz.is_none();
        let npz = match &mut self.npz {
            Some(npz) => npz,
            none => {
                let height = self.size_px[1] as usize;
                let rows = pieces.iter().map(|array| match array.name.ends_with(NAMES) {
                    true => array.shape[0],
                    false => height,
                });
                self.sigmas_at = SIGMAS
                    .map(|name| pieces.iter().position(|array| array.name == name).unwrap_or(0));
                none.insert(NpzPieces::new(&pieces, &rows.collect::<Vec<_>>())?)
            }
        };
        let new = |name: &str| is_first || !name.ends_with(NAMES);
        for (index, array) in pieces.iter().enumerate().filter(|(_, array)| new(&array.name)) {
            npz.push(index, &array.values)?;
        }
        Ok(())
    }

    /// The middles of all standard deviations of ranges and of points, mm; `NaN` if there are none.
    pub fn median_sigmas_mm(&self) -> [f64; 2] {
        [0, 1].map(|which| match &self.npz {
            Some(npz) => median(|| npz.values_f64(self.sigmas_at[which])),
            None => median(|| self.sigmas_mm[which].iter().copied()),
        })
    }

    /// The bytes of the arrays; empty if they are not wanted. They are handed out once.
    ///
    /// # Errors
    /// Rows that are missing.
    pub fn take_npz(&mut self) -> Result<Vec<u8>, ExportError> {
        self.npz.take().map_or(Ok(Vec::new()), NpzPieces::finish)
    }

    /// The bytes of the cloud; empty if it is not wanted. They are handed out once.
    pub fn take_cloud(&mut self) -> Vec<u8> {
        self.cloud.take().map(Cloud::finish).unwrap_or_default()
    }

    /// The bytes of a picture in colours.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn picture(&self) -> Result<Vec<u8>, ExportError> {
        let picture = files::picture(self.size_px[0], &self.shown_mm);
        png(picture.width_px, picture.height_px, &picture.rgb)
    }

    /// The bytes of a picture in 16-bit grey.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn grey(&self) -> Result<Vec<u8>, ExportError> {
        files::grey(self.size_px[0], self.size_px[1], &self.shown_mm)
    }

    /// The bytes of a mask: white where the surface is seen, black elsewhere.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn mask(&self) -> Result<Vec<u8>, ExportError> {
        grey8_png(self.size_px[0], self.size_px[1], &self.mask)
    }

    /// The bytes of a TIFF.
    ///
    /// # Errors
    /// [`ExportError`].
    pub fn tiff(&self) -> Result<Vec<u8>, ExportError> {
        files::tiff(self.size_px[0], self.size_px[1], &self.shown_mm)
    }
}

/// The middle one of the finite values, of an even number the upper one; `NaN` for none. Sixteen bits
/// of it at a time, so that there is no second copy to sort.
pub fn median<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> f64 {
    const SIGN: u64 = 1 << 63;
    // In the order of the numbers themselves.
    let ordered = |value: f64| match value.to_bits() {
        bits if bits & SIGN != 0 => !bits,
        bits => bits | SIGN,
    };
    let finite = || values().filter(|value| value.is_finite()).map(ordered);
    let mut rank = finite().count() / 2;
    let mut found = 0u64;
    for shift in [48, 32, 16, 0] {
        let mut counts = vec![0usize; 1 << 16];
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
