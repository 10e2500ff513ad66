//! DXF files for laser cutters and board makers: AutoCAD 2000 (AC1015), ASCII, millimetres.
//!
//! Written without a library: cutters read only four kinds of entities, and the available crates stamp files with the
//! clock. Group codes and the required tables and dictionaries follow Autodesk's "DXF Reference" for AutoCAD 2000.

use std::fmt::Write as _;

use fabkit_geometry::{Path, Segment};

use crate::drawing::{Drawing, Operation, bulge};
use crate::{DocumentInfo, ExportError, VERSION};

/// Handles of objects that others refer to. Entities are numbered from [`FIRST_ENTITY`].
const BLOCK_RECORD_TABLE: u32 = 0x1;
const MODEL_SPACE: u32 = 0x2;
const PAPER_SPACE: u32 = 0x3;
const ROOT_DICTIONARY: u32 = 0x4;
const GROUP_DICTIONARY: u32 = 0x5;
const FIRST_TABLE: u32 = 0x10;
const FIRST_ENTITY: u32 = 0x100;

/// Writes a drawing as DXF: full circles as CIRCLE, other outlines as closed LWPOLYLINE with true arcs, letters as open
/// LWPOLYLINE; one layer per operation.
///
/// Coordinates are the shortest decimals that parse to the same `f64`.
///
/// # Errors
/// [`ExportError::Nothing`] without outlines, [`ExportError::NotCuttable`] for elliptic arcs.
///
/// ```
/// use fabkit_export::{DocumentInfo, Drawing, ExportError, dxf};
/// use fabkit_geometry::{Path, Profile};
///
/// let document = DocumentInfo { title: "window", design_hash: "0123" };
/// let plate = Profile::new(Path::rectangle([0.0, 0.0], [20.0, 10.0], 1.0));
/// let file = String::from_utf8(dxf(document, &Drawing::from_piece(&plate))?)?;
/// // Unit 4 is the millimetre; a rounded rectangle has eight vertices, on layer CUT_OUTER.
/// assert!(file.contains("$INSUNITS\n 70\n4\n"));
/// assert!(file.contains("  8\nCUT_OUTER\n100\nAcDbPolyline\n 90\n8\n"));
/// assert!(matches!(dxf(document, &Drawing::default()), Err(ExportError::Nothing)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn dxf(document: DocumentInfo, drawing: &Drawing) -> Result<Vec<u8>, ExportError> {
    if drawing.contours.is_empty() {
        return Err(ExportError::Nothing);
    }
    let mut entities = Groups::default();
    let mut handle = FIRST_ENTITY;
    // Labels first: pieces that are cut out may shift.
    for stroke in &drawing.strokes {
        let vertices: Vec<_> = stroke.iter().map(|&point| (point, 0.0)).collect();
        entities.polyline(next(&mut handle), Operation::Label, &vertices, false);
    }
    for (operation, path) in &drawing.contours {
        entities.outline(next(&mut handle), *operation, path)?;
    }

    let mut file = Groups::default();
    file.comment(&format!("fabkit {VERSION}; unit mm"));
    file.comment(document.title);
    file.comment(&format!("design {}", document.design_hash));
    file.header(drawing.size_mm, handle);
    file.section("CLASSES", |_| {});
    file.section("TABLES", Groups::tables);
    file.section("BLOCKS", Groups::blocks);
    file.section("ENTITIES", |file| file.0.push_str(&entities.0));
    file.section("OBJECTS", Groups::objects);
    file.text(0, "EOF");
    Ok(file.0.into_bytes())
}

fn next(handle: &mut u32) -> u32 {
    *handle += 1;
    *handle - 1
}

/// Pairs of group code and value, two lines each.
#[derive(Default)]
struct Groups(String);

impl Groups {
    fn text(&mut self, code: u16, value: &str) {
        // Writing to a String cannot fail.
        let _ = write!(self.0, "{code:3}\n{value}\n");
    }

    fn int(&mut self, code: u16, value: u32) {
        self.text(code, &value.to_string());
    }

    /// Writes a number with a decimal point and without exponent; adding 0.0 drops the sign of -0.
    fn real(&mut self, code: u16, value: f64) {
        let value = value + 0.0;
        let text = if value.fract() == 0.0 { format!("{value:.1}") } else { value.to_string() };
        self.text(code, &text);
    }

    fn point(&mut self, [x, y]: [f64; 2]) {
        self.real(10, x);
        self.real(20, y);
    }

    fn handle(&mut self, code: u16, handle: u32) {
        self.text(code, &format!("{handle:X}"));
    }

    /// Writes a comment, which readers skip, as one line of ASCII, which every code page contains.
    fn comment(&mut self, text: &str) {
        let plain = |c: char| if c.is_ascii_graphic() || c == ' ' { c } else { '?' };
        self.text(999, &text.chars().map(plain).collect::<String>());
    }

    fn section(&mut self, name: &str, fill: impl FnOnce(&mut Self)) {
        self.text(0, "SECTION");
        self.text(2, name);
        fill(self);
        self.text(0, "ENDSEC");
    }

    /// Writes the header: version, units and extent.
    fn header(&mut self, size_mm: [f64; 2], next_handle: u32) {
        self.section("HEADER", |file| {
            let mut variable = |name: &str, code: u16, value: &str| {
                file.text(9, name);
                file.text(code, value);
            };
            variable("$ACADVER", 1, "AC1015");
            variable("$DWGCODEPAGE", 3, "ANSI_1252");
            variable("$HANDSEED", 5, &format!("{next_handle:X}"));
            variable("$INSUNITS", 70, "4"); // millimetres
            variable("$MEASUREMENT", 70, "1"); // metric
            variable("$LUNITS", 70, "2"); // decimal
            for (name, corner) in [("$EXTMIN", [0.0, 0.0]), ("$EXTMAX", size_mm)] {
                file.text(9, name);
                file.point(corner);
                file.real(30, 0.0);
            }
        });
    }

    /// Writes the tables that AutoCAD requires; only layers carry information.
    fn tables(&mut self) {
        let mut handle = FIRST_TABLE;
        self.table("VPORT", next(&mut handle), 0);
        self.end_table();
        self.table("LTYPE", next(&mut handle), 3);
        for name in ["ByBlock", "ByLayer", "Continuous"] {
            self.record("LTYPE", next(&mut handle), "AcDbLinetypeTableRecord", name);
            self.text(3, "");
            // A continuous line: fixed alignment code, no dashes, pattern length 0.
            self.int(72, 65);
            self.int(73, 0);
            self.real(40, 0.0);
        }
        self.end_table();
        self.table("LAYER", next(&mut handle), 1 + Operation::ALL.len() as u32);
        let layers = Operation::ALL.map(|o| (o.layer(), o.color_index()));
        for (name, color) in std::iter::once(("0", 7)).chain(layers) {
            self.record("LAYER", next(&mut handle), "AcDbLayerTableRecord", name);
            self.int(62, color.into());
            self.text(6, "Continuous");
        }
        self.end_table();
        self.table("STYLE", next(&mut handle), 1);
        self.record("STYLE", next(&mut handle), "AcDbTextStyleTableRecord", "Standard");
        // No fixed height, width factor 1, not oblique.
        for (code, value) in [(40, 0.0), (41, 1.0), (50, 0.0)] {
            self.real(code, value);
        }
        self.int(71, 0);
        self.real(42, 2.5);
        self.text(3, "txt");
        self.text(4, "");
        self.end_table();
        self.table("VIEW", next(&mut handle), 0);
        self.end_table();
        self.table("UCS", next(&mut handle), 0);
        self.end_table();
        self.table("APPID", next(&mut handle), 1);
        self.record("APPID", next(&mut handle), "AcDbRegAppTableRecord", "ACAD");
        self.end_table();
        self.table("DIMSTYLE", next(&mut handle), 1);
        self.text(100, "AcDbDimStyleTable");
        self.int(71, 0);
        self.text(0, "DIMSTYLE");
        self.handle(105, next(&mut handle)); // 5 is taken in this table
        self.record_body("AcDbDimStyleTableRecord", "Standard");
        self.end_table();
        self.table("BLOCK_RECORD", BLOCK_RECORD_TABLE, 2);
        for (name, handle) in [("*Model_Space", MODEL_SPACE), ("*Paper_Space", PAPER_SPACE)] {
            self.text(0, "BLOCK_RECORD");
            self.handle(5, handle);
            self.handle(330, BLOCK_RECORD_TABLE);
            self.text(100, "AcDbSymbolTableRecord");
            self.text(100, "AcDbBlockTableRecord");
            self.text(2, name);
        }
        self.end_table();
    }

    fn table(&mut self, name: &str, handle: u32, entries: u32) {
        self.text(0, "TABLE");
        self.text(2, name);
        self.handle(5, handle);
        self.handle(330, 0);
        self.text(100, "AcDbSymbolTable");
        self.int(70, entries);
    }

    fn record(&mut self, kind: &str, handle: u32, class: &str, name: &str) {
        self.text(0, kind);
        self.handle(5, handle);
        self.record_body(class, name);
    }

    fn record_body(&mut self, class: &str, name: &str) {
        self.text(100, "AcDbSymbolTableRecord");
        self.text(100, class);
        self.text(2, name);
        self.int(70, 0);
    }

    fn end_table(&mut self) {
        self.text(0, "ENDTAB");
    }

    /// Writes the two blocks that every drawing has; the content of model space is listed under ENTITIES.
    fn blocks(&mut self) {
        // Far enough above the handles of `tables`, and below those of entities.
        let mut handle = FIRST_TABLE + 0x80;
        for (name, owner) in [("*Model_Space", MODEL_SPACE), ("*Paper_Space", PAPER_SPACE)] {
            for kind in ["BLOCK", "ENDBLK"] {
                self.text(0, kind);
                self.handle(5, next(&mut handle));
                self.handle(330, owner);
                self.text(100, "AcDbEntity");
                self.text(8, "0");
                if kind == "ENDBLK" {
                    self.text(100, "AcDbBlockEnd");
                    continue;
                }
                self.text(100, "AcDbBlockBegin");
                self.text(2, name);
                self.int(70, 0);
                self.point([0.0, 0.0]);
                self.real(30, 0.0);
                self.text(3, name);
                self.text(1, "");
            }
        }
    }

    /// Writes the root dictionary with an empty group dictionary.
    fn objects(&mut self) {
        self.text(0, "DICTIONARY");
        self.handle(5, ROOT_DICTIONARY);
        self.handle(330, 0);
        self.text(100, "AcDbDictionary");
        self.int(281, 1);
        self.text(3, "ACAD_GROUP");
        self.handle(350, GROUP_DICTIONARY);
        self.text(0, "DICTIONARY");
        self.handle(5, GROUP_DICTIONARY);
        self.handle(330, ROOT_DICTIONARY);
        self.text(100, "AcDbDictionary");
        self.int(281, 1);
    }

    /// Writes a closed outline as a circle if it is one, otherwise as a polyline with bulges.
    fn outline(&mut self, handle: u32, on: Operation, path: &Path) -> Result<(), ExportError> {
        if let Some((centre, radius_mm)) = whole_circle(path) {
            self.entity("CIRCLE", handle, on, "AcDbCircle");
            self.point(centre);
            self.real(30, 0.0);
            self.real(40, radius_mm);
            return Ok(());
        }
        let mut vertices = Vec::with_capacity(path.segments.len());
        let mut from = path.start;
        for segment in &path.segments {
            vertices.push((from, bulge(from, segment)?));
            from = segment.to();
        }
        self.polyline(handle, on, &vertices, true);
        Ok(())
    }

    fn polyline(
        &mut self,
        handle: u32,
        on: Operation,
        vertices: &[([f64; 2], f64)],
        is_closed: bool,
    ) {
        self.entity("LWPOLYLINE", handle, on, "AcDbPolyline");
        self.int(90, vertices.len() as u32);
        self.int(70, is_closed.into());
        self.real(43, 0.0); // drawn without width
        for &(point, bulge) in vertices {
            self.point(point);
            if bulge != 0.0 {
                self.real(42, bulge);
            }
        }
    }

    fn entity(&mut self, kind: &str, handle: u32, on: Operation, class: &str) {
        self.text(0, kind);
        self.handle(5, handle);
        self.handle(330, MODEL_SPACE);
        self.text(100, "AcDbEntity");
        self.text(8, on.layer());
        self.text(100, class);
    }
}

/// Returns centre and radius of a path whose arcs all run the same way around one centre.
fn whole_circle(path: &Path) -> Option<([f64; 2], f64)> {
    let Some(Segment::Arc { centre, ccw, .. }) = path.segments.first() else { return None };
    let radius_mm = (path.start[0] - centre[0]).hypot(path.start[1] - centre[1]);
    // Offsetting recomputes the centre of each arc, so centres agree only within rounding.
    let near = |a: &[f64; 2]| (a[0] - centre[0]).hypot(a[1] - centre[1]) < 1e-9 * radius_mm;
    let same = |segment: &Segment| match segment {
        Segment::Arc { centre: other, ccw: turn, .. } => near(other) && turn == ccw,
        _ => false,
    };
    path.segments.iter().all(same).then_some((*centre, radius_mm))
}
