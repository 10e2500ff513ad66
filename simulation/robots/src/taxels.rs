//! Taxels of the touched surface: points of equal area, which are the vertices of one closed mesh.

use fabkit_export::{NpyArray, NpyValues};
use fabkit_files::Error;
use fabkit_geometry::{Point3, SurfacePoints, Vector3};
use fabkit_mesh::convex_hull;

/// Number of taxels of a dome.
const DOME_TAXELS: usize = 900;
/// Number of steps of a pad's grid along its longer side.
const PAD_SIDE_TAXELS: usize = 32;
/// Number of points around a dome's foot.
const RIM_VERTICES: usize = 96;
/// Area fraction of the rim: just inside, because the foot itself belongs to the wall below.
const RIM_AREA_FRACTION: f64 = 1.0 - 1e-9;
/// Distance of the outermost points from a pad's outline, as a fraction of its side.
const OUTLINE_MARGIN: f64 = 1e-6;
/// Turns from one point of a spiral to the next: the golden ratio (Vogel 1979).
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Closed mesh with taxels, sensor frame.
#[derive(Clone, Debug)]
pub(super) struct TouchMesh {
    pub vertices_mm: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// Outward normal at each vertex; meaningful for taxels.
    normals: Vec<Vector3<f64>>,
    /// True for taxels, each of which stands for an equal area. The other vertices close the mesh.
    is_taxel: Vec<bool>,
    /// Area of the surface, mm2.
    pub area_mm2: f64,
}

impl TouchMesh {
    pub fn new(points: &SurfacePoints, soft_mm: f64) -> Result<Self, Error> {
        match points {
            SurfacePoints::Dome(_) => Self::from_dome(points),
            SurfacePoints::Plane(pad) => Self::from_pad(points, pad.bounds_mm(), soft_mm),
        }
    }

    /// Number of taxels.
    pub fn taxel_count(&self) -> usize {
        self.is_taxel.iter().filter(|feels| **feels).count()
    }

    /// Creates a dome: a spiral from the tip to the foot, and the foot's rim. A dome is convex, so that all points are
    /// corners of its hull.
    fn from_dome(points: &SurfacePoints) -> Result<Self, Error> {
        let missing = || Error::bug("a dome without points");
        let mut found = Vec::new();
        for k in 0..DOME_TAXELS {
            // The tip is the first point, because presses there are what people try first.
            let along = k as f64 / DOME_TAXELS as f64;
            let around = (k as f64 * GOLDEN).fract();
            found
                .push((points.point_at_area_fractions([along, around]).ok_or_else(missing)?, true));
        }
        for k in 0..RIM_VERTICES {
            let around = k as f64 / RIM_VERTICES as f64;
            found.push((
                points.point_at_area_fractions([RIM_AREA_FRACTION, around]).ok_or_else(missing)?,
                false,
            ));
        }
        let places: Vec<[f64; 3]> =
            found.iter().map(|((place, _), _)| place.coords.into()).collect();
        let hull = convex_hull(&places).map_err(Error::bug)?;
        // The hull has its own order of vertices: taxels are found by their coordinates.
        let key = |place: &[f64; 3]| place.map(f64::to_bits);
        let known: std::collections::BTreeMap<_, _> =
            places.iter().zip(&found).map(|(place, found)| (key(place), found)).collect();
        let of_hull = hull.vertices.iter().map(|place| known.get(&key(place)).copied());
        let of_hull: Vec<_> = of_hull.collect::<Option<_>>().ok_or_else(missing)?;
        Ok(Self {
            normals: of_hull.iter().map(|((_, normal), _)| *normal).collect(),
            is_taxel: of_hull.iter().map(|(_, feels)| *feels).collect(),
            vertices_mm: hull.vertices,
            triangles: hull.triangles,
            area_mm2: points.area_mm2(),
        })
    }

    /// Creates a pad: a grid on its face, and a copy at the depth of the soft layers.
    fn from_pad(
        points: &SurfacePoints,
        [x, y]: [[f64; 2]; 2],
        soft_mm: f64,
    ) -> Result<Self, Error> {
        let missing = || Error::bug("a pad without points");
        let [wide, high] = [x[1] - x[0], y[1] - y[0]];
        let steps =
            |side: f64| ((side / wide.max(high) * PAD_SIDE_TAXELS as f64).round() as usize).max(2);
        let (columns, rows) = (steps(wide), steps(high));
        let share = |k: usize, of: usize| {
            (k as f64 / of as f64).clamp(OUTLINE_MARGIN, 1.0 - OUTLINE_MARGIN)
        };
        let mut face = Vec::new();
        for i in 0..=columns {
            for j in 0..=rows {
                let at = [share(i, columns), share(j, rows)];
                face.push(points.point_at_area_fractions(at).ok_or_else(missing)?);
            }
        }
        let count = face.len() as u32;
        let at = |i: usize, j: usize| (i * (rows + 1) + j) as u32;
        let mut triangles = Vec::new();
        for i in 0..columns {
            for j in 0..rows {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
                triangles.extend([[a, c, b], [a, d, c]].map(|t| t.map(|k| k + count)));
            }
        }
        // The outline of the grid, counter-clockwise seen from above.
        let mut edge: Vec<u32> = (0..columns).map(|i| at(i, 0)).collect();
        edge.extend((0..rows).map(|j| at(columns, j)));
        edge.extend((1..=columns).rev().map(|i| at(i, rows)));
        edge.extend((1..=rows).rev().map(|j| at(0, j)));
        for (k, a) in edge.iter().enumerate() {
            let b = edge[(k + 1) % edge.len()];
            // The side walls between the face and its copy below.
            triangles.extend([[*a, a + count, b + count], [*a, b + count, b]]);
        }
        let below = |(place, normal): &(Point3<f64>, Vector3<f64>)| place - soft_mm * normal;
        let lower = face.iter().map(below).map(|place| place.coords.into());
        Ok(Self {
            vertices_mm: face.iter().map(|(place, _)| place.coords.into()).chain(lower).collect(),
            triangles,
            normals: face.iter().chain(&face).map(|(_, normal)| *normal).collect(),
            is_taxel: (0..2 * count).map(|k| k < count).collect(),
            area_mm2: points.area_mm2(),
        })
    }

    /// Returns the arrays of `robot-taxels.npz`, in the order of the mesh's vertices: `place_mm`, `normal`, `tangents`
    /// (two each), `area_mm2` (0 for vertices that only close the mesh), `pixel` (NaN outside the image), `seen` (1, or
    /// 0 behind something opaque).
    pub fn arrays(&self, pixels: &[Option<[f64; 2]>], are_seen: &[bool]) -> Vec<NpyArray> {
        let count = self.vertices_mm.len();
        let array = |name: &str, of_each: &[usize], values: Vec<f64>| NpyArray {
            name: name.to_owned(),
            shape: [&[count], of_each].concat(),
            values: NpyValues::F64(values),
        };
        // By construction every taxel stands for the same area.
        let share = self.area_mm2 / self.taxel_count() as f64;
        // The first tangent lies along a meridian in the direction of +x, the second across it.
        let tangents = self.normals.iter().flat_map(|normal| {
            let first = (Vector3::x() - normal.x * normal).try_normalize(1e-6);
            let first = first.unwrap_or_else(|| Vector3::y().cross(normal).normalize());
            let second = normal.cross(&first);
            [first, second].into_iter().flat_map(<[f64; 3]>::from)
        });
        let pixels = pixels.iter().flat_map(|pixel| pixel.unwrap_or([f64::NAN; 2]));
        vec![
            array("place_mm", &[3], self.vertices_mm.iter().flatten().copied().collect()),
            array("normal", &[3], self.normals.iter().flat_map(|n| <[f64; 3]>::from(*n)).collect()),
            array("tangents", &[2, 3], tangents.collect()),
            array(
                "area_mm2",
                &[],
                self.is_taxel.iter().map(|feels| if *feels { share } else { 0.0 }).collect(),
            ),
            array("pixel", &[2], pixels.collect()),
            NpyArray {
                name: "seen".to_owned(),
                shape: vec![count],
                values: NpyValues::U8(are_seen.iter().map(|seen| u8::from(*seen)).collect()),
            },
        ]
    }
}
