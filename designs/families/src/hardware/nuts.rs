//! Nuts that are melted or dropped into plastic, and spacers.

use fabkit_geometry::{CUT_OVERLAP_MM, Order, Path, Solid};

/// Brass nut that is melted into plastic: open at z = 0, extending along -z. No standard covers these; the sizes are a
/// maker's.
///
/// ```
/// use fabkit_designs::HeatSetNut;
/// use fabkit_geometry::CompiledSolid;
/// let nut = HeatSetNut::M3;
/// assert_eq!(nut.name(), "insert-m3");
/// // 4.6 mm over the knurl, in a hole of 4 mm.
/// assert!((nut.overlap_mm() - 0.3).abs() < 1e-12);
/// let bounds = CompiledSolid::new(&nut.solid())?.bounds();
/// assert_eq!([bounds.min.z, bounds.max.z], [-5.7, 0.0]);
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatSetNut {
    /// Maker and series.
    pub maker: &'static str,
    /// Stem of the bodies' names: `nut` or, if other nuts exist, `insert`.
    pub word: &'static str,
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Outer diameter over the knurl, mm.
    pub diameter_mm: f64,
    /// Length, mm.
    pub length_mm: f64,
    /// Diameter of the hole it is melted into, mm.
    pub hole_mm: f64,
    /// Smallest wall around the hole, mm.
    pub wall_mm: f64,
}

impl HeatSetNut {
    /// M2 nut, 3 mm long, 3.0 mm over the knurl, for a hole of 2.65 to 2.75 mm.
    pub const M2: Self = Self {
        maker: "Pencom MNZ",
        word: "nut",
        thread_mm: 2.0,
        diameter_mm: 3.0,
        length_mm: 3.0,
        hole_mm: 2.7,
        wall_mm: 0.8,
    };
    /// M2.5 insert, 5.7 mm long.
    pub const M2_5: Self = Self::insert(2.5, 4.6, 5.7, 4.0, 1.6);
    /// M3 insert, 5.7 mm long.
    pub const M3: Self = Self::insert(3.0, 4.6, 5.7, 4.0, 1.6);
    /// M3 insert, 4.0 mm long, for the same hole, where the other one is too long.
    pub const M3_SHORT: Self = Self::insert(3.0, 4.6, 4.0, 4.0, 1.6);
    /// M4 insert, 8.1 mm long.
    pub const M4: Self = Self::insert(4.0, 6.3, 8.1, 5.6, 2.1);
    /// M5 insert, 9.5 mm long.
    pub const M5: Self = Self::insert(5.0, 7.1, 9.5, 6.4, 2.6);

    /// Creates an insert of the series Ruthex RX.
    const fn insert(
        thread_mm: f64,
        diameter_mm: f64,
        length_mm: f64,
        hole_mm: f64,
        wall_mm: f64,
    ) -> Self {
        let (maker, word) = ("Ruthex RX", "insert");
        Self { maker, word, thread_mm, diameter_mm, length_mm, hole_mm, wall_mm }
    }

    /// Play of the screw in the modelled bore, mm per side: too small to be visible, but the solids do not touch.
    const BORE_PLAY_MM: f64 = 0.02;

    /// Returns the name of the nut among a sensor's bodies, for example `nut-m2`.
    pub fn name(&self) -> String {
        format!("{}-m{}", self.word, self.thread_mm).replace('.', "-")
    }

    /// Returns the text that the nut is ordered by.
    pub fn order_text(&self) -> String {
        format!(
            "heat-set nut M{} as {}, {} mm outside, {} mm long, hole {} mm",
            self.thread_mm, self.maker, self.diameter_mm, self.length_mm, self.hole_mm
        )
    }

    /// Returns the order for a shop.
    pub fn order(&self) -> Order {
        let size = format!("M{}x{}", self.thread_mm, self.length_mm);
        Order::new(format!("heat-set nut {}", self.maker), size)
            .with_tool(format!("soldering iron with a tip for M{}", self.thread_mm))
    }

    /// Returns the solid of the nut.
    pub fn solid(&self) -> Solid {
        let bore = self.thread_mm / 2.0 + Self::BORE_PLAY_MM;
        Solid::cylinder(self.diameter_mm / 2.0, self.length_mm)
            .at_z(-self.length_mm)
            .minus(
                Solid::cylinder(bore, self.length_mm + 2.0 * CUT_OVERLAP_MM)
                    .at_z(-self.length_mm - CUT_OVERLAP_MM),
            )
            .named("nut")
    }

    /// Returns its hole, `spare_mm` deeper than the nut: room for molten plastic and the screw's tip.
    pub fn hole_tool(&self, spare_mm: f64) -> Solid {
        let depth = self.length_mm + spare_mm;
        Solid::cylinder(self.hole_mm / 2.0, depth + CUT_OVERLAP_MM).at_z(-depth)
    }

    /// Returns the overlap of the nut with its hole before the plastic melts, mm per side.
    pub fn overlap_mm(&self) -> f64 {
        (self.diameter_mm - self.hole_mm) / 2.0
    }
}

/// Play of a screw in a modelled thread, mm per side: too small to be visible, but the solids do not touch.
const THREAD_PLAY_MM: f64 = 0.02;

/// Returns the distance of a hexagon's corner from its axis, mm.
fn corner_mm(across_flats_mm: f64) -> f64 {
    across_flats_mm / f64::sqrt(3.0)
}

/// Returns a hexagonal prism around z that stands on z = 0, with a corner on +x.
fn hexagon(across_flats_mm: f64, height_mm: f64) -> Solid {
    let corner = |i: usize| {
        let angle = (60.0 * i as f64).to_radians();
        [corner_mm(across_flats_mm) * angle.cos(), corner_mm(across_flats_mm) * angle.sin()]
    };
    Solid::extrusion(Path::polygon(&std::array::from_fn::<_, 6, _>(corner)), height_mm)
}

/// Returns a hexagonal prism with a bore for a thread.
fn threaded_hexagon(across_flats_mm: f64, height_mm: f64, thread_mm: f64) -> Solid {
    let bore = Solid::cylinder(thread_mm / 2.0 + THREAD_PLAY_MM, height_mm + 2.0 * CUT_OVERLAP_MM);
    hexagon(across_flats_mm, height_mm).minus(bore.at_z(-CUT_OVERLAP_MM))
}

/// Hexagon nut, ISO 4032 (s nominal, m max): bears at z = 0 and extends up to its height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexNut {
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Width across flats, mm.
    pub across_flats_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
}

impl HexNut {
    /// M2 nut.
    pub const M2: Self = Self { thread_mm: 2.0, across_flats_mm: 4.0, height_mm: 1.6 };
    /// M3 nut.
    pub const M3: Self = Self { thread_mm: 3.0, across_flats_mm: 5.5, height_mm: 2.4 };

    /// Returns the name of the nut among a sensor's bodies, for example `nut-m3`.
    pub fn name(&self) -> String {
        format!("nut-m{}", self.thread_mm)
    }

    /// Returns the text that the nut is ordered by.
    pub fn order_text(&self) -> String {
        self.order().article_and_size()
    }

    /// Returns the order for a shop.
    pub fn order(&self) -> Order {
        Order::new("hexagon nut ISO 4032", format!("M{}", self.thread_mm))
            .with_tool(format!("spanner or pliers {} mm", self.across_flats_mm))
    }

    /// Returns the solid of the nut.
    pub fn solid(&self) -> Solid {
        threaded_hexagon(self.across_flats_mm, self.height_mm, self.thread_mm).named("nut")
    }

    /// Returns the distance of a corner from the axis, mm, for flats `gap_mm` farther out than the nut's.
    ///
    /// ```
    /// use fabkit_designs::HexNut;
    /// // 5.5 mm across flats are 5.5 mm / cos 30 deg across corners.
    /// let across_mm = 2.0 * HexNut::M3.corner_mm(0.0);
    /// assert!((across_mm - 5.5 / 30_f64.to_radians().cos()).abs() < 1e-12);
    /// ```
    pub fn corner_mm(&self, gap_mm: f64) -> f64 {
        corner_mm(self.across_flats_mm + 2.0 * gap_mm)
    }

    /// Returns a pocket that keeps the nut from turning, from its bearing face up to a surface at `depth_mm`.
    pub fn pocket_tool(&self, gap_mm: f64, depth_mm: f64) -> Solid {
        hexagon(self.across_flats_mm + 2.0 * gap_mm, depth_mm + CUT_OVERLAP_MM)
    }
}

/// Hexagonal spacer with a thread at either end: stands on z = 0. The design sets its length. No standard covers these;
/// makers agree on the width of M3 spacers.
///
/// ```
/// use fabkit_designs::HexSpacer;
/// let order = HexSpacer::M3.order(18.04);
/// assert_eq!(order.article_and_size(), "hexagonal spacer, female both ends M3 x 18 mm");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexSpacer {
    /// Nominal thread diameter, mm.
    pub thread_mm: f64,
    /// Width across flats, mm.
    pub across_flats_mm: f64,
    /// Depth of the thread at either end, mm.
    pub thread_depth_mm: f64,
}

impl HexSpacer {
    /// M3 spacer, 5.5 mm across flats.
    pub const M3: Self = Self { thread_mm: 3.0, across_flats_mm: 5.5, thread_depth_mm: 10.0 };

    /// Returns the distance of a corner from the axis, mm.
    pub fn corner_radius_mm(&self) -> f64 {
        corner_mm(self.across_flats_mm)
    }

    /// Returns the order for a shop: to a tenth of a millimetre, as a lathe can shorten it.
    pub fn order(&self, length_mm: f64) -> Order {
        let size = format!("M{} x {} mm", self.thread_mm, (10.0 * length_mm).round() / 10.0);
        Order::new("hexagonal spacer, female both ends", size)
            .with_tool(format!("spanner or pliers {} mm", self.across_flats_mm))
    }

    /// Returns the solid of the spacer, bored through.
    pub fn solid(&self, length_mm: f64) -> Solid {
        threaded_hexagon(self.across_flats_mm, length_mm, self.thread_mm).named("spacer")
    }
}
