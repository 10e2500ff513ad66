//! Lists of captures: which pins were in which image, as people write it down.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point2;

/// Largest list, bytes.
pub const MAX_BYTES: usize = 1 << 20;
/// Largest number of rows in a list.
pub const MAX_ROWS: usize = 20_000;

/// Pin of a capture in a list.
///
/// ```
/// use fabkit_calibration::captures::read_list;
/// let list = read_list("file,hole,x_px,y_px,sigma_px\na.png,4,310.5,222,0.1\na.png,9,80,64,\n")?;
/// let [first, second] = [&list["a.png"][0], &list["a.png"][1]];
/// assert_eq!(first.pixel.unwrap().0.x, 310.5);
/// // A position measured by hand counts as good to 0.3 px unless the list says otherwise.
/// assert_eq!((first.pixel.unwrap().1, second.pixel.unwrap().1), (0.1, 0.3));
/// # Ok::<(), fabkit_calibration::captures::InvalidList>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPin {
    /// Number of the hole.
    pub hole: u32,
    /// Kind of pin, if the fixture has several.
    pub kind: Option<String>,
    /// Position of its mark and standard deviation, px, if somebody measured them. The image is then not searched.
    pub pixel: Option<(Point2<f64>, f64)>,
}

/// Errors of a list of captures or of corners.
///
/// ```
/// use fabkit_calibration::captures::read_list;
/// let wrong = read_list("file,hole\na.png,1\na.png,one\na.png,1\n").unwrap_err();
/// let expected = ["line 3: `one` is not the number of a hole", "line 4: hole 1 stands there twice"];
/// assert_eq!(wrong.problems, expected);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", fabkit_text::list_problems(.problems, "\n"))]
pub struct InvalidList {
    /// Problems, at least one, each with its line.
    pub problems: Vec<String>,
}

/// Reads the hole numbers from a file name: `01_05_08_17_26` or `7-12-20`, two or more, in any order.
///
/// Returns `None` if the name contains anything else, for example `ref`.
///
/// ```
/// use fabkit_calibration::captures::holes_from_name;
/// assert_eq!(holes_from_name("01_05_08_17_26"), Some(vec![1, 5, 8, 17, 26]));
/// assert_eq!(holes_from_name("ref"), None);
/// assert_eq!(holes_from_name("3_3"), None); // no hole holds two pins
/// ```
pub fn holes_from_name(stem: &str) -> Option<Vec<u32>> {
    let holes: Option<Vec<u32>> = stem
        .split(['_', '-', ' '])
        .map(|word| word.parse::<u32>().ok().filter(|hole| (1..100_000).contains(hole)))
        .collect();
    let holes = holes.filter(|holes| holes.len() > 1)?;
    let distinct: BTreeSet<u32> = holes.iter().copied().collect();
    (distinct.len() == holes.len()).then_some(holes)
}

/// Reads a list of captures: CSV with the columns `file`, `hole`, and optionally `kind`, `x_px`, `y_px` and `sigma_px`;
/// one row for each pin. Lines that begin with `#` are comments.
///
/// # Errors
/// Returns an [`InvalidList`] with all invalid lines.
///
/// ```
/// use fabkit_calibration::captures::read_list;
/// let list = read_list("file,hole,kind\na.png,1,long\na.png,7,short\n").unwrap();
/// assert_eq!(list["a.png"][1].hole, 7);
/// ```
pub fn read_list(text: &str) -> Result<BTreeMap<String, Vec<ListedPin>>, InvalidList> {
    let refuse = |problem: String| InvalidList { problems: vec![problem] };
    if text.len() > MAX_BYTES {
        return Err(refuse(format!("{} bytes; at most {MAX_BYTES} are read", text.len())));
    }
    let meant = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| meant(line));
    let (_, header) = lines.next().ok_or_else(|| refuse("no columns in the first line".into()))?;
    let columns: Vec<&str> =
        header.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
    let known = ["file", "hole", "kind", "x_px", "y_px", "sigma_px"];
    let mut problems: Vec<String> = columns
        .iter()
        .filter(|column| !known.contains(column))
        .map(|column| format!("line 1: unknown column `{column}`; known: {}", known.join(", ")))
        .collect();
    let at = |name: &str| columns.iter().position(|column| *column == name);
    for name in ["file", "hole"] {
        if at(name).is_none() {
            problems.push(format!("line 1: the column `{name}` is missing"));
        }
    }
    if at("x_px").is_some() != at("y_px").is_some() {
        problems.push("line 1: `x_px` and `y_px` come together".into());
    }
    if !problems.is_empty() {
        return Err(InvalidList { problems });
    }
    let mut list: BTreeMap<String, Vec<ListedPin>> = BTreeMap::new();
    // One row more than allowed is enough to notice that there are too many.
    for (number, line) in lines.take(MAX_ROWS + 1) {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let cell =
            |name: &str| at(name).and_then(|i| cells.get(i)).copied().filter(|c| !c.is_empty());
        match row(&cell, cells.len() == columns.len()) {
            Ok((file, pin)) => {
                let pins = list.entry(file).or_default();
                if pins.iter().any(|other| other.hole == pin.hole) {
                    problems.push(format!("line {number}: hole {} stands there twice", pin.hole));
                }
                pins.push(pin);
            }
            Err(problem) => problems.push(format!("line {number}: {problem}")),
        }
    }
    let rows: usize = list.values().map(Vec::len).sum();
    if rows > MAX_ROWS {
        problems.push(format!("more than {MAX_ROWS} rows"));
    }
    if rows == 0 && problems.is_empty() {
        problems.push("no rows".into());
    }
    if problems.is_empty() { Ok(list) } else { Err(InvalidList { problems }) }
}

/// Reads a row: the file and its pin.
fn row<'a>(
    cell: &dyn Fn(&str) -> Option<&'a str>,
    complete: bool,
) -> Result<(String, ListedPin), String> {
    if !complete {
        return Err("as many cells as there are columns are needed".into());
    }
    let file = cell("file").ok_or("no file")?;
    // A list must not lead out of its folder.
    if file.contains(['/', '\\']) {
        return Err(format!("`{file}`: names of files in the same folder only"));
    }
    let hole = cell("hole").unwrap_or_default();
    let hole: u32 = hole.parse().map_err(|_| format!("`{hole}` is not the number of a hole"))?;
    let number = |name: &str, limits: std::ops::RangeInclusive<f64>| {
        let Some(text) = cell(name) else { return Ok(None) };
        let value = text.parse::<f64>().ok().filter(|value| limits.contains(value));
        value.map(Some).ok_or_else(|| {
            format!("{name} is `{text}`; it must be {} to {}", limits.start(), limits.end())
        })
    };
    let (x, y) = (number("x_px", -1e5..=1e5)?, number("y_px", -1e5..=1e5)?);
    // Default precision of a position that somebody measured by hand, px.
    let sigma_px = number("sigma_px", 1e-3..=100.0)?.unwrap_or(0.3);
    let pixel = match (x, y) {
        (Some(x), Some(y)) => Some((Point2::new(x, y), sigma_px)),
        (None, None) => None,
        _ => return Err("x_px and y_px come together".into()),
    };
    Ok((file.into(), ListedPin { hole, kind: cell("kind").map(Into::into), pixel }))
}
