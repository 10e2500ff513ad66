//! Arrays of lists, which NumPy stores as Python objects: NPY version 1.0 with a pickle inside (protocol 3, the
//! predecessor of PEP 3154's). Only for programs that require such files; `numpy.load(file, allow_pickle=True)` reads
//! them.

use crate::ExportError;
use crate::npz::header;

/// Writes lists of numbers as an array of the given shape, row by row (C order).
///
/// ```
/// let file = fabkit_export::npy_lists(&[1, 2], &[vec![0.5], vec![]])?;
/// assert!(file.starts_with(b"\x93NUMPY") && file.ends_with(b"."));
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
///
/// # Errors
/// A shape that does not match the number of lists.
pub fn npy_lists(shape: &[usize], lists: &[Vec<f64>]) -> Result<Vec<u8>, ExportError> {
    if shape.iter().product::<usize>() != lists.len() {
        let (name, shape) = ("lists".to_owned(), shape.to_vec());
        return Err(ExportError::Shape { name, shape, values: lists.len() });
    }
    let mut bytes = header(shape, "|O");
    // Opcodes that reconstruct an empty array; its state follows: version, shape, type, order, values.
    bytes.extend(
        b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\0\x85C\x01b\x87R",
    );
    bytes.extend(b"(K\x01(");
    for side in shape {
        bytes.push(b'J');
        bytes.extend((*side as i32).to_le_bytes());
    }
    bytes.extend(b"tcnumpy\ndtype\n");
    text(&mut bytes, "O8");
    bytes.extend(b"\x89\x88\x87R(K\x03");
    text(&mut bytes, "|");
    bytes.extend(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x3ftb\x89](");
    for list in lists {
        bytes.extend(b"](");
        for value in list {
            bytes.push(b'G');
            bytes.extend(value.to_be_bytes());
        }
        bytes.push(b'e');
    }
    bytes.extend(b"etb.");
    Ok(bytes)
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    bytes.push(b'X');
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
}
