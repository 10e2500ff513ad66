//! Dictionaries of markers whose bits are known here: OpenCV's 4 x 4 dictionaries of 50, 100 and 250 markers, and the
//! original one of ArUco.
//!
//! The smaller of the 4 x 4 dictionaries are the beginning of the larger ones. Their bits are those that OpenCV returns
//! for `cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250)` through
//! `cv2.aruco.Dictionary.getBitsFromByteList(dictionary.bytesList[i:i + 1], 4)`; `tests/oracles/check_boards.py`
//! compares every dictionary with it.

/// Number of bits along the side of a marker of the 4 x 4 dictionaries.
pub const SIDE: usize = 4;

/// Number of fields along the side of such a marker, including its dark border.
pub const FIELDS: usize = SIDE + 2;

/// Names of the 4 x 4 dictionaries with their numbers of markers.
const SIZES: [(&str, usize); 3] =
    [("DICT_4X4_50", 50), ("DICT_4X4_100", 100), ("DICT_4X4_250", MARKERS.len())];
/// Name of the dictionary of the first ArUco library, in OpenCV.
const ORIGINAL: &str = "DICT_ARUCO_ORIGINAL";
/// Rows of an original marker. Each row carries two bits of the marker's number, from the highest (Munoz-Salinas,
/// ArUco, after Garrido-Jurado et al. 2014).
const ORIGINAL_ROWS: [&str; 4] = ["10000", "10111", "01001", "01110"];

/// Largest number of markers of a 4 x 4 dictionary.
pub const MOST: usize = MARKERS.len();

/// Names of the dictionaries whose bits are known here.
pub const KNOWN: [&str; 4] = [SIZES[0].0, SIZES[1].0, SIZES[2].0, ORIGINAL];

/// Returns the name of the smallest 4 x 4 dictionary with at least `count` markers: markers of a smaller dictionary
/// differ more from each other.
///
/// ```
/// use fabkit_calibration::board::dictionary::name_for;
/// assert_eq!(name_for(24), Some("DICT_4X4_50"));
/// assert_eq!(name_for(251), None);
/// ```
pub fn name_for(count: usize) -> Option<&'static str> {
    SIZES.iter().find(|(_, size)| count <= *size).map(|(name, _)| *name)
}

/// Returns the rows of each marker of the 4 x 4 dictionaries from the top, with `1` for a light field.
pub fn rows() -> Vec<Vec<String>> {
    let rows = |marker: &u16| {
        let text = format!("{marker:016b}");
        (0..SIDE).map(|row| text[row * SIDE..][..SIDE].to_owned()).collect()
    };
    MARKERS.iter().map(rows).collect()
}

/// Returns the rows of each marker of a dictionary, by its name in OpenCV. `None` for a dictionary whose bits are not
/// known here.
///
/// ```
/// use fabkit_calibration::board::dictionary::rows_of;
/// let original = rows_of("DICT_ARUCO_ORIGINAL").ok_or("unknown")?;
/// assert_eq!(original.len(), 1024);
/// // 450 is 01 11 00 00 10 in pairs of bits.
/// assert_eq!(original[450], ["10111", "01110", "10000", "10000", "01001"]);
/// assert_eq!(rows_of("DICT_6X6_250"), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn rows_of(name: &str) -> Option<Vec<Vec<String>>> {
    if name == ORIGINAL {
        let row = |id: usize, pair: usize| ORIGINAL_ROWS[id >> (8 - 2 * pair) & 3].to_owned();
        return Some((0..1 << 10).map(|id| (0..5).map(|pair| row(id, pair)).collect()).collect());
    }
    let (_, size) = SIZES.iter().find(|(known, _)| *known == name)?;
    Some(rows().into_iter().take(*size).collect())
}

/// Bits of each marker, row by row from the top left, most significant bit first.
#[rustfmt::skip]
const MARKERS: [u16; 250] = [
    0xb532, 0x0f9a, 0x332d, 0x9946, 0x549e, 0x79cd, 0x9e2e, 0xc4f2, 0xfeda, 0xcf56,
    0xf991, 0x11a7, 0x0eb7, 0x2a0f, 0x24b1, 0x263e, 0x4665, 0x6600, 0x6c5e, 0x76af,
    0x868b, 0xb02b, 0xccd5, 0xdd82, 0xfe47, 0x9471, 0xace4, 0xa554, 0x2123, 0x346f,
    0x4415, 0x57b2, 0x9ecf, 0xf0cb, 0x08ae, 0x0929, 0x1875, 0x04ff, 0x0df6, 0x1c5a,
    0x1718, 0x2a28, 0x328c, 0x38b2, 0x24e8, 0x2eeb, 0x2d3f, 0x4b64, 0x502e, 0x5013,
    0x5194, 0x5568, 0x5d41, 0x5f97, 0x6801, 0x6867, 0x6124, 0x61e9, 0x6b12, 0x6fe5,
    0x67df, 0x7e1b, 0x80a0, 0x8344, 0x8ba2, 0x937a, 0x846c, 0x852a, 0x859c, 0x9c89,
    0x9fa1, 0xbb7c, 0xbc04, 0xb65b, 0xbfc8, 0xb7ab, 0xca1f, 0xc962, 0xd958, 0xd3d5,
    0xcc98, 0xc7a0, 0xc537, 0xe95d, 0xf925, 0xfbbb, 0xee2a, 0xf74d, 0x3575, 0x8aad,
    0x7617, 0x0acf, 0x064b, 0x2dc1, 0x49d8, 0x43f4, 0x4f36, 0x4fd3, 0x69e4, 0x70c7,
    0x7a6e, 0xb4ea, 0xed4f, 0xfce7, 0xfea6, 0x0025, 0x0043, 0x0a88, 0x0a86, 0x026f,
    0x001c, 0x0097, 0x0837, 0x0a31, 0x09c6, 0x0b01, 0x09fb, 0x0b58, 0x1082, 0x182d,
    0x1078, 0x1073, 0x1274, 0x12b1, 0x1af9, 0x1306, 0x0c0e, 0x0cf1, 0x0433, 0x0c9f,
    0x0ef2, 0x0efd, 0x074c, 0x0fa4, 0x072f, 0x05b5, 0x0f91, 0x07db, 0x1ee4, 0x1439,
    0x1d80, 0x15c8, 0x1f8b, 0x15ba, 0x1db1, 0x2080, 0x28e9, 0x22a2, 0x2853, 0x2af0,
    0x22f7, 0x2940, 0x2146, 0x29b9, 0x2b9c, 0x2bb2, 0x38ca, 0x382e, 0x3007, 0x38e7,
    0x3a49, 0x3a65, 0x325d, 0x3b88, 0x391d, 0x3bd3, 0x2647, 0x2780, 0x2faa, 0x2d14,
    0x25de, 0x2553, 0x2f77, 0x3448, 0x3ca8, 0x3c41, 0x340d, 0x34fb, 0x369a, 0x3de0,
    0x356a, 0x3d09, 0x3ded, 0x3fc4, 0x3f6c, 0x37ce, 0x3d5c, 0x3d76, 0x37b0, 0x3f17,
    0x3fff, 0x48e5, 0x4268, 0x4a2d, 0x4160, 0x4951, 0x41dd, 0x4bdf, 0x584f, 0x5a48,
    0x5816, 0x505d, 0x5afa, 0x5ab5, 0x5123, 0x5b8a, 0x5919, 0x5135, 0x4c69, 0x46c1,
    0x4e0b, 0x445f, 0x4e59, 0x4d83, 0x4d7d, 0x47d8, 0x4773, 0x5c85, 0x5e44, 0x562b,
    0x5cbb, 0x55c3, 0x5f6e, 0x5feb, 0x5d12, 0x555e, 0x6270, 0x6215, 0x61c2, 0x6b20,
    0x6345, 0x6b5c, 0x6b5b, 0x780c, 0x7acf, 0x787f, 0x7980, 0x71e5, 0x7174, 0x79b6,
    0x71d3, 0x7b33, 0x646a, 0x66a8, 0x6ea7, 0x6e91, 0x6522, 0x6dcb, 0x678d, 0x6d31,
];
