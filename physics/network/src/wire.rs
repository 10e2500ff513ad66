//! Reader of the protocol-buffers wire format, as far as ONNX needs it.
//!
//! See <https://protobuf.dev/programming-guides/encoding/>. Nothing is copied. There is no recursion: nested messages
//! are read as deep as the caller asks for.

use crate::NetworkError;

/// Value of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldValue<'a> {
    /// Integer of any kind.
    Varint(u64),
    /// Eight bytes, little endian.
    Fixed64(u64),
    /// Text, message, bytes, or packed numbers.
    Bytes(&'a [u8]),
    /// Four bytes, little endian.
    Fixed32(u32),
}

/// Fields of a message, in the order of its bytes.
#[derive(Clone, Debug)]
pub struct Fields<'a> {
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    /// Creates the iterator over the fields of a message.
    pub fn new(message: &'a [u8]) -> Self {
        Self { rest: message }
    }

    /// Reads an integer.
    fn varint(&mut self) -> Result<u64, NetworkError> {
        let (value, used) = varint(self.rest)?;
        self.rest = &self.rest[used..];
        Ok(value)
    }

    /// Reads `count` bytes.
    fn take(&mut self, count: u64) -> Result<&'a [u8], NetworkError> {
        let count = usize::try_from(count).map_err(|_| NetworkError::Truncated)?;
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(NetworkError::Truncated)?;
        self.rest = rest;
        Ok(taken)
    }

    /// Reads an array of bytes.
    fn array<const N: usize>(&mut self) -> Result<[u8; N], NetworkError> {
        let (taken, rest) = self.rest.split_first_chunk().ok_or(NetworkError::Truncated)?;
        self.rest = rest;
        Ok(*taken)
    }

    /// Reads a field: its number and value.
    fn field(&mut self) -> Result<(u64, FieldValue<'a>), NetworkError> {
        let key = self.varint()?;
        let value = match key & 7 {
            0 => FieldValue::Varint(self.varint()?),
            1 => FieldValue::Fixed64(u64::from_le_bytes(self.array()?)),
            2 => {
                let count = self.varint()?;
                FieldValue::Bytes(self.take(count)?)
            }
            5 => FieldValue::Fixed32(u32::from_le_bytes(self.array()?)),
            // Groups, which ONNX does not use, and undefined types.
            _ => return Err(NetworkError::NotOnnx),
        };
        Ok((key >> 3, value))
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u64, FieldValue<'a>), NetworkError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let field = self.field();
        if field.is_err() {
            // Nothing after a fault can be interpreted.
            self.rest = &[];
        }
        Some(field)
    }
}

/// Decodes the integer at the start of `bytes`; returns it with its length.
fn varint(bytes: &[u8]) -> Result<(u64, usize), NetworkError> {
    let mut value = 0u64;
    // Ten groups of seven bits hold 64 bits.
    for (i, byte) in bytes.iter().take(10).enumerate() {
        value |= u64::from(byte & 0x7f) << (7 * i);
        if byte & 0x80 == 0 {
            return Ok((value, i + 1));
        }
    }
    Err(if bytes.len() < 10 { NetworkError::Truncated } else { NetworkError::NotOnnx })
}

/// Appends integers: a single one, or a packed list.
pub fn integers(value: FieldValue<'_>, into: &mut Vec<i64>) -> Result<(), NetworkError> {
    match value {
        // Negative numbers are written in two's complement.
        FieldValue::Varint(one) => into.push(one as i64),
        FieldValue::Bytes(mut bytes) => {
            while !bytes.is_empty() {
                let (one, used) = varint(bytes)?;
                into.push(one as i64);
                bytes = &bytes[used..];
            }
        }
        _ => return Err(NetworkError::NotOnnx),
    }
    Ok(())
}

/// Appends numbers: a single one, or a packed list.
pub fn floats(value: FieldValue<'_>, into: &mut Vec<f32>) -> Result<(), NetworkError> {
    match value {
        FieldValue::Fixed32(bits) => into.push(f32::from_bits(bits)),
        FieldValue::Bytes(bytes) => {
            let (fours, rest) = bytes.as_chunks::<4>();
            if !rest.is_empty() {
                return Err(NetworkError::Truncated);
            }
            into.extend(fours.iter().map(|four| f32::from_le_bytes(*four)));
        }
        _ => return Err(NetworkError::NotOnnx),
    }
    Ok(())
}

/// Reads a text.
pub fn text(value: FieldValue<'_>) -> Result<String, NetworkError> {
    let FieldValue::Bytes(bytes) = value else { return Err(NetworkError::NotOnnx) };
    String::from_utf8(bytes.to_vec()).map_err(|_| NetworkError::NotOnnx)
}

/// Reads a nested message.
pub fn message(value: FieldValue<'_>) -> Result<Fields<'_>, NetworkError> {
    match value {
        FieldValue::Bytes(bytes) => Ok(Fields::new(bytes)),
        _ => Err(NetworkError::NotOnnx),
    }
}
