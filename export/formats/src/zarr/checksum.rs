//! CRC-32C checksum (Castagnoli; RFC 3720, appendix B.4), computed eight bytes at a time.

const POLYNOMIAL: u32 = 0x82f6_3b78;

/// Effect of a byte on the checksum when it is followed by as many zero bytes as the table's index.
const TABLES: [[u32; 256]; 8] = tables();

const fn tables() -> [[u32; 256]; 8] {
    // Plain loops, since iterators are not available in constant functions.
    let mut tables = [[0; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ POLYNOMIAL } else { crc >> 1 };
            bit += 1;
        }
        tables[0][byte] = crc;
        byte += 1;
    }
    let mut table = 1;
    while table < 8 {
        let mut byte = 0;
        while byte < 256 {
            let before = tables[table - 1][byte];
            tables[table][byte] = before >> 8 ^ tables[0][(before & 0xff) as usize];
            byte += 1;
        }
        table += 1;
    }
    tables
}

/// Computes the checksum that Zarr's codec `crc32c` appends in little-endian order.
///
/// ```
/// // The usual check value of CRC-32C.
/// assert_eq!(fabkit_export::zarr_checksum(b"123456789"), 0xe306_9283);
/// ```
pub fn zarr_checksum(bytes: &[u8]) -> u32 {
    let (eights, rest) = bytes.as_chunks::<8>();
    let mut crc = !0u32;
    for eight in eights {
        let word = u64::from_le_bytes(*eight) ^ u64::from(crc);
        crc = word
            .to_le_bytes()
            .iter()
            .zip(TABLES.iter().rev())
            .fold(0, |crc, (byte, table)| crc ^ table[usize::from(*byte)]);
    }
    !rest.iter().fold(crc, |crc, byte| crc >> 8 ^ TABLES[0][usize::from(crc as u8 ^ byte)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_castagnolis() {
        // RFC 3720, B.4: 32 bytes of zeros, of ones, and 0 to 31.
        assert_eq!(zarr_checksum(&[0; 32]), 0x8a91_36aa);
        assert_eq!(zarr_checksum(&[0xff; 32]), 0x62a8_ab43);
        assert_eq!(zarr_checksum(&(0..32).collect::<Vec<u8>>()), 0x46dd_794e);
        // The usual check value, with bytes that fill no step.
        assert_eq!(zarr_checksum(b"123456789"), 0xe306_9283);
    }
}
