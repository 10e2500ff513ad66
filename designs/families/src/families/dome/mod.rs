//! Dome sensors: a hemisphere of gel layers on a glass tube, a ring of LEDs and a camera below them (R-Tac0).
//!
//! This file holds the layout, the screw joints and the surface profile, on which all other files of the family
//! build.

mod chain;
mod constraints;
mod electronics;
mod housing;
mod molds;
mod parameters;

use fabkit_geometry::{
    Body, CUT_OVERLAP_MM, DomeSurface, FixtureGrip, Path, Point3, Pose, PressFit, Process, Sensor,
    Solid, Vector3,
};

use crate::blocks::adapter::MountFace;
use crate::blocks::cable_openings::FloorSlot;
use crate::blocks::lighting::thickness_lighting;
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{
    self, DOWEL, Rect, ScrewJoint, corners, led_ring, mm, press_fit, ring, sphere,
};
use crate::chain_builder::{shrinkage, visible_layers};
use crate::fits::Fit;
use crate::hardware::{HeatSetNut, Screw};
use crate::parameters::RuleReport;
use crate::{Family, FamilyOutput, Header, layout};
use molds::{Cavity, FormTools, cup};
use parameters::*;

/// Dome family, whose built-in example is R-Tac0.
pub(crate) struct DomeFamily;

impl Family for DomeFamily {
    type Parameters = Dome;
    const NAME: &'static str = "dome";
    const SUMMARY: &'static str = "a hemisphere of gels on a glass tube, lit by a ring of LEDs";
    const EXAMPLE: &'static str = "rtac0";
    const DEFAULTS: &'static [(&'static str, &'static str)] =
        &[("dome.yaml (defaults)", include_str!("defaults.yaml"))];

    fn check(parameters: &Dome, report: &mut RuleReport) {
        constraints::check(parameters, report);
    }

    fn build(parameters: &Dome, header: &Header, _report: &mut RuleReport) -> Option<FamilyOutput> {
        let layout = DomeLayout::new(parameters);
        let face = MountFace {
            holder: BASE,
            mounting: Joints::new(parameters, &layout).mounting,
            replaced_screw_mm: None,
            bottom_z_mm: layout.bottom_z_mm,
            outline: Rect::round(layout.shell_radius_mm),
            exits: vec![electronics::cable_exit(parameters, &layout)],
            heads: Vec::new(),
        };
        let sensor = build_sensor(parameters, header);
        Some(FamilyOutput { sensor, derived: derived_dimensions(parameters), face: Some(face) })
    }
}

/// Builds the sensor: all bodies, circuits, press fits, casting steps and the camera.
fn build_sensor(p: &Dome, header: &Header) -> Sensor {
    let layout = DomeLayout::new(p);
    let [transparent, translucent] = cavities(p, &layout);
    let housing = [housing::shell, housing::base, housing::diffuser, housing::led_board]
        .map(|make| make(p, &layout));
    let both = [&transparent, &translucent];
    let molds = both.into_iter().flat_map(|cavity| match p.molds.route {
        MoldRoute::Printed => {
            let [a, b] = molds::halves(p, &layout, cavity);
            vec![a, b, molds::lid(p, &layout, cavity)]
        }
        MoldRoute::Silicone => {
            vec![molds::form_bridge(p, &layout, cavity), molds::lid(p, &layout, cavity)]
        }
    });
    let is_silicone = p.molds.route == MoldRoute::Silicone;
    let cup = is_silicone.then(|| molds::form_cup(p, &layout));
    let is_dipped = p.coat.method == CoatMethod::Dip;
    let dipping = is_dipped.then(|| molds::coating_parts(p, &layout));
    let parts: Vec<Body> = housing
        .into_iter()
        .chain(housing::baffle(p, &layout))
        .chain(cup)
        .chain(molds)
        .chain([molds::collar(p, &layout), molds::connector(p, &layout)])
        .chain([molds::tube_jig(p, &layout)])
        .chain(dipping.into_iter().flatten())
        .collect();
    let touch = touch_surface(p, &layout);
    let mut layers = housing::layers(p, &layout, &touch);
    layers.splice(1..1, housing::locking_gel(p, &layout));
    if is_silicone {
        layers.extend(both.map(|cavity| molds::silicone_mold(p, &layout, cavity)));
    }
    let c = &p.camera;
    let camera = c.view.camera_at(-c.depth.mm(), c.images.size_px());
    let bodies = parts.into_iter().chain(layers).chain(electronics::components(p, &layout));
    Sensor {
        chain: chain::chain(p, &layout),
        circuits: vec![electronics::circuit(p, &layout)],
        press_fits: press_fits(p, &Joints::new(p, &layout)),
        touch: Some(touch.into()),
        lightings: vec![
            thickness_lighting([parameters::TRANSLUCENT_GEL]).through(parameters::DIFFUSER),
        ],
        jpeg_quality: u8::try_from(p.camera.jpeg_quality).ok().filter(|quality| *quality > 0),
        visible_bodies: visible_layers(
            &[(parameters::TRANSLUCENT_GEL, &p.translucent_gel.material)],
            parameters::BLACK_COAT,
        ),
        ..blocks::sensor(header, camera, bodies)
    }
}

/// Returns the touched surface, and the part of the shell that fixtures grip. The shell stands on its lower rim.
fn touch_surface(p: &Dome, layout: &DomeLayout) -> DomeSurface {
    let radius_mm = layout.surface_radius_mm;
    DomeSurface {
        dome: sphere(radius_mm),
        centre_z_mm: layout.wall_height_mm,
        foot_z_mm: 0.0,
        // The layers below the translucent gel are stiffer by an order of magnitude, and their brightness does not
        // change when they are pressed.
        max_indentation_mm: p.translucent_gel.thickness.mm(),
        grip: FixtureGrip {
            outline: Path::circle([0.0, 0.0], layout.shell_radius_mm),
            top_z_mm: 0.0,
            bottom_z_mm: layout.bottom_z_mm,
            clear_radius_mm: layout.shell_bore_radius_mm,
            key: None,
            threads: Joints::new(p, layout).mounting.thread_cut().landmarks,
        },
    }
}

/// Returns the mold cavities of the two cast layers: the transparent gel, then the translucent gel.
fn cavities(p: &Dome, layout: &DomeLayout) -> [Cavity; 2] {
    // A dipped coat is applied after demolding, so the mold is smaller by its thickness.
    let outer = match p.coat.method {
        CoatMethod::Spray => layout.surface_radius_mm,
        CoatMethod::Dip => layout.translucent_radius_mm,
    };
    let route = p.molds.route;
    [
        Cavity {
            layer_name: "transparent",
            route,
            halves: [INNER_A, INNER_B],
            lid: INNER_LID,
            form: FormTools {
                assembly: INNER_FORM,
                bridge: INNER_BRIDGE,
                tube: INNER_FORM_TUBE,
                mold: INNER_SILICONE,
            },
            assembly: TRANSPARENT_MOLD,
            shrinkage: shrinkage(&p.transparent_gel.material),
            radius: layout.transparent_radius_mm,
            core_radius: layout.tube_radius_mm,
        },
        Cavity {
            layer_name: "translucent",
            route,
            halves: [OUTER_A, OUTER_B],
            lid: OUTER_LID,
            form: FormTools {
                assembly: OUTER_FORM,
                bridge: OUTER_BRIDGE,
                tube: OUTER_FORM_TUBE,
                mold: OUTER_SILICONE,
            },
            assembly: TRANSLUCENT_MOLD,
            shrinkage: shrinkage(&p.translucent_gel.material),
            radius: outer,
            core_radius: layout.transparent_radius_mm,
        },
    ]
}

/// Lists the overlaps between bodies that are intended.
fn press_fits(p: &Dome, joints: &Joints) -> Vec<PressFit> {
    let pressed = |inner, outer, reason| {
        let overlap = -p.making.gap_mm(outer, Process::Fdm, Fit::Press);
        press_fit(inner, outer, overlap, reason)
    };
    let screws = [
        joints.camera.press_fit(BASE),
        joints.form.press_fit(FORM_CUP).filter(|_| p.molds.route == MoldRoute::Silicone),
        joints.shell_base.press_fit(BASE),
        // If both joints use the same kind of nut, one press fit covers both.
        joints
            .insert_joint()
            .filter(|mounting| mounting.nut_name() != joints.shell_base.nut_name())
            .and_then(|mounting| mounting.press_fit(BASE)),
    ];
    let mut fits = vec![pressed(LED_BOARD, SHELL, "the board is pressed in")];
    if p.baffle.wall.mm() > 0.0 {
        let overlap = -p.making.gap_mm(BAFFLE, Process::Fdm, Fit::Press);
        fits.push(press_fit(BAFFLE, LED_BOARD, overlap, "the baffle is pressed in"));
    }
    fits.extend(screws.into_iter().flatten());
    if p.molds.route == MoldRoute::Printed {
        let stay = [INNER_A, OUTER_A].map(|half| pressed(DOWEL, half, "the dowels stay in half a"));
        let lid = [INNER_B, OUTER_B];
        let lid = lid.map(|half| pressed(DOWEL, half, "the lid's dowel stays in half b"));
        fits.extend(stay.into_iter().chain(lid));
    }
    if p.coat.method == CoatMethod::Dip {
        let coat = p.coat.thickness.mm();
        let walls = cavities(p, &DomeLayout::new(p))[1].mold_walls();
        fits.extend(walls.into_iter().map(|wall| {
            press_fit(BLACK_COAT, wall, coat, "the coat is squeezed where the mold only centres")
        }));
    }
    fits
}

/// Lists the derived dimensions that `fabkit show` prints.
fn derived_dimensions(p: &Dome) -> Vec<(String, String)> {
    let layout = DomeLayout::new(p);
    vec![
        mm("apex above the foot", layout.apex_z()),
        mm("total height", layout.total_height()),
        mm("shell height", layout.shell_height()),
        mm("shell bore radius", layout.shell_bore_radius_mm),
        mm("translucent gel outer radius", layout.translucent_radius_mm),
        mm("transparent gel outer radius", layout.transparent_radius_mm),
        mm("transparent gel thickness", layout.transparent_radius_mm - layout.tube_radius_mm),
        mm("tube inner radius", layout.tube_bore_radius_mm),
        mm("lens front below the foot", -layout.lens_front_z_mm),
        mm("camera board top below the foot", -layout.camera_board_top_z_mm),
    ]
}

// ------ Layout ------
//
// Radii and heights that more than one part needs, each derived once.

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// The sensor is a stack without play from the tip down. The gel layers and the tube stand on the diffuser at
    /// z = 0. Ribs in the shell keep the diffuser and the LED board apart. The base pushes the board against the ribs
    /// and ends flush with the shell.
    pub struct DomeLayout from p: &Dome {
        /// Height of the straight wall, which is the height of the centres of all domes.
        wall_height_mm = p.surface.wall_height.mm();
        /// Outer radius of the coat, which is the sensing surface.
        surface_radius_mm = p.surface.radius.mm();
        /// Radius of the interface between translucent gel and coat.
        translucent_radius_mm = surface_radius_mm - p.coat.thickness.mm();
        /// Radius of the interface between transparent and translucent gel.
        transparent_radius_mm = surface_radius_mm - p.translucent_gel.thickness.mm();
        /// Outer radius of the tube.
        tube_radius_mm = p.tube.outer_diameter.mm() / 2.0;
        /// Inner radius of the tube.
        tube_bore_radius_mm = tube_radius_mm - p.tube.wall.mm();

        /// Outer radius of shell and base.
        shell_radius_mm = p.shell.outer_diameter.mm() / 2.0;
        /// Inner radius of the shell.
        shell_bore_radius_mm = shell_radius_mm - p.shell.wall.mm();
        let slide = p.making.gap_mm(SHELL, Process::Fdm, Fit::Slide);
        /// Smallest radius of the ribs, which reach inwards from the shell.
        rib_radius_mm = shell_bore_radius_mm - p.shell.rib_depth.mm();
        /// Outer radius of the diffuser.
        diffuser_radius_mm =
            shell_bore_radius_mm - slide - p.shell.shoulder.mm();
        /// Outer radius of the LED board.
        board_radius_mm = shell_bore_radius_mm - p.making.gap_mm(SHELL, Process::Fdm, Fit::Press);
        /// Outer radius of the base's plug.
        base_radius_mm = shell_bore_radius_mm - slide;

        /// Bottom of the diffuser, which is the top of the ribs.
        diffuser_bottom_z_mm = -p.diffuser.thickness.mm();
        /// Inner radius of the rim around the diffuser.
        seat_radius_mm = shell_bore_radius_mm - p.shell.shoulder.mm();
        /// Gel surface that faces the camera.
        gel_face_z_mm = match p.filling_gel.lock_depth.mm() {
            0.0 => 0.0,
            depth => diffuser_bottom_z_mm - depth,
        };
        /// Top of the LED board, which is the bottom of the ribs.
        board_top_z_mm = diffuser_bottom_z_mm - p.diffuser.height_above_board.mm();
        /// Bottom of the LED board, which is the top of the base.
        base_top_z_mm = board_top_z_mm - p.led_board.thickness.mm();
        /// Bottom of base and shell.
        bottom_z_mm = base_top_z_mm - p.base.height.mm();

        /// Front face of the camera's lens.
        lens_front_z_mm = -p.camera.depth.mm() + p.camera.board.pupil_behind_front.mm();
        /// Face of the camera board that carries the lens.
        camera_board_top_z_mm = lens_front_z_mm - p.camera.board.lens_height.mm();
        /// Face of the camera board that rests on the base.
        camera_board_bottom_z_mm = camera_board_top_z_mm - p.camera.board.board_thickness.mm();
        /// Floor of the pocket behind the camera board.
        relief_z_mm = camera_board_bottom_z_mm - p.camera.back_clearance.mm();
    }
}

/// Least clearance between the LED board and a lens holder that ends below it, mm.
const HOLDER_BELOW_MM: f64 = 0.5;

impl DomeLayout {
    /// Returns whether the camera's lens holder ends below the LED board, so that only the barrel passes through it.
    pub fn is_holder_below(&self, p: &Dome) -> bool {
        let barrel_mm = p.camera.board.lens_height.mm() - p.camera.board.holder_height.mm();
        self.lens_front_z_mm - barrel_mm <= self.base_top_z_mm - HOLDER_BELOW_MM + 1e-9
    }

    /// Largest distance from the axis, mm, of the lens parts that pass through the LED board: the barrel, and the
    /// corners of its holder if the holder reaches that high.
    pub fn passing_radius_mm(&self, p: &Dome) -> f64 {
        let barrel = p.camera.board.barrel_diameter.mm() / 2.0;
        if self.is_holder_below(p) {
            barrel
        } else {
            barrel.max(p.camera.board.holder_size.mm() / std::f64::consts::SQRT_2)
        }
    }

    /// Height of the shell, from its lower rim to the foot of the sensing surface, mm.
    pub fn shell_height(&self) -> f64 {
        -self.bottom_z_mm
    }

    /// Height of the whole sensor, mm.
    pub fn total_height(&self) -> f64 {
        self.wall_height_mm + self.surface_radius_mm - self.bottom_z_mm
    }

    /// Height of the apex above the foot, mm.
    pub fn apex_z(&self) -> f64 {
        self.wall_height_mm + self.surface_radius_mm
    }
}

/// Radial overlap of the baffle's flange on the LED board, mm. The wire holes begin beyond it.
pub const BAFFLE_FLANGE_MM: f64 = 0.35;

/// Poses of the LEDs on their board: z axis up, x axis outwards.
pub fn led_poses(p: &Dome, layout: &DomeLayout) -> Vec<Pose> {
    // Ribs start at angle 0. LEDs are offset by half a step, so that no rib shades one.
    led_ring!(p.leds).poses(layout.board_top_z_mm, 0.5)
}

/// Slot for the cable below the camera's connector.
pub fn cable_slot(p: &Dome) -> FloorSlot {
    let (length, width) = (p.base.cable_slot_length, p.base.cable_slot_width);
    FloorSlot { length, width, along: 0, at: [0.0; 2], turn: p.base.cable_angle }
}

/// Edge lengths along x and y of the recess behind the camera board, mm. It ends at the pads around the board's
/// screws.
pub fn relief_edges_mm(p: &Dome) -> [f64; 2] {
    let pad = Screw::M1_6X5.pilot_hole_mm() + 1.2;
    [p.camera.board.screw_spacing, p.camera.board.screw_spacing_y].map(|spacing| spacing.mm() - pad)
}

// ------ Joints ------
//
// Screws of the sensor and of its tools. Each joint is defined here and nowhere else.

/// Thickness of plastic below the nuts that join shell and base, mm.
const NUT_FLOOR_MM: f64 = 1.0;

/// Free depth behind a heat-set nut, mm.
const NUT_SPARE_MM: f64 = 0.6;

/// Thickness of the floor between a mounting hole and the camera pocket, mm.
const MOUNT_FLOOR_MM: f64 = 1.0;

/// All screw joints, in the sensor frame.
pub struct Joints {
    /// Screws through the shell, pointing at the axis, into nuts in the base.
    pub shell_base: ScrewJoint,
    /// Screws through the corners of the camera board into the base.
    pub camera: ScrewJoint,
    /// Holes in the base's bottom for mounting the sensor. The user provides the screws.
    pub mounting: ScrewJoint,
    /// Screws through the bridge into the cup of the silicone form.
    pub form: ScrewJoint,
}

impl Joints {
    /// Places the joints. The result is meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Dome, layout: &DomeLayout) -> Self {
        Self {
            shell_base: shell_base(p, layout),
            camera: camera(p, layout),
            mounting: mounting(p, layout).joint(layout.bottom_z_mm),
            form: cup(p, layout).joint(),
        }
    }

    /// Returns the mounting joint if its holes hold heat-set nuts.
    pub fn insert_joint(&self) -> Option<&ScrewJoint> {
        self.mounting.nut_name().map(|_| &self.mounting)
    }
}

fn shell_base(p: &Dome, layout: &DomeLayout) -> ScrewJoint {
    let (screw, nut) = (Screw::M2X4, HeatSetNut::M2);
    // The nuts sit below the camera pocket: beside the pocket the wall is too thin for them.
    let z = layout.bottom_z_mm + NUT_FLOOR_MM + nut.diameter_mm / 2.0;
    // A flat end of this width is flush with a round wall where its rim, not its centre, meets the wall.
    let flush = |radius: f64, width: f64| {
        let radius = (radius.powi(2) - (width / 2.0).powi(2)).sqrt();
        ring(p.shell.screws, 0.0, Pose::z_to(Vector3::x(), Point3::new(radius, 0.0, z)))
    };
    let heads = flush(layout.shell_radius_mm, screw.head_diameter_mm());
    let nuts = flush(layout.base_radius_mm, nut.diameter_mm);
    ScrewJoint::heat_set("screw", screw, heads, (nut, nuts, NUT_SPARE_MM))
}

fn camera(p: &Dome, layout: &DomeLayout) -> ScrewJoint {
    let half =
        [p.camera.board.screw_spacing, p.camera.board.screw_spacing_y].map(|mm| mm.mm() / 2.0);
    let poses = corners(half).map(|[x, y]| Pose::translation(x, y, layout.camera_board_top_z_mm));
    // Drilled through the whole base, so that a broken screw can be pushed out.
    let depth = layout.camera_board_top_z_mm - layout.bottom_z_mm + CUT_OVERLAP_MM;
    ScrewJoint::self_tapping("camera screw", Screw::M1_6X5, poses.to_vec(), depth)
}

/// Defines the holes that the sensor is mounted by.
pub(super) fn mounting<'a>(p: &'a Dome, layout: &DomeLayout) -> Mounting<'a> {
    Mounting {
        mount: &p.mount,
        // Offset by half a step from the nuts.
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.5),
        depth_mm: layout.camera_board_bottom_z_mm - MOUNT_FLOOR_MM - layout.bottom_z_mm,
        is_through: false,
        holds: (
            &[MountHold::Tapped, MountHold::Insert, MountHold::ShortInsert],
            "the camera and the LED board stand above the holes, where heads would be",
        ),
    }
}

// ------ Surface ------
//
// The shape that all layers of a dome sensor share.

/// Returns a solid hemisphere on a straight wall that stands on z = 0: the sensor's contact module out to
/// `radius_mm`.
pub fn dome(radius_mm: f64, wall_height_mm: f64) -> Solid {
    dome_from(0.0, radius_mm, wall_height_mm)
}

/// Returns the same dome as a cutting tool, which extends below its foot.
pub fn dome_tool(radius_mm: f64, wall_height_mm: f64) -> Solid {
    dome_from(-CUT_OVERLAP_MM, radius_mm, wall_height_mm)
}

/// Returns the shell between two domes of the same wall height.
pub fn dome_shell(inner_mm: f64, outer_mm: f64, wall_height_mm: f64) -> Solid {
    dome(outer_mm, wall_height_mm).minus(dome_tool(inner_mm, wall_height_mm))
}

fn dome_from(foot_mm: f64, radius_mm: f64, wall_height_mm: f64) -> Solid {
    let path = Path::from([0.0, foot_mm]).line([radius_mm, foot_mm]);
    // A wall of height 0 would add an edge of length 0.
    let path = if wall_height_mm > foot_mm { path.line([radius_mm, wall_height_mm]) } else { path };
    let apex = [0.0, wall_height_mm + radius_mm];
    Solid::revolution(path.arc(apex, [0.0, wall_height_mm], true).close())
}
