//! Printable areas of common printers, from their makers' data sheets.

use fabkit_application::text::suggestion;

/// Printers: name, width and depth of the bed in mm.
const BEDS: [(&str, [f64; 2]); 21] = [
    ("bambu-a1", [256.0, 256.0]),
    ("bambu-a1-mini", [180.0, 180.0]),
    ("bambu-p1", [256.0, 256.0]),
    ("bambu-x1", [256.0, 256.0]),
    ("creality-k1", [220.0, 220.0]),
    ("creality-k1-max", [300.0, 300.0]),
    ("elegoo-neptune-4", [225.0, 225.0]),
    ("ender-3", [220.0, 220.0]),
    ("form-2", [145.0, 145.0]),
    ("form-3", [145.0, 145.0]),
    ("form-3l", [335.0, 200.0]),
    ("form-4", [200.0, 125.0]),
    ("form-4l", [353.0, 196.0]),
    ("prusa-core-one", [250.0, 220.0]),
    ("prusa-mini", [180.0, 180.0]),
    ("prusa-mk4", [250.0, 210.0]),
    ("prusa-sl1s", [127.0, 80.0]),
    ("prusa-xl", [360.0, 360.0]),
    ("sovol-sv06", [220.0, 220.0]),
    ("ultimaker-s3", [230.0, 190.0]),
    ("ultimaker-s5", [330.0, 240.0]),
];

/// Finds a printer's bed, mm.
pub(super) fn find_bed(name: &str) -> Option<[f64; 2]> {
    BEDS.iter().find(|(known, _)| name.eq_ignore_ascii_case(known)).map(|(_, size_mm)| *size_mm)
}

/// Formats the message for an unknown printer.
pub(super) fn unknown_bed(name: &str) -> String {
    let names = BEDS.map(|(known, _)| known);
    format!("no printer of that name is known; {}", suggestion(name, names, "known are"))
}
