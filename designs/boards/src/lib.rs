//! Circuit boards from circuits: copper, its rules, its netlist, and fabrication files.
//!
//! [`lay_out`] places the parts that the sensor does not place itself, and routes tracks over a grid that follows the
//! board: rings and rays on an annular board, rows and columns elsewhere. [`check`] then examines the finished copper
//! alone. It does not rely on the nets for which tracks were laid: it determines which copper is connected, and
//! compares that with the circuit. [`fabrication_files`] writes Gerber X2, Excellon, the job file and tables.
//!
//! ```
//! use fabkit_boards::{BoardFlaw, BoardShape, STANDARD_RULES, check, fabrication_files, lay_out};
//! use fabkit_geometry::{
//!     BoardPlacement, BoardSide, Body, Circuit, CircuitKind, CircuitPart, Land, Net, Path,
//!     Process, Solid,
//! };
//! // Two pads for wires, 10 mm apart on a board of 20 x 10 mm, and the net that joins them.
//! let land = Land { pin: "1".into(), at_mm: [0.0; 2], size_mm: [1.0; 2], is_round: false };
//! let pad = |designator: &str, x_mm: f64| CircuitPart {
//!     designator: designator.into(),
//!     kind: CircuitKind::WirePad,
//!     value: "wire".into(),
//!     package: "pad".into(),
//!     lands: vec![land.clone()],
//!     size_mm: [0.0; 2],
//!     place: Some(BoardPlacement { at_mm: [x_mm, 0.0], turn_rad: 0.0, side: BoardSide::Top }),
//!     body: None,
//! };
//! let pins = ["W1", "W2"].map(|part| (part.to_owned(), "1".to_owned())).to_vec();
//! let circuit = Circuit {
//!     name: "jumper".into(),
//!     board: Some("jumper".into()),
//!     supply_v: 5.0,
//!     supply_a: None,
//!     parts: vec![pad("W1", -5.0), pad("W2", 5.0)],
//!     nets: vec![Net { name: "V+".into(), pins, current_a: 0.1 }],
//!     resistors: Vec::new(),
//!     current_a: 0.1,
//!     keep_outs: Vec::new(),
//!     connections: Vec::new(),
//!     notes: Vec::new(),
//! };
//! let plate = Solid::extrusion(Path::rectangle([0.0; 2], [20.0, 10.0], 1.0), 1.6);
//! let plate = Body::made("jumper", "joins two wires", Process::Pcb, plate);
//! let mut layout = lay_out(&circuit, &BoardShape::from_body(&plate)?, &STANDARD_RULES)?;
//! assert_eq!(check(&layout, &circuit, &STANDARD_RULES), []);
//! let files = fabrication_files(&layout, &circuit, &STANDARD_RULES, "00");
//! assert!(files.iter().any(|file| file.name == "jumper-F_Cu.gbr"));
//!
//! // Without its track, the net is on two pieces of copper.
//! layout.tracks.clear();
//! let found = check(&layout, &circuit, &STANDARD_RULES);
//! assert_eq!(found[0].flaw, BoardFlaw::Open);
//! # Ok::<(), fabkit_boards::BoardError>(())
//! ```

#![forbid(unsafe_code)]

mod artwork;
mod check;
mod connectivity;
mod error;
mod files;
mod font;
mod gerber;
mod grid;
mod layout;
mod outline;
mod place_and_route;
mod placement;
mod route;
mod rules;
mod shapes;
mod silk;
mod tables;

pub use artwork::svg;
pub use check::{BoardFinding, BoardFlaw, check};
pub use error::BoardError;
pub use files::{BoardFile, fabrication_files};
pub use layout::{BoardLayout, Drill, MAX_DRILL_MM, Pad, PlacedPart, SIDES, SilkLine, Track, Via};
pub use outline::{BoardShape, RoundHole};
pub use place_and_route::lay_out;
pub use rules::{BoardRules, STANDARD_RULES, min_track_width_mm};
pub use shapes::{Point, Shape};
