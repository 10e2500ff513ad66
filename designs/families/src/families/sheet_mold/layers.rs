//! The soft interface: its channels and its layers.

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, Color, OpticalClarity, Path, Point3, Pose, Segment, Shells, Solid,
    Vector3,
};

use super::parameters::*;
use super::{SheetMoldLayout, channel_count, marker_centres};
use crate::chain_builder::{AssemblyName, Name, SENSOR};
use crate::materials::is_dark;

// Channels, in the sensor's xy plane. They enter from -x and +x; the right side's are the left's rotated by half a turn.
// The same outline serves for the fingers of the mold, the grooves in the silicone, and the liquid.

/// A point in the xy plane, mm.
type Point = [f64; 2];

/// Distance along y at which the spokes of a radial arrangement begin, as a share of their entrance's y. A fan that
/// narrows evenly keeps its channels apart.
const SPOKE_START: f64 = 0.8;

/// Side from which a channel enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side at -x.
    Left,
    /// Side at +x.
    Right,
}

impl Side {
    /// Both sides, in the order in which channels are numbered.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Name of the side, as used in names of steps and bodies.
    pub fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Maps a point of the left side to the corresponding point of this side.
    pub fn map_from_left(self, [x, y]: Point) -> Point {
        match self {
            Self::Left => [x, y],
            Self::Right => [-x, -y],
        }
    }

    /// Sign of x on this side.
    pub fn sign(self) -> f64 {
        self.map_from_left([-1.0, 0.0])[0]
    }

    /// Name of the glue around this side's tubes.
    pub fn glue(self) -> Name {
        match self {
            Self::Left => LEFT_GLUE,
            Self::Right => RIGHT_GLUE,
        }
    }

    /// Name of the liquid in this side's channels.
    pub fn liquid(self) -> Name {
        match self {
            Self::Left => LEFT_LIQUID,
            Self::Right => RIGHT_LIQUID,
        }
    }
}

/// One channel seen from above: all points within the half width of its centre line, and a chamber at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Centre line from the layer's edge inwards, mm.
    centreline: Vec<Point>,
    half_width: f64,
    /// Radius of the round end, mm: the half width, or more for a chamber.
    end_radius: f64,
}

/// Returns the channels that enter from the left, from -y to +y.
pub fn left_channels(p: &SheetMold) -> Vec<Channel> {
    let n = p.channels.per_side;
    let edge = -p.channel_layer.side.mm() / 2.0;
    let half_width = p.channels.width.mm() / 2.0;
    let wall = p.channels.wall.mm();
    // A channel continues straight behind its tube until any bend may begin.
    let stub_end = edge + p.tubes.insertion.mm() + half_width;
    (0..n)
        .map(|k| {
            let y = port_y(p, k);
            let port = [edge, y];
            let ends_at = |x: f64, end_radius: f64| Channel {
                centreline: vec![port, [x, y]],
                half_width,
                end_radius,
            };
            match p.channels.arrangement {
                // Half a wall stays between the channel's end and the middle.
                Arrangement::Straight => ends_at(-wall / 2.0 - half_width, half_width),
                Arrangement::Grid => {
                    let chamber = p.channels.chamber_diameter.mm() / 2.0;
                    let outer = stub_end + chamber;
                    // The four columns of chambers are evenly spaced.
                    let x = if k.is_multiple_of(2) { outer } else { outer / 3.0 };
                    ends_at(x, chamber)
                }
                Arrangement::Radial => {
                    let [start, end] = spoke_radii_mm(p, k);
                    let angle = std::f64::consts::PI - steps_from_middle(k, n) * spoke_step_rad(n);
                    let spoke = |radius: f64| [radius * angle.cos(), radius * angle.sin()];
                    Channel {
                        centreline: vec![port, [stub_end, y], spoke(start), spoke(end)],
                        half_width,
                        end_radius: half_width,
                    }
                }
            }
        })
        .collect()
}

/// Position along y of a left channel's entrance, mm.
pub fn port_y(p: &SheetMold, k: u32) -> f64 {
    steps_from_middle(k, p.channels.per_side) * p.channels.pitch.mm()
}

fn steps_from_middle(k: u32, n: u32) -> f64 {
    f64::from(k) - (f64::from(n) - 1.0) / 2.0
}

/// Angle between two spokes, rad.
fn spoke_step_rad(n: u32) -> f64 {
    std::f64::consts::PI / f64::from(n)
}

/// Distances from the centre, mm, at which spoke `k` begins (coming from its entrance) and ends.
pub fn spoke_radii_mm(p: &SheetMold, k: u32) -> [f64; 2] {
    let n = p.channels.per_side;
    let (step, m) = (spoke_step_rad(n), steps_from_middle(k, n));
    // It begins at a fixed share of its entrance's y. For a spoke along x that is the limit of the quotient.
    let share = if m == 0.0 { 1.0 / step } else { m / (m * step).sin() };
    let start = SPOKE_START * p.channels.pitch.mm() * share;
    let room = p.channels.width.mm() + p.channels.wall.mm();
    // Long spokes end where their ends fit side by side, short ones where they fit between two long ones.
    let end = if k.is_multiple_of(2) { room / (2.0 * step.sin()) } else { room / step.sin() };
    [start, end]
}

impl Channel {
    /// Returns the same channel entering from `side`.
    pub fn mirrored_to(&self, side: Side) -> Self {
        Self {
            centreline: self.centreline.iter().map(|&p| side.map_from_left(p)).collect(),
            ..self.clone()
        }
    }

    /// Outline from the right-hand corner of the entrance around the channel's end to the left-hand corner, both at
    /// `root_x`. It is not closed.
    pub fn outline(&self, root_x: f64) -> Path {
        let mut forth = self.centreline.clone();
        forth[0][0] = root_x;
        let back: Vec<Point> = forth.iter().rev().copied().collect();
        let h = self.half_width;

        // Points at which the sides meet the round end.
        let (before_end, end) = (back[1], back[0]);
        let heading = unit(minus(end, before_end));
        let foot = plus(end, heading, -(self.end_radius.powi(2) - h.powi(2)).sqrt());
        let entrance = unit(minus(forth[1], forth[0]));

        let path = Path::from(plus(forth[0], right(entrance), h));
        let path = follow_right_side(path, &forth, h).line(plus(foot, right(heading), h)).arc(
            plus(foot, right(heading), -h),
            end,
            true,
        );
        // The left side on the way in is the right side on the way out.
        follow_right_side(path, &back, h).line(plus(forth[0], right(entrance), -h))
    }

    /// Minimum distance between the walls of two channels, mm; negative if they overlap.
    pub fn distance_to(&self, other: &Self) -> f64 {
        let mut smallest = f64::INFINITY;
        for (a, radius_a) in self.capsules() {
            for (b, radius_b) in other.capsules() {
                smallest = smallest.min(segment_distance(a, b) - radius_a - radius_b);
            }
        }
        smallest
    }

    /// Segments with radii (capsules) that cover the channel. They extend beyond its entrance.
    fn capsules(&self) -> Vec<([Point; 2], f64)> {
        let pieces = self.centreline.windows(2).map(|w| ([w[0], w[1]], self.half_width));
        let end = *self.centreline.last().expect("a centre line has points");
        pieces.chain([([end, end], self.end_radius)]).collect()
    }
}

/// Opening of the channel layer's mold: the square of `side_mm` without the channels, as one path.
pub fn comb_opening(channels: &[Channel], side_mm: f64) -> Path {
    let edge = side_mm / 2.0;
    let mut path = Path::from([-edge, -edge]).line([edge, -edge]);
    // Channels of the right side are rotated by half a turn, so going up along it meets them in the same order as
    // going down along the left side.
    for (side, corner) in [(Side::Right, [edge, edge]), (Side::Left, [-edge, -edge])] {
        for channel in channels.iter().rev() {
            let back = turn_to_side(reversed(channel.outline(-edge)), side);
            path = path.line(back.start);
            path.segments.extend(back.segments);
        }
        path = path.line(corner);
        if side == Side::Right {
            path = path.line([-edge, edge]);
        }
    }
    path
}

/// Returns a path of a left channel as one that enters from `side`.
pub fn turn_to_side(path: Path, side: Side) -> Path {
    let turn = |segment: &Segment| match segment {
        Segment::Line { to } => Segment::Line { to: side.map_from_left(*to) },
        Segment::Arc { to, centre, ccw } => Segment::Arc {
            to: side.map_from_left(*to),
            centre: side.map_from_left(*centre),
            ccw: *ccw,
        },
        // Channels have no elliptic arcs. A half turn would leave their axes as they are.
        Segment::EllipticArc { to, centre, semi_axes_mm, ccw } => Segment::EllipticArc {
            to: side.map_from_left(*to),
            centre: side.map_from_left(*centre),
            semi_axes_mm: *semi_axes_mm,
            ccw: *ccw,
        },
    };
    Path {
        start: side.map_from_left(path.start),
        segments: path.segments.iter().map(turn).collect(),
    }
}

/// Area that a closed path of lines and circular arcs encloses, mm2: the polygon through its points, plus the
/// circular segment beyond each arc's chord.
pub fn area_mm2(path: &Path) -> f64 {
    let mut from = path.start;
    let mut doubled = 0.0;
    for segment in &path.segments {
        let to = segment.to();
        doubled += cross(from, to);
        if let Segment::Arc { centre, ccw, .. } = segment {
            let (a, b) = (minus(from, *centre), minus(to, *centre));
            let turn = cross(a, b).atan2(dot(a, b));
            let full = std::f64::consts::TAU;
            let sweep = if *ccw { turn.rem_euclid(full) } else { -(-turn).rem_euclid(full) };
            doubled += dot(a, a) * (sweep - sweep.sin());
        }
        from = to;
    }
    (doubled / 2.0).abs()
}

/// Returns the same curve from its end to its start.
fn reversed(path: Path) -> Path {
    let mut back = Path::from(path.end());
    for (i, segment) in path.segments.iter().enumerate().rev() {
        let to = if i == 0 { path.start } else { path.segments[i - 1].to() };
        back = match segment {
            Segment::Arc { centre, ccw, .. } => back.arc(to, *centre, !ccw),
            _ => back.line(to),
        };
    }
    back
}

/// Appends the right-hand side of a way along its bends: an arc where the right side is outside, a sharp corner where
/// it is inside.
fn follow_right_side(path: Path, way: &[Point], half_width: f64) -> Path {
    way.windows(3).fold(path, |path, bend| {
        let [from, at, to] = [bend[0], bend[1], bend[2]];
        let (arriving, leaving) = (unit(minus(at, from)), unit(minus(to, at)));
        let (before, after) = (right(arriving), right(leaving));
        if cross(arriving, leaving) > 0.0 {
            let start = path.line(plus(at, before, half_width));
            start.arc(plus(at, after, half_width), at, true)
        } else {
            // Mitre of the inner side: along the sum of both normals.
            let sum = [before[0] + after[0], before[1] + after[1]];
            path.line(plus(at, sum, half_width / (1.0 + dot(before, after))))
        }
    })
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn plus(a: Point, direction: Point, by: f64) -> Point {
    [a[0] + by * direction[0], a[1] + by * direction[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn unit(a: Point) -> Point {
    let length = a[0].hypot(a[1]);
    [a[0] / length, a[1] / length]
}

fn right([x, y]: Point) -> Point {
    [y, -x]
}

/// Distance between two segments in the plane; 0 if they cross.
fn segment_distance(a: [Point; 2], b: [Point; 2]) -> f64 {
    let side = |s: [Point; 2], p: Point| cross(minus(s[1], s[0]), minus(p, s[0]));
    let crosses = |s: [Point; 2], t: [Point; 2]| side(s, t[0]) * side(s, t[1]) < 0.0;
    if crosses(a, b) && crosses(b, a) {
        return 0.0;
    }
    let to_point = |s: [Point; 2], p: Point| {
        let along = minus(s[1], s[0]);
        let length2 = dot(along, along);
        let t = if length2 > 0.0 { dot(minus(p, s[0]), along) / length2 } else { 0.0 };
        let off = minus(p, plus(s[0], along, t.clamp(0.0, 1.0)));
        off[0].hypot(off[1])
    };
    to_point(a, b[0]).min(to_point(a, b[1])).min(to_point(b, a[0])).min(to_point(b, a[1]))
}

// Layers that are cast, painted, glued or filled in.

/// Depth to which a marker's cylinder reaches into the layer that it stands on, mm.
const MARKER_ROOT_MM: f64 = 0.5;

const RED: Color = [214, 60, 60];

/// Returns all layers, from the camera to the finger, with the display's liquid last.
pub fn layers(p: &SheetMold, layout: &SheetMoldLayout) -> Vec<Body> {
    let channels = left_channels(p);
    let layer = |name: Name, solid, material: &str, color, opacity| {
        name.cast(solid).with_material(material).colored(color).opaque(opacity)
    };
    let placed = |layer: Body, lift_mm: f64, molds: &[AssemblyName]| {
        let in_molds = molds.iter().map(|mold| mold.in_place());
        let placements = std::iter::once(SENSOR.in_place().lifted(lift_mm)).chain(in_molds);
        layer.placed(placements)
    };
    let marker_layer =
        layer(MARKER_LAYER, marker_layer(p, layout), &p.marker_layer.material, [70, 72, 80], 1.0);
    let is_dyed = p.marker_layer.pigment_share > 0.0;
    let marker_layer =
        if is_dyed { marker_layer.with_clarity(OpticalClarity::Opaque) } else { marker_layer };
    // Its darkness is that of the pigment, if the catalogue knows it.
    let pigment = Some(&*p.marker_layer.pigment).filter(|_| is_dyed);
    let marker_layer = marker_layer.with_darkness(pigment.and_then(is_dark));
    let paint = layer(
        MARKER_PAINT,
        discs(p, layout.marker_end_z_mm - p.markers.paint.mm(), p.markers.paint.mm()),
        &p.markers.paint_material,
        [245, 245, 240],
        1.0,
    )
    .with_shells(Shells::pieces(marker_centres(p).len()));
    let channel_layer = layer(
        CHANNEL_LAYER,
        channel_layer(p, layout, &channels),
        &p.channel_layer.material,
        [196, 214, 226],
        0.45,
    );
    let mut all = vec![
        placed(paint, 22.0, &[]),
        placed(marker_layer, 30.0, &[MARKER_MOLD]),
        placed(channel_layer, 58.0, &[CHANNEL_MOLD]),
    ];
    for side in Side::BOTH {
        let glue =
            layer(side.glue(), tube_glue(p, layout, side), &p.tubes.glue, [200, 200, 190], 0.8)
                // One sleeve around each tube.
                .with_handles(p.channels.per_side as i32)
                .with_shells(Shells::pieces(p.channels.per_side as usize));
        let liquid =
            layer(side.liquid(), liquid(p, layout, &channels, side), "water, dyed red", RED, 0.9)
                .with_shells(Shells::pieces(channels.len()));
        all.push(placed(glue, 44.0, &[]));
        all.push(placed(liquid, 44.0, &[]));
    }
    let display = layer(DISPLAY_LIQUID, display_liquid(p), "water, dyed red", RED, 0.9);
    let place = SENSOR.at(layout.sensor_from_display).lifted(34.0);
    let shells = Shells::pieces(channel_count(p) as usize);
    all.push(display.placed([place]).with_shells(shells));
    all
}

/// Returns a cylinder under every marker, with the circles of their mold's holes.
fn discs(p: &SheetMold, bottom_z: f64, height_mm: f64) -> Solid {
    let radius = p.markers.diameter.mm() / 2.0;
    Solid::union(marker_centres(p).into_iter().enumerate().map(|(i, centre)| {
        Solid::extrusion(Path::circle(centre, radius), height_mm)
            .at_z(bottom_z)
            .named(format!("marker {}", i + 1))
    }))
}

fn marker_layer(p: &SheetMold, layout: &SheetMoldLayout) -> Solid {
    let outline = Path::rectangle([0.0; 2], [p.marker_layer.side.mm(); 2], 0.0);
    let plate = Solid::extrusion(outline, p.marker_layer.thickness.mm());
    let markers = discs(p, layout.marker_end_z_mm, p.markers.height.mm() + MARKER_ROOT_MM);
    match markers {
        Solid::Union(markers) => Solid::union([vec![plate], markers].concat()),
        one => plate.plus(one),
    }
}

fn channel_layer(p: &SheetMold, layout: &SheetMoldLayout, channels: &[Channel]) -> Solid {
    let side = p.channel_layer.side.mm();
    let outline = Path::rectangle([0.0; 2], [side; 2], 0.0);
    let block =
        Solid::extrusion(outline, layout.touch_z_mm - layout.bond_z_mm).at_z(layout.bond_z_mm);
    let root_x = -side / 2.0 - CUT_OVERLAP_MM;
    let grooves = Side::BOTH.into_iter().flat_map(|entrance| {
        channels.iter().enumerate().map(move |(k, channel)| {
            let outline = turn_to_side(channel.outline(root_x), entrance).close();
            Solid::extrusion(outline, p.channels.height.mm() + CUT_OVERLAP_MM)
                .at_z(layout.bond_z_mm - CUT_OVERLAP_MM)
                .named(format!("channel {} {}", entrance.word(), k + 1))
        })
    });
    block.minus_all(grooves)
}

/// Returns the liquid of one side, from the tubes' ends inwards.
fn liquid(p: &SheetMold, layout: &SheetMoldLayout, channels: &[Channel], side: Side) -> Solid {
    Solid::union(
        channel_liquids(p, layout, channels, side)
            .into_iter()
            .map(|(name, solid)| solid.named(format!("channel {name}"))),
    )
}

/// Returns the liquid of each channel of one side, with the channel's name.
pub fn channel_liquids(
    p: &SheetMold,
    layout: &SheetMoldLayout,
    channels: &[Channel],
    side: Side,
) -> Vec<(String, Solid)> {
    let root_x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let water = |(k, channel): (usize, &Channel)| {
        let outline = turn_to_side(channel.outline(root_x), side).close();
        let solid = Solid::extrusion(outline, p.channels.height.mm()).at_z(layout.bond_z_mm);
        (format!("{} {}", side.word(), k + 1), solid)
    };
    channels.iter().enumerate().map(water).collect()
}

/// Volume of liquid in the channels of one side, from the tubes' ends inwards, mm3.
pub fn side_volume_mm3(p: &SheetMold) -> f64 {
    let root_x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let areas = left_channels(p).into_iter().map(|c| area_mm2(&c.outline(root_x).close()));
    p.channels.height.mm() * areas.sum::<f64>()
}

/// Volume of the bore of one tube, mm3.
pub fn tube_volume_mm3(p: &SheetMold) -> f64 {
    std::f64::consts::PI * (p.tubes.inner_diameter.mm() / 2.0).powi(2) * p.tubes.length.mm()
}

/// Poses of the tubes of one side: origin at the end of the tube in its channel, z axis outwards.
pub fn tube_poses(p: &SheetMold, layout: &SheetMoldLayout, side: Side) -> Vec<Pose> {
    let x = p.tubes.insertion.mm() - p.channel_layer.side.mm() / 2.0;
    let z = layout.bond_z_mm + p.channels.height.mm() / 2.0;
    (0..p.channels.per_side)
        .map(|k| {
            let [x, y] = side.map_from_left([x, port_y(p, k)]);
            Pose::z_to(Vector3::new(side.sign(), 0.0, 0.0), Point3::new(x, y, z))
        })
        .collect()
}

fn tube_glue(p: &SheetMold, layout: &SheetMoldLayout, side: Side) -> Solid {
    let (width, height, length) =
        (p.channels.width.mm(), p.channels.height.mm(), p.tubes.insertion.mm());
    let tube = Solid::cylinder(p.tubes.outer_diameter.mm() / 2.0, length + 2.0 * CUT_OVERLAP_MM)
        .at_z(-CUT_OVERLAP_MM);
    let sleeves = tube_poses(p, layout, side).into_iter().enumerate().map(|(k, pose)| {
        let outer = side.sign() * p.channel_layer.side.mm() / 2.0;
        let end = pose.point(Point3::origin());
        let (low, high) = (outer.min(end.x), outer.max(end.x));
        let bottom = layout.bond_z_mm;
        Solid::cuboid_between(
            [low, end.y - width / 2.0, bottom],
            [high, end.y + width / 2.0, bottom + height],
        )
        .minus(tube.clone().placed(pose))
        .named(format!("sleeve {} {}", side.word(), k + 1))
    });
    Solid::union(sleeves)
}

/// Positions of the display's channels along y, in its frame, mm.
pub fn display_channel_y(p: &SheetMold) -> Vec<f64> {
    let n = channel_count(p);
    (0..n).map(|k| (f64::from(k) - (f64::from(n) - 1.0) / 2.0) * p.display.pitch.mm()).collect()
}

/// Centre of the round end at which a display channel is filled, in the display's frame. The other end is its mirror
/// image.
pub fn display_inlet(p: &SheetMold, y: f64) -> [f64; 2] {
    [(p.display.channel_length.mm() - p.display.channel_width.mm()) / 2.0, y]
}

/// Position at which the liquid in the display ends at rest: x in the display's frame, mm.
pub fn resting_end_x(p: &SheetMold) -> f64 {
    p.display.channel_length.mm() / 2.0 - p.display.rest_length.mm()
}

fn display_liquid(p: &SheetMold) -> Solid {
    let (radius, sheet) = (p.display.channel_width.mm() / 2.0, p.display.sheet.mm());
    let rest = resting_end_x(p);
    Solid::union(display_channel_y(p).into_iter().enumerate().map(|(k, y)| {
        let inlet = display_inlet(p, y);
        let outline = Path::from([rest, y - radius])
            .line([inlet[0], y - radius])
            .arc([inlet[0], y + radius], inlet, true)
            .line([rest, y + radius])
            .close();
        Solid::extrusion(outline, sheet).at_z(sheet).named(format!("channel {}", k + 1))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(centreline: &[Point], end_radius: f64) -> Channel {
        Channel { centreline: centreline.to_vec(), half_width: 1.5, end_radius }
    }

    #[test]
    fn area_of_a_straight_channel_is_exact() {
        let area = area_mm2(&channel(&[[-30.0, 4.0], [-2.0, 4.0]], 1.5).outline(-24.0).close());
        let exact = 22.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5 / 2.0;
        assert!((area - exact).abs() < 1e-12 * exact, "{area} {exact}");
    }

    #[test]
    fn a_chamber_adds_a_disc_without_the_channel_s_share() {
        let area = area_mm2(&channel(&[[-30.0, 4.0], [-2.0, 4.0]], 3.5).outline(-30.0).close());
        // The channel ends where its corners meet the circle; beyond lies the major segment.
        let half_angle = (1.5_f64 / 3.5).asin();
        let foot = 28.0 - 3.5 * half_angle.cos();
        let minor = 3.5 * 3.5 / 2.0 * (2.0 * half_angle - (2.0 * half_angle).sin());
        let exact = 3.0 * foot + std::f64::consts::PI * 3.5 * 3.5 - minor;
        assert!((area - exact).abs() < 1e-12 * exact, "{area} {exact}");
    }

    #[test]
    fn a_bend_keeps_the_width() {
        // Outer arc and inner mitre at a turn of angle t: 2 h times the centre line, plus the
        // sector beyond the corner, minus what the two halves share.
        let t = std::f64::consts::FRAC_PI_3;
        let bent = [[0.0, 0.0], [10.0, 0.0], [10.0 + 10.0 * t.cos(), 10.0 * t.sin()]];
        let area = area_mm2(&channel(&bent, 1.5).outline(0.0).close());
        let (h, pi) = (1.5_f64, std::f64::consts::PI);
        let exact = 2.0 * h * 20.0 + h * h * (t / 2.0 - (t / 2.0).tan()) + pi * h * h / 2.0;
        assert!((area - exact).abs() < 1e-12 * exact, "{area} {exact}");
        // The mirror image bends to the right and is as large.
        let mirrored = bent.map(|[x, y]| [x, -y]);
        let other = area_mm2(&channel(&mirrored, 1.5).outline(0.0).close());
        assert!((area - other).abs() < 1e-12 * exact, "{area} {other}");
    }

    #[test]
    fn distances_are_between_channel_walls() {
        let a = channel(&[[-30.0, 0.0], [-2.0, 0.0]], 1.5);
        let b = channel(&[[-30.0, 6.5], [-2.0, 6.5]], 3.5);
        assert!((a.distance_to(&b) - 1.5).abs() < 1e-12);
        assert!((a.distance_to(&a.mirrored_to(Side::Right)) - 1.0).abs() < 1e-12);
        let across = channel(&[[-10.0, -5.0], [-10.0, 5.0]], 1.5);
        assert!(a.distance_to(&across) < 0.0);
    }
}
