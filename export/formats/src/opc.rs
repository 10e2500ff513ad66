//! ZIP archives, the container of 3MF and NPZ files, as the Open Packaging Conventions (ISO/IEC 29500-2) require.
//!
//! Fixed time stamps, fixed order and one portable deflate implementation: equal parts make equal archives everywhere.

use std::io::Write;
use std::ops::Range;

use flate2::{Compression, Crc, write::DeflateEncoder};

use crate::ExportError;

/// Earliest date of a ZIP archive, 1980-01-01: ((year - 1980) << 9) | (month << 5) | day.
const DOS_DATE: u16 = (1 << 5) | 1;
const DOS_TIME: u16 = 0;
/// Version 2.0, the first one with deflate.
const VERSION_NEEDED: u16 = 20;
/// Deflate level. On all parts of rtac0, level 6 makes files 2 % smaller and the whole export 1.5 times as long; level
/// 1 makes files 40 % larger and saves a tenth of the time.
const LEVEL: u32 = 4;
/// Number of bytes before a part, without its name.
const LOCAL_HEADER: usize = 30;
/// Number of bytes of a directory entry, without its name, and of the record that ends the directory.
const DIRECTORY_ENTRY: usize = 46;
const DIRECTORY_END: usize = 22;

/// Compression method of a part; the numbers are the format's.
#[derive(Clone, Copy, Debug)]
enum Method {
    /// Uncompressed: floating-point numbers compress badly and slowly.
    Store = 0,
    /// Deflate, RFC 1951.
    Deflate = 8,
}

/// Directory data of a part that has been written.
struct DirectoryEntry<'a> {
    name: &'a str,
    method: Method,
    crc: u32,
    packed: u32,
    unpacked: u32,
    offset: u32,
}

/// Packs files into a ZIP archive. All carry the date 1980-01-01, so that equal files make equal archives. Names must
/// be ASCII.
///
/// # Errors
/// [`ExportError::TooLarge`] beyond 4 GiB or 65,535 files.
///
/// ```
/// use fabkit_export::zip;
///
/// let files = [("a.txt", &b"one"[..]), ("boards/b.txt", &b"two"[..])];
/// let archive = zip(&files)?;
/// // The name of the first file follows its header of 30 bytes.
/// assert_eq!((&archive[..2], &archive[30..35]), (&b"PK"[..], &b"a.txt"[..]));
/// assert_eq!(archive, zip(&files)?);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn zip(files: &[(&str, &[u8])]) -> Result<Vec<u8>, ExportError> {
    if u16::try_from(files.len()).is_err() {
        let (needed, limit) = (files.len() as u64, u16::MAX.into());
        return Err(ExportError::TooLarge { what: "the archive's directory", needed, limit });
    }
    archive(files)
}

/// Packs named parts in the given order, compressed. Names must be ASCII.
pub(crate) fn archive(parts: &[(&str, &[u8])]) -> Result<Vec<u8>, ExportError> {
    let mut bytes = Vec::new();
    let mut entries = Vec::with_capacity(parts.len());
    for &(name, content) in parts {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::new(LEVEL));
        encoder.write_all(content)?;
        let packed = encoder.finish()?;
        let entry = DirectoryEntry {
            name,
            method: Method::Deflate,
            crc: crc(content),
            packed: field("a compressed part", packed.len())?,
            unpacked: field("a part", content.len())?,
            offset: field("the archive", bytes.len())?,
        };
        entry.write_local_header(&mut bytes);
        bytes.extend(packed);
        entries.push(entry);
    }
    write_directory(&mut bytes, &entries)?;
    Ok(bytes)
}

/// Archive of uncompressed parts whose sizes are known in advance. Parts are filled in place, so that large ones are in
/// memory only once.
#[derive(Clone, Debug)]
pub(crate) struct UncompressedArchive {
    bytes: Vec<u8>,
    /// Names and byte ranges of the parts.
    parts: Vec<(String, Range<usize>)>,
}

impl UncompressedArchive {
    /// Reserves room for named parts, all zeros, in the given order. Names must be ASCII.
    pub(crate) fn new(parts: Vec<(String, usize)>) -> Result<Self, ExportError> {
        let (mut end, mut places) = (0usize, Vec::with_capacity(parts.len()));
        let names: usize = parts.iter().map(|(name, _)| name.len()).sum();
        let directory = parts.len() * DIRECTORY_ENTRY + names + DIRECTORY_END;
        for (name, size) in parts {
            field("a part", size)?;
            let start = end + LOCAL_HEADER + name.len();
            end = start + size;
            field("the archive", end)?;
            places.push((name, start..end));
        }
        // Capacity for the directory too, so that appending it does not copy the whole archive.
        let mut bytes = vec![0; end + directory];
        bytes.truncate(end);
        Ok(Self { bytes, parts: places })
    }

    /// Returns the part at an index.
    pub(crate) fn part(&self, index: usize) -> &[u8] {
        &self.bytes[self.parts[index].1.clone()]
    }

    /// Returns the part at an index, to be filled.
    pub(crate) fn part_mut(&mut self, index: usize) -> &mut [u8] {
        &mut self.bytes[self.parts[index].1.clone()]
    }

    /// Completes the archive and returns its bytes.
    pub(crate) fn finish(self) -> Result<Vec<u8>, ExportError> {
        let Self { mut bytes, parts } = self;
        let mut entries = Vec::with_capacity(parts.len());
        for (name, place) in &parts {
            let size = field("a part", place.len())?;
            let start = place.start - LOCAL_HEADER - name.len();
            let entry = DirectoryEntry {
                name,
                method: Method::Store,
                crc: crc(&bytes[place.clone()]),
                packed: size,
                unpacked: size,
                offset: field("the archive", start)?,
            };
            let mut header = Vec::with_capacity(LOCAL_HEADER + name.len());
            entry.write_local_header(&mut header);
            bytes[start..place.start].copy_from_slice(&header);
            entries.push(entry);
        }
        write_directory(&mut bytes, &entries)?;
        Ok(bytes)
    }
}

fn crc(content: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(content);
    crc.sum()
}

/// Appends the central directory and the record that ends it.
fn write_directory(bytes: &mut Vec<u8>, entries: &[DirectoryEntry]) -> Result<(), ExportError> {
    let mut directory = Vec::new();
    for entry in entries {
        directory.extend(*b"PK\x01\x02");
        directory.extend(VERSION_NEEDED.to_le_bytes()); // made by: FAT, so no file modes
        entry.write_common(&mut directory);
        directory.extend([0; 10]); // comment length, disk number, attributes
        directory.extend(entry.offset.to_le_bytes());
        directory.extend(entry.name.as_bytes());
    }
    let size = field("the archive", directory.len())?;
    let offset = field("the archive", bytes.len())?;
    let count = (entries.len() as u16).to_le_bytes();
    directory.extend(*b"PK\x05\x06");
    directory.extend([0; 4]); // disk numbers
    directory.extend(count);
    directory.extend(count);
    directory.extend(size.to_le_bytes());
    directory.extend(offset.to_le_bytes());
    directory.extend([0; 2]); // comment length
    bytes.extend(directory);
    Ok(())
}

impl DirectoryEntry<'_> {
    fn write_local_header(&self, bytes: &mut Vec<u8>) {
        bytes.extend(*b"PK\x03\x04");
        self.write_common(bytes);
        bytes.extend(self.name.as_bytes());
    }

    /// Writes the fields that a local header and a directory entry share, in their common order.
    fn write_common(&self, bytes: &mut Vec<u8>) {
        for word in [VERSION_NEEDED, 0, self.method as u16, DOS_TIME, DOS_DATE] {
            bytes.extend(word.to_le_bytes());
        }
        for long in [self.crc, self.packed, self.unpacked] {
            bytes.extend(long.to_le_bytes());
        }
        bytes.extend((self.name.len() as u16).to_le_bytes());
        bytes.extend([0; 2]); // extra field length
    }
}

/// Converts a size to 32 bits. ZIP's 64-bit extension is not used, since 3MF readers need not support it.
fn field(what: &'static str, size: usize) -> Result<u32, ExportError> {
    u32::try_from(size).map_err(|_| ExportError::TooLarge {
        what,
        needed: size as u64,
        limit: u32::MAX.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_archive_is_laid_out_as_the_format_says() {
        let text = b"three words, three words, three words".repeat(9);
        let parts: [(&str, &[u8]); 2] = [("a.txt", &text), ("b/c.txt", b"")];
        let bytes = archive(&parts).unwrap();
        assert_eq!(bytes, archive(&parts).unwrap());
        let mut stored = UncompressedArchive::new(vec![("a.txt".into(), text.len())]).unwrap();
        stored.part_mut(0).copy_from_slice(&text);
        let (room, stored) = (stored.bytes.capacity(), stored.finish().unwrap());
        assert_eq!(stored.capacity(), room, "nothing moves that is large");
        assert_eq!(stored[35..35 + text.len()], text);
        assert_eq!(stored[14..18], bytes[14..18], "the same checksum");
        let u16_at = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
        let u32_at = |i: usize| u32::from_le_bytes(bytes[i..i + 4].try_into().unwrap());

        // End of central directory: two entries, and the directory ends where this begins.
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        assert_eq!((u16_at(end + 8), u16_at(end + 10)), (2, 2));
        assert_eq!(u32_at(end + 12) + u32_at(end + 16), end as u32);

        // First directory entry points at the first local header, which says the same.
        let directory = u32_at(end + 16) as usize;
        assert_eq!(&bytes[directory..directory + 4], b"PK\x01\x02");
        assert_eq!(u32_at(directory + 42), 0);
        assert_eq!(bytes[directory + 6..directory + 32], bytes[4..30]);
        assert_eq!(u32_at(22), text.len() as u32);

        // The packed bytes unpack to the content, with the stated checksum.
        let packed = &bytes[30 + 5..][..u32_at(18) as usize];
        let mut unpacked = Vec::new();
        let mut decoder = flate2::write::DeflateDecoder::new(&mut unpacked);
        decoder.write_all(packed).unwrap();
        decoder.finish().unwrap();
        assert_eq!(unpacked, text);
        let mut crc = Crc::new();
        crc.update(&text);
        assert_eq!(u32_at(14), crc.sum());
    }
}
