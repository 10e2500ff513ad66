//! NumPy arrays: NPY version 1.0 (NumPy Enhancement Proposal 1), also in a ZIP archive as NPZ.

use std::io::{self, Write};

use crate::{ExportError, opc};

/// Values of an array, row by row (C order).
#[derive(Clone, Debug, PartialEq)]
pub enum NpyValues {
    /// 64-bit floating-point numbers, `float64`.
    F64(Vec<f64>),
    /// 32-bit floating-point numbers, `float32`.
    F32(Vec<f32>),
    /// 8-bit unsigned integers, `uint8`.
    U8(Vec<u8>),
    /// 16-bit unsigned integers, `uint16`.
    U16(Vec<u16>),
    /// Truth values, `bool`.
    Bool(Vec<bool>),
    /// Strings of any length.
    Text(Vec<String>),
}

/// A named array.
///
/// ```
/// use fabkit_export::{ExportError, NpyArray, NpyValues, npy};
///
/// let values = NpyValues::F64(vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
/// let depth_mm = NpyArray { name: "depth_mm".into(), shape: vec![2, 3], values };
/// let file = npy(&depth_mm)?;
/// // A header of 128 bytes, then six numbers, the last column of the last row at the end.
/// assert_eq!(file.len(), 128 + 6 * 8);
/// assert_eq!(file[file.len() - 8..], 2.5f64.to_le_bytes());
/// let wrong = NpyArray { shape: vec![2, 4], ..depth_mm };
/// assert!(matches!(npy(&wrong), Err(ExportError::Shape { values: 6, .. })));
/// # Ok::<(), ExportError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NpyArray {
    /// Name as in `numpy.load(file)[name]`; letters, digits and underscores.
    pub name: String,
    /// Lengths of the axes, the slowest first.
    pub shape: Vec<usize>,
    /// Values, as many as the shape requires.
    pub values: NpyValues,
}

impl NpyValues {
    /// NumPy's name of the type.
    fn descriptor(&self) -> String {
        match self {
            Self::F64(_) => "<f8".into(),
            Self::F32(_) => "<f4".into(),
            Self::U8(_) => "|u1".into(),
            Self::U16(_) => "<u2".into(),
            Self::Bool(_) => "|b1".into(),
            Self::Text(values) => format!("<U{}", longest(values)),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::Bool(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Writes the values; fails where there is not enough room.
    fn write(&self, to: &mut impl Write) -> io::Result<()> {
        match self {
            Self::F64(values) => values.iter().try_for_each(|v| to.write_all(&v.to_le_bytes())),
            Self::F32(values) => values.iter().try_for_each(|v| to.write_all(&v.to_le_bytes())),
            Self::U8(values) => to.write_all(values),
            Self::U16(values) => values.iter().try_for_each(|v| to.write_all(&v.to_le_bytes())),
            Self::Bool(values) => values.iter().try_for_each(|&v| to.write_all(&[u8::from(v)])),
            Self::Text(values) => {
                // UTF-32, all padded to the longest.
                let width = longest(values);
                let mut padded = values.iter().flat_map(|v| v.chars().chain(padding(v, width)));
                padded.try_for_each(|c| to.write_all(&u32::from(c).to_le_bytes()))
            }
        }
    }

    /// Number of bytes of one value.
    fn item_bytes(&self) -> usize {
        match self {
            Self::F64(_) => 8,
            Self::F32(_) => 4,
            Self::U16(_) => 2,
            Self::U8(_) | Self::Bool(_) => 1,
            Self::Text(values) => 4 * longest(values),
        }
    }
}

/// Length of the longest text in characters, at least 1: NumPy has no strings of length 0.
fn longest(values: &[String]) -> usize {
    values.iter().map(|value| value.chars().count()).max().unwrap_or(0).max(1)
}

fn padding(value: &str, width: usize) -> impl Iterator<Item = char> + use<> {
    std::iter::repeat_n('\0', width - value.chars().count())
}

/// Writes one array as an NPY file.
///
/// # Errors
/// A shape that does not match the number of values.
pub fn npy(array: &NpyArray) -> Result<Vec<u8>, ExportError> {
    array.check()?;
    let mut bytes = header(&array.shape, &array.values.descriptor());
    array.values.write(&mut bytes)?;
    Ok(bytes)
}

/// Writes the header of an NPY file.
pub(crate) fn header(shape: &[usize], descriptor: &str) -> Vec<u8> {
    // A tuple of one element needs its comma.
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!(
        "{{'descr': '{descriptor}', 'fortran_order': False, 'shape': ({}), }}",
        shape.trim_end(),
    );
    // Magic, version, length and header together are a multiple of 64, for aligned memory mapping.
    const BEFORE_HEADER: usize = 10;
    let padding = 64 - (BEFORE_HEADER + header.len() + 1) % 64;
    header.extend(std::iter::repeat_n(' ', padding % 64));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes
}

impl NpyArray {
    fn check(&self) -> Result<(), ExportError> {
        let Self { name, shape, values } = self;
        if shape.iter().product::<usize>() == values.len() {
            Ok(())
        } else {
            Err(wrong_shape(name, shape, values.len()))
        }
    }
}

fn wrong_shape(name: &str, shape: &[usize], values: usize) -> ExportError {
    ExportError::Shape { name: name.into(), shape: shape.into(), values }
}

/// Writes several arrays into one file, in the given order, uncompressed like `numpy.savez`.
///
/// # Errors
/// A shape that does not match, or an archive of more than 4 GiB.
///
/// ```
/// use fabkit_export::{NpyArray, NpyValues, npz};
///
/// let array = |name: &str, shape, values| NpyArray { name: name.into(), shape, values };
/// let file = npz(&[
///     array("depth_mm", vec![2], NpyValues::F32(vec![0.5, 0.25])),
///     array("unit", vec![], NpyValues::Text(vec!["mm".into()])),
/// ])?;
/// assert!(file.starts_with(b"PK"));
/// assert!(file.windows(12).any(|name| name == b"depth_mm.npy"));
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn npz(arrays: &[NpyArray]) -> Result<Vec<u8>, ExportError> {
    arrays.iter().try_for_each(NpyArray::check)?;
    let rows = arrays.iter().map(|array| array.shape.first().copied().unwrap_or_default());
    let mut pieces = NpzWriter::new(arrays, &rows.collect::<Vec<_>>())?;
    arrays.iter().enumerate().try_for_each(|(index, array)| pieces.push(index, &array.values))?;
    pieces.finish()
}

/// Writer of an [`npz`] file whose arrays arrive row by row. Only the file itself is held in memory.
///
/// ```
/// use fabkit_export::{NpyArray, NpyValues, NpzWriter, npz};
///
/// let array = |rows: Vec<f64>| NpyArray {
///     name: "force_n".into(),
///     shape: vec![rows.len() / 2, 2],
///     values: NpyValues::F64(rows),
/// };
/// let mut writer = NpzWriter::new(&[array(Vec::new())], &[2])?;
/// writer.push(0, &NpyValues::F64(vec![1.0, 2.0]))?;
/// assert!(writer.clone().finish().is_err()); // one row is missing
/// writer.push(0, &NpyValues::F64(vec![3.0, 4.0]))?;
/// assert!(writer.values_f64(0).eq([1.0, 2.0, 3.0, 4.0]));
/// assert_eq!(writer.finish()?, npz(&[array(vec![1.0, 2.0, 3.0, 4.0])])?);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
#[derive(Clone, Debug)]
pub struct NpzWriter {
    archive: opc::UncompressedArchive,
    arrays: Vec<PartialArray>,
}

#[derive(Clone, Debug)]
struct PartialArray {
    name: String,
    shape: Vec<usize>,
    descriptor: String,
    item_bytes: usize,
    /// Offset of the first value in the array's file.
    first_byte: usize,
    /// Number of bytes written so far.
    bytes: usize,
}

impl NpzWriter {
    /// Reserves arrays with the names, types and shapes of `like`, whose values are ignored, but with the given numbers
    /// of rows. Of texts, the longest is part of the type.
    ///
    /// # Errors
    /// An archive of more than 4 GiB.
    pub fn new(like: &[NpyArray], rows: &[usize]) -> Result<Self, ExportError> {
        let (mut arrays, mut parts, mut headers) = (Vec::new(), Vec::new(), Vec::new());
        for (array, rows) in like.iter().zip(rows) {
            let mut shape = array.shape.clone();
            // A scalar has no rows.
            shape.iter_mut().take(1).for_each(|first| *first = *rows);
            let (descriptor, item_bytes) = (array.values.descriptor(), array.values.item_bytes());
            let header = header(&shape, &descriptor);
            let values: usize = shape.iter().product();
            parts.push((format!("{}.npy", array.name), header.len() + item_bytes * values));
            let (name, first_byte) = (array.name.clone(), header.len());
            arrays.push(PartialArray { name, shape, descriptor, item_bytes, first_byte, bytes: 0 });
            headers.push(header);
        }
        let mut archive = opc::UncompressedArchive::new(parts)?;
        for (index, header) in headers.iter().enumerate() {
            archive.part_mut(index)[..header.len()].copy_from_slice(header);
        }
        Ok(Self { archive, arrays })
    }

    /// Appends values to the array at an index.
    ///
    /// # Errors
    /// More values than there is room for, or values of another type.
    pub fn push(&mut self, index: usize, values: &NpyValues) -> Result<(), ExportError> {
        let array = &mut self.arrays[index];
        let so_far = array.bytes / array.item_bytes + values.len();
        let refused = || wrong_shape(&array.name, &array.shape, so_far);
        if array.descriptor != values.descriptor() {
            return Err(refused());
        }
        let part = self.archive.part_mut(index);
        // Writing into the slice fails when it is full.
        let room = part.get_mut(array.first_byte + array.bytes..).unwrap_or_default();
        values.write(&mut &mut *room).map_err(|_| refused())?;
        array.bytes += array.item_bytes * values.len();
        Ok(())
    }

    /// Returns the values written so far to an array of [`NpyValues::F64`], so that they can be read again without a copy.
    pub fn values_f64(&self, index: usize) -> impl Iterator<Item = f64> + '_ {
        let PartialArray { first_byte, bytes, .. } = self.arrays[index];
        let (values, _) = self.archive.part(index)[first_byte..first_byte + bytes].as_chunks();
        values.iter().map(|value| f64::from_le_bytes(*value))
    }

    /// Returns the file.
    ///
    /// # Errors
    /// An array that is not complete.
    pub fn finish(self) -> Result<Vec<u8>, ExportError> {
        for PartialArray { name, shape, item_bytes, bytes, .. } in &self.arrays {
            if shape.iter().product::<usize>() != bytes / item_bytes {
                return Err(wrong_shape(name, shape, bytes / item_bytes));
            }
        }
        self.archive.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_aligned_and_says_what_follows() {
        for shape in [vec![6], vec![2, 3], vec![1, 2, 3]] {
            let values = NpyValues::F32((0..6).map(|i| i as f32).collect());
            let bytes = npy(&NpyArray { name: "a".into(), shape: shape.clone(), values }).unwrap();
            assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + length) % 64, 0);
            let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
            assert!(header.ends_with('\n') && header.contains("'descr': '<f4'"), "{header}");
            assert_eq!(bytes.len(), 10 + length + 24);
            assert_eq!(bytes[10 + length + 20..], 5f32.to_le_bytes());
        }
        let names = NpyValues::Text(vec!["none".into(), "µ".into()]);
        let names = npy(&NpyArray { name: "n".into(), shape: vec![2], values: names }).unwrap();
        assert!(String::from_utf8_lossy(&names).contains("'descr': '<U4'"));
        let last: Vec<u8> = [0xb5u32, 0, 0, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
        assert_eq!(names[names.len() - 16..], last);
        let one =
            NpyArray { name: "a".into(), shape: vec![2], values: NpyValues::Bool(vec![true; 2]) };
        assert!(String::from_utf8_lossy(&npy(&one).unwrap()).contains("'shape': (2,)"));
    }

    #[test]
    fn a_shape_must_fit() {
        let array =
            NpyArray { name: "a".into(), shape: vec![2, 2], values: NpyValues::U16(vec![1; 3]) };
        assert!(matches!(npy(&array), Err(ExportError::Shape { values: 3, .. })));
    }

    #[test]
    fn pieces_make_the_same_file() {
        let whole: Vec<f64> = (0..12).map(f64::from).collect();
        let maps = |rows: std::ops::Range<usize>| {
            vec![
                NpyArray {
                    name: "range".into(),
                    shape: vec![rows.len(), 3],
                    values: NpyValues::F64(whole[3 * rows.start..3 * rows.end].to_vec()),
                },
                NpyArray {
                    name: "names".into(),
                    shape: vec![2],
                    values: NpyValues::Text(vec!["a".into(), "bcd".into()]),
                },
            ]
        };
        let mut pieces = NpzWriter::new(&maps(0..1), &[4, 2]).unwrap();
        for rows in [0..1, 1..3, 3..4] {
            pieces.push(0, &maps(rows).remove(0).values).unwrap();
        }
        assert!(pieces.clone().finish().is_err(), "the names are missing");
        pieces.push(1, &maps(0..1)[1].values).unwrap();
        assert!(pieces.values_f64(0).eq(whole.iter().copied()));
        assert!(pieces.push(0, &NpyValues::F64(vec![1.0])).is_err(), "it is full");
        assert!(pieces.push(0, &NpyValues::U16(vec![])).is_err(), "it is of another kind");
        assert_eq!(pieces.finish().unwrap(), npz(&maps(0..4)).unwrap());
    }
}
