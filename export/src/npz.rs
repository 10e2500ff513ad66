//! Arrays as NumPy reads them: NPY version 1.0 (NumPy Enhancement Proposal 1) in a ZIP archive.

use crate::{ExportError, opc};

/// The values of an array, row by row (C order).
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// `float64`.
    F64(Vec<f64>),
    /// `float32`.
    F32(Vec<f32>),
    /// `uint16`.
    U16(Vec<u16>),
    /// `bool`.
    Bool(Vec<bool>),
    /// Strings of any length.
    Text(Vec<String>),
}

/// A named array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// As in `numpy.load(file)[name]`; letters, digits and underscores.
    pub name: String,
    /// Lengths of the axes, the slowest first.
    pub shape: Vec<usize>,
    /// As many as the shape says.
    pub values: Values,
}

impl Values {
    /// The type as NumPy writes it.
    fn descriptor(&self) -> String {
        match self {
            Self::F64(_) => "<f8".into(),
            Self::F32(_) => "<f4".into(),
            Self::U16(_) => "<u2".into(),
            Self::Bool(_) => "|b1".into(),
            Self::Text(values) => format!("<U{}", longest(values)),
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::F64(values) => values.len(),
            Self::F32(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::Bool(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::F64(values) => values.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
            Self::F32(values) => values.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
            Self::U16(values) => values.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
            Self::Bool(values) => bytes.extend(values.iter().map(|&v| u8::from(v))),
            Self::Text(values) => {
                // UTF-32, all as long as the longest.
                let width = longest(values);
                let padded = values.iter().flat_map(|v| v.chars().chain(padding(v, width)));
                bytes.extend(padded.flat_map(|c| u32::from(c).to_le_bytes()));
            }
        }
    }
}

/// In characters; NumPy knows no strings of length 0.
fn longest(values: &[String]) -> usize {
    values.iter().map(|value| value.chars().count()).max().unwrap_or(0).max(1)
}

fn padding(value: &str, width: usize) -> impl Iterator<Item = char> + use<> {
    std::iter::repeat_n('\0', width - value.chars().count())
}

/// The bytes of one array as an NPY file.
///
/// # Errors
/// A shape that does not fit the number of values.
pub fn npy(array: &Array) -> Result<Vec<u8>, ExportError> {
    let expected: usize = array.shape.iter().product();
    if expected != array.values.len() {
        return Err(ExportError::Shape {
            name: array.name.clone(),
            shape: array.shape.clone(),
            values: array.values.len(),
        });
    }
    // A tuple of one needs its comma.
    let shape: String = array.shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
        array.values.descriptor(),
        shape.trim_end(),
    );
    // Magic, version, length and header together are a multiple of 64, for aligned mapping.
    const BEFORE_HEADER: usize = 10;
    let padding = 64 - (BEFORE_HEADER + header.len() + 1) % 64;
    header.extend(std::iter::repeat_n(' ', padding % 64));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    array.values.write(&mut bytes);
    Ok(bytes)
}

/// Several arrays in one file, in the order given; not compressed, as `numpy.savez` does.
///
/// # Errors
/// A shape that does not fit, or an archive of more than 4 GiB.
pub fn npz(arrays: &[Array]) -> Result<Vec<u8>, ExportError> {
    let files: Vec<(String, Vec<u8>)> = arrays
        .iter()
        .map(|array| Ok((format!("{}.npy", array.name), npy(array)?)))
        .collect::<Result<_, ExportError>>()?;
    let parts: Vec<(&str, &[u8])> =
        files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
    opc::archive(&parts, opc::Method::Store)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_aligned_and_says_what_follows() {
        for shape in [vec![6], vec![2, 3], vec![1, 2, 3]] {
            let values = Values::F32((0..6).map(|i| i as f32).collect());
            let bytes = npy(&Array { name: "a".into(), shape: shape.clone(), values }).unwrap();
            assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!((10 + length) % 64, 0);
            let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
            assert!(header.ends_with('\n') && header.contains("'descr': '<f4'"), "{header}");
            assert_eq!(bytes.len(), 10 + length + 24);
            assert_eq!(bytes[10 + length + 20..], 5f32.to_le_bytes());
        }
        let names = Values::Text(vec!["none".into(), "µ".into()]);
        let names = npy(&Array { name: "n".into(), shape: vec![2], values: names }).unwrap();
        assert!(String::from_utf8_lossy(&names).contains("'descr': '<U4'"));
        let last: Vec<u8> = [0xb5u32, 0, 0, 0].iter().flat_map(|c| c.to_le_bytes()).collect();
        assert_eq!(names[names.len() - 16..], last);
        let one = Array { name: "a".into(), shape: vec![2], values: Values::Bool(vec![true; 2]) };
        assert!(String::from_utf8_lossy(&npy(&one).unwrap()).contains("'shape': (2,)"));
    }

    #[test]
    fn a_shape_must_fit() {
        let array = Array { name: "a".into(), shape: vec![2, 2], values: Values::U16(vec![1; 3]) };
        assert!(matches!(npy(&array), Err(ExportError::Shape { values: 3, .. })));
    }
}
