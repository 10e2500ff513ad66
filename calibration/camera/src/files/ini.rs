//! ROS's ini files, as `camera_calibration` writes them, to the tree of a ROS file in YAML.

use fabkit_text::{
    MAX_NODES, Position, YamlContent, YamlEntry, YamlFault, YamlNode, suggestion, to_printable,
};

/// Key of a matrix or number, and the key of ROS's YAML.
const KEYS: [(&str, &str); 6] = [
    ("camera matrix", "camera_matrix"),
    ("distortion", "distortion_coefficients"),
    ("rectification", "rectification_matrix"),
    ("projection", "projection_matrix"),
    ("width", "image_width"),
    ("height", "image_height"),
];
/// Section with the image's size, which belongs to the cameras behind it.
const IMAGE: &str = "image";

/// Returns the name of a line's section, `[name]`.
fn section(line: &str) -> Option<&str> {
    let name = line.trim().strip_prefix('[')?.strip_suffix(']')?;
    let is_name = name.starts_with(|letter: char| letter.is_ascii_alphabetic())
        && !name.contains([',', '"', '\'', ':', '[']);
    is_name.then_some(name)
}

fn is_skipped(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with(['#', ';'])
}

/// Returns whether the first line of a text is a section.
pub(super) fn is_recognised(text: &str) -> bool {
    text.lines().find(|line| !is_skipped(line)).is_some_and(|line| section(line).is_some())
}

/// Parses a text: one mapping for each camera's section, with the image's size.
pub(super) fn parse(text: &str) -> Result<YamlNode, YamlFault> {
    let mut image: Vec<YamlEntry> = Vec::new();
    let mut cameras: Vec<YamlEntry> = Vec::new();
    let mut current: Option<YamlEntry> = None;
    let mut nodes = 0;
    for (number, line) in text.lines().enumerate() {
        let at = Position { line: number + 1, column: 1 };
        if is_skipped(line) {
            continue;
        }
        nodes += line.split_whitespace().count();
        if nodes > MAX_NODES {
            return Err(YamlFault::new(at, "", format!("more than {MAX_NODES} keys and values")));
        }
        if let Some(name) = section(line) {
            close(current.take(), &mut image, &mut cameras);
            let value = YamlNode { position: at, content: YamlContent::Map(Vec::new()) };
            current = Some(YamlEntry { key: name.into(), key_position: at, value });
            continue;
        }
        let Some(YamlEntry { value: YamlNode { content: YamlContent::Map(entries), .. }, .. }) =
            &mut current
        else {
            return Err(YamlFault::new(at, "", "this line stands before the first section"));
        };
        let line = line.trim();
        let is_number = line
            .starts_with(|first: char| first.is_ascii_digit() || "+-.".contains(first))
            || line.split_whitespace().all(|word| word.parse::<f64>().is_ok());
        if is_number {
            add_numbers(entries, line, at)?;
            continue;
        }
        let known = KEYS.iter().find(|(written, _)| written.eq_ignore_ascii_case(line));
        let key = known.map_or_else(|| line.to_owned(), |(_, key)| (*key).to_owned());
        if entries.iter().any(|entry| entry.key == key) {
            let message = format!("`{}` is written twice", to_printable(line));
            return Err(YamlFault::new(at, "", message).hint("keep one of them"));
        }
        let value = YamlNode { position: at, content: YamlContent::Nothing };
        entries.push(YamlEntry { key, key_position: at, value });
    }
    close(current, &mut image, &mut cameras);
    let position = Position { line: 1, column: 1 };
    if cameras.is_empty() {
        return Err(no_camera(position));
    }
    Ok(YamlNode { position, content: YamlContent::Map(cameras) })
}

/// Creates the fault of a file whose sections hold no camera matrix.
fn no_camera(at: Position) -> YamlFault {
    YamlFault::new(at, "", "no section has a `camera matrix`")
        .hint("expected the sections of ROS: [image] with width and height, then [NAME]")
}

/// Adds a line of numbers to the last key.
fn add_numbers(entries: &mut [YamlEntry], line: &str, at: Position) -> Result<(), YamlFault> {
    let Some(YamlEntry { key, value, .. }) = entries.last_mut() else {
        let hint = suggestion("", KEYS.map(|(written, _)| written), "known");
        return Err(YamlFault::new(at, "", "numbers without a key").hint(hint));
    };
    let words = line
        .split_whitespace()
        .map(|word| YamlNode { position: at, content: YamlContent::Scalar(word.to_owned()) });
    let is_single = matches!(key.as_str(), "image_width" | "image_height" | "fisheye_model");
    match &mut value.content {
        YamlContent::List(items) => items.extend(words),
        YamlContent::Nothing if is_single => {
            value.content = YamlContent::Scalar(line.to_owned());
            value.position = at;
        }
        _ => value.content = YamlContent::List(words.collect()),
    }
    Ok(())
}

/// Ends a section: keeps the image's size, or adds it to a camera. Other sections are dropped.
fn close(section: Option<YamlEntry>, image: &mut Vec<YamlEntry>, cameras: &mut Vec<YamlEntry>) {
    let Some(mut section) = section else { return };
    let YamlContent::Map(entries) = &mut section.value.content else { return };
    if section.key == IMAGE {
        image.clone_from(entries);
    } else if entries.iter().any(|entry| entry.key == KEYS[0].1) {
        let own = |key: &str| entries.iter().any(|entry| entry.key == key);
        let size: Vec<YamlEntry> = image.iter().filter(|entry| !own(&entry.key)).cloned().collect();
        entries.extend(size);
        cameras.push(section);
    }
}

#[cfg(test)]
mod tests {
    use crate::files::{read, read_file};

    const MONO: &str = "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n\
        [narrow_stereo]\n\ncamera matrix\n614.5 0.000000 321.25\n0.000000 614.25 235.5\n0.000000 \
        0.000000 1.000000\n\ndistortion\n0.18 -0.28 0.0008 0.0021 0.000000\n\nrectification\n\
        1.0 0.0 0.0\n0.0 1.0 0.0\n0.0 0.0 1.0\n\nprojection\n620 0 321 0\n0 620 235 0\n0 0 1 0\n";

    #[test]
    fn one_camera_needs_no_name() {
        let camera = *read(MONO).unwrap().camera();
        let intrinsics = camera.lens().intrinsics();
        assert_eq!((intrinsics.fx_px, intrinsics.cy_px), (614.5, 235.5));
        assert_eq!(camera.lens().coefficients(), [0.18, -0.28, 0.0008, 0.0021, 0.0]);
        assert_eq!((camera.width_px(), camera.height_px()), (640, 480));
    }

    #[test]
    fn fisheyes_are_stated() {
        let four = MONO.replace("0.18 -0.28 0.0008 0.0021 0.000000", "0.01 0.001 0 0");
        let stated = four.replace("distortion\n", "fisheye_model\n1\n\ndistortion\n");
        assert_eq!(read(&stated).unwrap().camera().lens().model_name(), "kannala-brandt");
        assert!(read(&four).is_err());
    }

    #[test]
    fn sections_are_names() {
        let (head, camera) = MONO.split_at(MONO.find("[narrow_stereo]").unwrap());
        let right = camera.replace("narrow_stereo", "right").replace("614.5", "600.5");
        let pair = format!("{head}{}{right}", camera.replace("narrow_stereo", "left"));
        let file = read_file(&pair, Some("right")).unwrap();
        assert_eq!(file.estimate.camera().lens().intrinsics().fx_px, 600.5);
        let error = read(&pair).unwrap_err().to_string();
        assert!(error.contains("2 cameras: `left`, `right`"), "{error}");
    }

    #[test]
    fn faults_are_named() {
        for (from, to, expected) in [
            ("0.0021 0.000000", "0.0021", "four coefficients are either"),
            ("0.0008", "nan", "distortion_coefficients: `nan` is not a finite number"),
            ("0.000000 614.25 235.5\n", "", "line 14: camera_matrix: has 6 numbers; 9 are needed"),
            ("width\n640\n", "", "image_width: is missing"),
            ("camera matrix", "camera", "no section has a `camera matrix`"),
            ("height\n", "width\n", "line 9: `width` is written twice"),
        ] {
            let error = read(&MONO.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{to}: {error}");
        }
    }
}
