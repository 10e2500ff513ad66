//! Lists of corners that another program detected.

use std::collections::BTreeMap;

use fabkit_camera::Point2;

use super::{Board, DetectedCorner};
use crate::captures::InvalidList;

/// Largest list, bytes.
pub const MAX_LIST_BYTES: usize = 64 << 20;
/// Default standard deviation, px: what good detectors reach.
const USUAL_SIGMA_PX: f64 = 0.1;
/// Largest coordinate in an image, px.
const MAX_COORDINATE_PX: f64 = 1e5;
/// Smallest and largest standard deviation, px.
const SIGMA_LIMITS_PX: [f64; 2] = [1e-6, 1e3];
/// Number of problems after which reading stops: nobody reads more.
const MAX_PROBLEMS: usize = 20;

/// Required columns, in their order.
const COLUMNS: [&str; 4] = ["view", "corner", "x_px", "y_px"];
/// Optional last column.
const SIGMA: &str = "sigma_px";

/// Reads a list of corners: CSV with the columns `view`, `corner`, `x_px`, `y_px` and optionally `sigma_px`, in this
/// order, one row for each corner of `board` in a view. The centre of the first pixel is (0, 0), as in OpenCV. Lines
/// that begin with `#` are comments.
///
/// # Errors
/// Returns an [`InvalidList`] with the first invalid lines.
///
/// ```
/// use fabkit_calibration::board::{Board, read_corners};
/// let board = Board::checkerboard("test", [5, 4], 3.0).unwrap();
/// let views = read_corners("view,corner,x_px,y_px\na,0,100.5,80.25\na,1,120,81\n", &board).unwrap();
/// assert_eq!(views["a"][1].pixel.x, 120.0);
/// ```
pub fn read_corners(
    text: &str,
    board: &Board,
) -> Result<BTreeMap<String, Vec<DetectedCorner>>, InvalidList> {
    let refuse = |problem: String| InvalidList { problems: vec![problem] };
    if text.len() > MAX_LIST_BYTES {
        return Err(refuse(format!("{} bytes; at most {MAX_LIST_BYTES} are read", text.len())));
    }
    let meant = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    let mut lines =
        (1..).zip(text.trim_start_matches('\u{feff}').lines()).filter(|(_, line)| meant(line));
    let (first, header) = lines.next().ok_or_else(|| refuse("the list is empty".into()))?;
    let columns: Vec<&str> = header.split(',').map(str::trim).collect();
    let with_sigma = columns.len() == COLUMNS.len() + 1 && columns[COLUMNS.len()] == SIGMA;
    if columns[..COLUMNS.len().min(columns.len())] != COLUMNS
        || columns.len() > COLUMNS.len() && !with_sigma
    {
        let expected = COLUMNS.join(",");
        return Err(refuse(format!(
            "line {first}: the columns are `{header}`; expected `{expected}` or `{expected},{SIGMA}`"
        )));
    }
    let mut views: BTreeMap<String, Vec<DetectedCorner>> = BTreeMap::new();
    let mut problems = Vec::new();
    for (number, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        match row(&cells, columns.len(), board) {
            Ok((view, corner)) => {
                let corners = views.entry(view.to_owned()).or_default();
                if corners.iter().any(|other| other.id == corner.id) {
                    let id = corner.id;
                    problems.push(format!("line {number}: {view} has corner {id} twice"));
                }
                corners.push(corner);
            }
            Err(problem) => problems.push(format!("line {number}: {problem}")),
        }
        if problems.len() == MAX_PROBLEMS {
            break;
        }
    }
    if views.is_empty() && problems.is_empty() {
        problems.push("no rows below the columns' names".into());
    }
    for corners in views.values_mut() {
        corners.sort_by_key(|corner| corner.id);
    }
    if problems.is_empty() { Ok(views) } else { Err(InvalidList { problems }) }
}

/// Reads a row: the view and its corner.
fn row<'a>(
    cells: &[&'a str],
    count: usize,
    board: &Board,
) -> Result<(&'a str, DetectedCorner), String> {
    if cells.len() != count {
        return Err(format!("{} cells; there are {count} columns", cells.len()));
    }
    let number = |column: usize, limits: [f64; 2]| {
        let value: f64 = cells[column]
            .parse()
            .map_err(|_| format!("`{}` is not a number of pixels", cells[column]))?;
        let [least, most] = limits;
        let message = || format!("{value} px; the limits are {least} and {most}");
        (least..=most).contains(&value).then_some(value).ok_or_else(message)
    };
    let last = board.corners.len() - 1;
    let id = cells[1].parse::<u32>().ok().filter(|id| *id as usize <= last);
    let id = id.ok_or_else(|| {
        format!("`{}` is no corner of this board; they are numbered 0 to {last}", cells[1])
    })?;
    let coordinates = [-MAX_COORDINATE_PX, MAX_COORDINATE_PX];
    let sigma_px = if count > COLUMNS.len() {
        number(COLUMNS.len(), SIGMA_LIMITS_PX)?
    } else {
        USUAL_SIGMA_PX
    };
    let pixel = Point2::new(number(2, coordinates)?, number(3, coordinates)?);
    Ok((cells[0], DetectedCorner { id, pixel, sigma_px }))
}
