//! Text of camera and pose files to a tree.

use fabkit_text::{Dialect, YamlContent, YamlNode};

use super::{InvalidCameraFile, YamlFault};

/// Parses a text as YAML, then reads its content with `read`. Duplicate keys are faults too.
pub(super) fn parse<T>(
    text: &str,
    read: impl Fn(&YamlNode) -> Result<T, InvalidCameraFile>,
) -> Result<T, InvalidCameraFile> {
    let (root, twice) = parse_tree(text)?;
    with_duplicates(read(&root), twice)
}

/// Parses a text as YAML. The faults are those of keys written twice.
pub(super) fn parse_tree(text: &str) -> Result<(YamlNode, Vec<YamlFault>), YamlFault> {
    const CAMERA: Dialect = Dialect { tags: &["opencv-matrix"], ..Dialect::new("camera", 1, "") };
    // Long texts are refused as they are.
    let one = if text.len() > fabkit_text::MAX_BYTES { None } else { one_document(text) };
    let (root, twice) = fabkit_text::parse(one.as_deref().unwrap_or(text), &CAMERA)?;
    if root.content == YamlContent::Nothing {
        return Err(YamlFault::new(None, "", "the file is empty"));
    }
    Ok((root, twice))
}

/// Adds the faults of keys written twice to what was read.
pub(super) fn with_duplicates<T>(
    read: Result<T, InvalidCameraFile>,
    twice: Vec<YamlFault>,
) -> Result<T, InvalidCameraFile> {
    match read {
        Ok(read) if twice.is_empty() => Ok(read),
        Ok(_) => Err(InvalidCameraFile { faults: twice }),
        Err(InvalidCameraFile { mut faults }) => {
            faults.extend(twice);
            // Duplicate keys are found first, but belong between the other faults.
            faults.sort_by_key(fault_line);
            Err(InvalidCameraFile { faults })
        }
    }
}

/// Returns the line of a fault; faults of the whole file sort first.
pub(super) fn fault_line(fault: &YamlFault) -> Option<usize> {
    fault.position.map(|at| at.line)
}

/// Blanks all lines that are not part of the first document: `%YAML:1.0`, which is not YAML, `---`, `...` and messages
/// that repeat the first, as `ros2 topic echo` prints them. `None` if documents differ, which the parser reports.
fn one_document(text: &str) -> Option<String> {
    let is_marker = |line: &str| matches!(line.trim_end(), "---" | "...");
    let is_content = |line: &str| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    };
    // Editors on Windows may write a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut documents: Vec<(usize, Vec<&str>)> = vec![(0, Vec::new())];
    for (number, line) in text.lines().enumerate() {
        let is_empty = documents.iter().all(|(_, lines)| !lines.iter().any(|l| is_content(l)));
        if is_marker(line) {
            documents.push((number + 1, Vec::new()));
        } else if line.starts_with('%') && is_empty {
            // A directive of OpenCV, in place of a line of the document.
            documents.last_mut()?.1.push("");
        } else {
            documents.last_mut()?.1.push(line);
        }
    }
    documents.retain(|(_, lines)| lines.iter().any(|line| is_content(line)));
    let (start, first) = documents.first()?;
    // Messages of one camera differ in their time stamps alone.
    let without_stamps = |lines: &[&str]| -> Vec<String> {
        let stamps = ["sec:", "nanosec:", "secs:", "nsecs:", "seq:"];
        let is_stamp = |line: &&str| stamps.iter().any(|stamp| line.trim().starts_with(stamp));
        lines.iter().filter(|line| !is_stamp(line)).map(|line| line.trim().to_owned()).collect()
    };
    let same = without_stamps(first);
    if documents[1..].iter().any(|(_, other)| without_stamps(other) != same) {
        return Some(text.replacen('%', "#", usize::from(text.starts_with('%'))));
    }
    Some("\n".repeat(*start) + &first.join("\n") + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_at_the_ends_and_repeated_messages_are_one_document() {
        for text in [
            "a: 1\n---\n",
            "a: 1\n...\n",
            "---\na: 1\n...\n---\n",
            "%YAML:1.0\n---\na: 1\n",
            "%YAML:1.0\na: 1\n",
            "\u{feff}---\r\na: 1\r\n---\r\n",
            "sec: 3\na: 1\n---\nsec: 4\na: 1\n---\n",
        ] {
            let (root, twice) = parse_tree(text).unwrap();
            assert_eq!(root.get("a").and_then(YamlNode::text), Some("1"), "{text:?}");
            assert_eq!(twice, []);
        }
        let error = parse_tree("a: 1\n---\na: 2\n").unwrap_err().to_string();
        assert!(error.starts_with("line 2: a second document"), "{error}");
        // Lines are those of the file.
        let (root, _) = parse_tree("%YAML:1.0\n---\n# text\na: 1\n---\n").unwrap();
        assert_eq!(root.entries()[0].key_position.line, 4);
    }
}
