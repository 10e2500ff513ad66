//! Minimal readers of the written files, by the rules of their formats.

use std::f64::consts::PI;

/// A closed curve as points, each with the bulge of the segment that leaves it.
pub type Bulged = Vec<([f64; 2], f64)>;

/// Content of a file: layer and curve, in the file's order.
pub type Read = Vec<(String, bool, Bulged)>;

/// Area inside a closed curve, mm^2: its polygon and the segments of circles on its chords.
pub fn area_mm2(curve: &Bulged) -> f64 {
    let mut area = 0.0;
    for (i, (a, bulge)) in curve.iter().enumerate() {
        let b = curve[(i + 1) % curve.len()].0;
        area += (a[0] * b[1] - a[1] * b[0]) / 2.0;
        if *bulge != 0.0 {
            let angle = 4.0 * bulge.atan();
            let radius = (b[0] - a[0]).hypot(b[1] - a[1]) / (2.0 * (angle / 2.0).sin());
            area += radius * radius * (angle - angle.sin()) / 2.0;
        }
    }
    area.abs()
}

/// Group codes and values.
pub fn groups(dxf: &[u8]) -> Vec<(u16, &str)> {
    let lines: Vec<&str> = std::str::from_utf8(dxf).unwrap().lines().collect();
    lines.chunks(2).map(|pair| (pair[0].trim().parse().unwrap(), pair[1])).collect()
}

/// Every entity: layer, whether it is closed, and its points.
pub fn read_dxf(dxf: &[u8]) -> Read {
    let groups = groups(dxf);
    let start = groups.iter().position(|g| *g == (2, "ENTITIES")).unwrap();
    let section = &groups[start + 1..];
    let section = &section[..section.iter().position(|g| *g == (0, "ENDSEC")).unwrap()];
    let mut found = Vec::new();
    for entity in section.chunk_by(|_, next| next.0 != 0) {
        let text = |code| entity.iter().find(|g| g.0 == code).map(|g| g.1);
        let number = |code: u16| text(code).unwrap().parse::<f64>().unwrap();
        let layer = text(8).unwrap().to_owned();
        let (is_closed, curve) = match entity[0].1 {
            "CIRCLE" => {
                let (x, y, r) = (number(10), number(20), number(40));
                (true, vec![([x + r, y], 1.0), ([x - r, y], 1.0)])
            }
            "LWPOLYLINE" => {
                let mut curve: Bulged = Vec::new();
                for (code, value) in entity.iter().filter(|g| [10, 20, 42].contains(&g.0)) {
                    let value: f64 = value.parse().unwrap();
                    match code {
                        10 => curve.push(([value, 0.0], 0.0)),
                        20 => curve.last_mut().unwrap().0[1] = value,
                        _ => curve.last_mut().unwrap().1 = value,
                    }
                }
                assert_eq!(text(90).unwrap(), curve.len().to_string());
                (text(70) == Some("1"), curve)
            }
            other => panic!("an entity {other}"),
        };
        found.push((layer, is_closed, curve));
    }
    found
}

/// Every path of an SVG file, y turned upwards again.
pub fn read_svg(svg: &[u8]) -> Read {
    let text = std::str::from_utf8(svg).unwrap();
    let attribute = |line: &str, name: &str| {
        let rest = line.split_once(&format!(" {name}=\"")).unwrap().1;
        rest.split_once('"').unwrap().0.to_owned()
    };
    let root = text.lines().find(|line| line.starts_with("<svg")).unwrap();
    let view_box = attribute(root, "viewBox");
    let height: f64 = view_box.split(' ').next_back().unwrap().parse().unwrap();
    assert_eq!(attribute(root, "height"), format!("{height}mm"));
    let mut layer = String::new();
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with("<g ") {
            layer = attribute(line, "id");
        } else if line.starts_with("<path ") {
            let (is_closed, curve) = read_path(&attribute(line, "d"), height);
            found.push((layer.clone(), is_closed, curve));
        }
    }
    found
}

fn read_path(data: &str, height: f64) -> (bool, Bulged) {
    let mut words = data.split(' ').peekable();
    let mut curve: Bulged = Vec::new();
    let mut is_closed = false;
    let number = |word: Option<&str>| word.unwrap().parse::<f64>().unwrap();
    while let Some(word) = words.next() {
        let mut arc = None;
        match word {
            "M" | "L" => {}
            "A" => {
                let (radius, ry, _) =
                    (number(words.next()), number(words.next()), number(words.next()));
                assert_eq!(radius, ry);
                arc = Some((radius, words.next() == Some("1"), words.next() == Some("1")));
            }
            "Z" => {
                is_closed = true;
                continue;
            }
            other => panic!("a path command {other}"),
        }
        let to = [number(words.next()), height - number(words.next())];
        if let Some((radius, is_large, is_clockwise)) = arc {
            let (from, bulge) = curve.last_mut().unwrap();
            let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
            let small = 2.0 * (chord / (2.0 * radius)).min(1.0).asin();
            let angle = if is_large { 2.0 * PI - small } else { small };
            *bulge = (angle / 4.0).tan() * if is_clockwise { -1.0 } else { 1.0 };
        }
        curve.push((to, 0.0));
    }
    if is_closed {
        // The last point is the first again.
        let (last, first) = (curve.pop().unwrap().0, curve[0].0);
        assert!((last[0] - first[0]).hypot(last[1] - first[1]) < 1e-9);
    }
    (is_closed, curve)
}
