//! Fabrication files of a design's circuit boards, one folder for each board.

use fabkit_boards::{
    BoardError, BoardLayout, BoardShape, STANDARD_RULES, check, fabrication_files, lay_out,
};
use fabkit_designs::Design;
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{Circuit, Sensor};

use super::{ExportRunError, MadeFile};

/// Circuit with its routed board, which keeps all design rules.
pub struct FinishedBoard<'a> {
    /// Circuit that is soldered.
    pub circuit: &'a Circuit,
    /// Board layout that is etched.
    pub layout: BoardLayout,
}

/// Lays out the board of a circuit and checks it against the circuit and the design rules. Returns `None` for a circuit
/// without a board of its own.
///
/// # Errors
/// [`BoardError`] for parts or tracks that find no room, and for broken rules.
pub fn lay_out_board(
    sensor: &Sensor,
    circuit: &Circuit,
) -> Result<Option<BoardLayout>, BoardError> {
    let Some(body) = circuit.board.as_deref().and_then(|name| sensor.body(name)) else {
        return Ok(None);
    };
    let layout = lay_out(circuit, &BoardShape::from_body(body)?, &STANDARD_RULES)?;
    let found = check(&layout, circuit, &STANDARD_RULES);
    match found.split_first() {
        None => Ok(Some(layout)),
        Some((first, others)) => Err(BoardError::RuleViolations {
            board: body.name.clone(),
            first: first.to_string(),
            more: others.len(),
        }),
    }
}

/// Lays out all boards of a sensor.
///
/// # Errors
/// See [`lay_out_board`].
///
/// ```
/// use fabkit_application::{exports::lay_out_boards, source::Target};
///
/// let sensor = Target::new("rtac0").design(&[])?.sensor;
/// let boards = lay_out_boards(&sensor)?;
/// // Every circuit with a board of its own has a layout that keeps all design rules.
/// let etched = sensor.circuits.iter().filter(|circuit| circuit.board.is_some()).count();
/// assert_eq!(boards.len(), etched);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn lay_out_boards(sensor: &Sensor) -> Result<Vec<FinishedBoard<'_>>, BoardError> {
    let finished = sensor.circuits.iter().map(|circuit| {
        Ok(lay_out_board(sensor, circuit)?.map(|layout| FinishedBoard { circuit, layout }))
    });
    finished.filter_map(Result::transpose).collect()
}

/// Makes the files of all boards, each board's in a folder with its name.
pub(super) fn make_files(
    design: &Design,
    design_hash: &str,
) -> Result<Vec<MadeFile>, ExportRunError> {
    let boards = lay_out_boards(&design.sensor)?;
    if boards.is_empty() {
        let circuits = &design.sensor.circuits;
        let wired = circuits.iter().map(|circuit| circuit.name.clone()).collect();
        return Err(ExportRunError::NoBoards { design: design.sensor.name.clone(), wired });
    }
    let mut made = Vec::new();
    for FinishedBoard { circuit, layout } in boards {
        let board = &layout.board.name;
        for file in fabrication_files(&layout, circuit, &STANDARD_RULES, design_hash) {
            let file = OutputFile { name: format!("{board}/{}", file.name), bytes: file.bytes };
            made.push(MadeFile { file, format: "gerber", parts: vec![board.clone()], stock: None });
        }
    }
    Ok(made)
}
