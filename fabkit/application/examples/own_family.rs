//! Defines a new sensor family, checks a sensor of it and exports it: a puck of gel on a window, a camera below, LEDs
//! around.
//! `cargo run --release -p fabkit-application --example own_family -- FOLDER`.

use std::error::Error;
use std::path::Path as FilePath;

use fabkit_application::designs::blocks::{self, ScrewJoint};
use fabkit_application::designs::chain_builder::*;
use fabkit_application::designs::parameters::{RuleReport, limits, parameters};
use fabkit_application::designs::{
    Family, FamilyEntry, FamilyOutput, Fit, Header, Registry, Screw, bodies, gap_mm,
    materials::Castable,
};
use fabkit_application::geometry::*;
use fabkit_application::{checks, exports, staging};

parameters! {
    /// Everything about a puck.
    pub struct Puck {
        /// Diameter of the gel, without its coat.
        gel_diameter: Length = 8.0..=60.0,
        /// Thickness of the gel, without its coat.
        gel_thickness: Length = 1.0..=8.0,
        /// Thickness of the opaque coat.
        coat: Length = 0.05..=0.5,
        /// What the gel is cast from.
        gel_material: Castable,
        /// What the coat is made of.
        coat_material: Castable,
        /// Diameter of housing and base.
        diameter: Length = 20.0..=100.0,
        /// How many LEDs are glued to the housing's wall.
        leds: u32 = 2..=8,
        /// From the gel's foot down to the camera's entrance pupil.
        camera_depth: Length = 8.0..=60.0,
        /// View from edge to edge of the image.
        field_of_view: Angle = 20.0..=120.0,
    }
}

// Names of bodies with their summaries. They are constants, so that a misspelt name does not compile.
bodies! {
    WINDOW "window" "carries the gel";
    HOUSING "housing" "holds window and LEDs";
    BASE "base" "carries the camera";
    RING "mold-ring" "rim of the open mold";
    GEL "gel" "clear, gives way";
    COAT "coat" "keeps light in";
    CAMERA "camera";
    LED "led";
}

const MOLD: AssemblyName = AssemblyName("mold");
/// Thickness of the window, and its margin around the gel, mm.
const WINDOW_MM: [f64; 2] = [3.0, 3.0];
/// Side and thickness of the camera's board, and height of its lens front above the board, mm.
const BOARD_MM: [f64; 3] = [15.0, 1.0, 10.0];
/// Thickness of the base, thickness left under its screw heads, and radius of the cable hole, mm.
const BASE_MM: [f64; 3] = [8.0, 4.0, 4.0];

/// Derived radii and heights in the sensor frame, mm. The gel's foot is at z = 0.
struct Layout {
    pad: f64,
    window: f64,
    chamber: f64,
    outside: f64,
    joint_z: f64,
    bottom_z: f64,
    board: ScrewJoint,
    base: ScrewJoint,
}

impl Layout {
    fn new(p: &Puck) -> Self {
        let (pad, outside) = (p.gel_diameter.mm() / 2.0, p.diameter.mm() / 2.0);
        let window = pad + WINDOW_MM[1];
        let chamber = window - 2.0;
        let [_, board, front] = BOARD_MM;
        let joint_z = -p.camera_depth.mm() - front - board;
        let heads = blocks::corners([5.8; 2]).map(|at| blocks::upright(at, joint_z + board));
        let below = blocks::hanging([0.5 * (chamber + outside), 0.0], joint_z - BASE_MM[1]);
        Self {
            pad,
            window,
            chamber,
            outside,
            joint_z,
            bottom_z: joint_z - BASE_MM[0],
            board: ScrewJoint::self_tapping("camera screw", Screw::M1_6X5, heads.to_vec(), 5.5),
            base: ScrewJoint::self_tapping(
                "screw",
                Screw::M3X12,
                blocks::ring(3, 0.0, below),
                13.0,
            ),
        }
    }
}

struct PuckFamily;

impl Family for PuckFamily {
    type Parameters = Puck;
    const NAME: &'static str = "puck";
    const SUMMARY: &'static str = "a round pad on a window above a camera";
    const EXAMPLE: &'static str = "puck";

    // A limit is one expression; its message lists the parameters that it depends on.
    fn check(p: &Puck, report: &mut RuleReport) {
        let l = Layout::new(p);
        limits! { report, p:
            diameter >= 2.0 * (l.window + 6.0), "M3 screws need a wall";
            camera_depth >= l.pad / (p.field_of_view.rad() / 2.0).tan(), "it must see all of the gel";
        }
    }

    fn build(p: &Puck, header: &Header, _: &mut RuleReport) -> Option<FamilyOutput> {
        let l = Layout::new(p);
        let lens = NominalLens::default();
        let camera = blocks::camera_at(-p.camera_depth.mm(), [640, 480], p.field_of_view, lens);
        let touch = touch(p, &l);
        let fits = [l.base.press_fit(HOUSING), l.board.press_fit(BASE)];
        let bodies = [parts(p, &l), layers(p, &l, &touch), bought(p, &l)].concat();
        let sensor = Sensor {
            chain: chain(p, &l),
            press_fits: fits.into_iter().flatten().collect(),
            touch: Some(touch.into()),
            ..blocks::sensor(header, camera, bodies)
        };
        Some(FamilyOutput {
            sensor,
            derived: vec![blocks::mm("total height", -l.bottom_z)],
            face: None,
        })
    }
}

/// Makes the touched surface: the outside of the coat. Fixtures grip the housing.
fn touch(p: &Puck, l: &Layout) -> PlaneSurface {
    PlaneSurface {
        outline: Path::circle([0.0; 2], l.pad + p.coat.mm()),
        top_z_mm: p.gel_thickness.mm() + p.coat.mm(),
        foot_z_mm: 0.0,
        max_indentation_mm: p.gel_thickness.mm() / 2.0,
        grip: FixtureGrip {
            outline: Path::circle([0.0; 2], l.outside),
            top_z_mm: 0.0,
            bottom_z_mm: l.bottom_z,
            clear_radius_mm: BASE_MM[2],
            key: None,
            threads: Vec::new(),
        },
    }
}

fn parts(p: &Puck, l: &Layout) -> Vec<Body> {
    let (over, thickness) = (CUT_OVERLAP_MM, p.gel_thickness.mm());
    let recess = l.window + gap_mm(Process::Fdm, Fit::Slide);
    let holes = [
        Solid::rod(l.chamber, [l.joint_z - over, over]).named("chamber"),
        Solid::rod(recess, [-WINDOW_MM[0], over]).named("window's recess"),
    ];
    let cables = Solid::rod(BASE_MM[2], [l.bottom_z - over, l.joint_z + over]).named("cables");
    let cavity = Solid::rod(l.pad, [-over, thickness + over]).named("cavity");
    let window = Solid::rod(l.window, [-WINDOW_MM[0], 0.0]);
    let housing = Solid::rod(l.outside, [l.joint_z, 0.0]).minus_all(holes);
    let base = Solid::rod(l.outside, [l.bottom_z, l.joint_z]).minus(cables);
    let ring = Solid::rod(l.window, [0.0, thickness]).minus(cavity);
    let sunk = l.base.counterbore_cut(
        BASE_MM[1],
        BASE_MM[0] - BASE_MM[1],
        gap_mm(Process::Fdm, Fit::Snug),
    );
    vec![
        WINDOW
            .made(Process::Laser, window)
            .with_material("clear PMMA")
            .placed([in_sensor().lifted(20.0), MOLD.in_place()]),
        HOUSING
            .made(Process::Fdm, housing)
            .with_material("black PLA")
            .placed([in_sensor()])
            .with_handles(1)
            .cut(l.base.thread_cut()),
        BASE.made(Process::Fdm, base)
            .with_material("black PLA")
            .placed([in_sensor().lifted(-40.0)])
            .with_handles(1)
            .cut(sunk)
            .cut(l.board.thread_cut()),
        RING.made(Process::Fdm, ring)
            .with_material("PLA")
            .placed([MOLD.in_place().lifted(12.0)])
            .with_handles(1),
    ]
}

fn layers(p: &Puck, l: &Layout, touch: &PlaneSurface) -> Vec<Body> {
    let gel = |from_z| Solid::rod(l.pad, [from_z, p.gel_thickness.mm()]);
    let coat = touch.solid(0.0, touch.foot_z_mm).minus(gel(-CUT_OVERLAP_MM));
    let placed = [in_sensor().lifted(34.0), MOLD.in_place()];
    vec![
        GEL.cast(gel(0.0)).with_material(&p.gel_material).placed(placed),
        COAT.cast(coat).with_material(&p.coat_material).placed([in_sensor().lifted(46.0)]),
    ]
}

fn bought(p: &Puck, l: &Layout) -> Vec<Body> {
    let [edge, thickness, front] = BOARD_MM;
    let hole = Solid::rod(Screw::M1_6X5.clearance_hole_mm() / 2.0, [-3.0, 1.0]);
    let plate = Solid::cuboid(edge, edge, thickness).at_z(l.joint_z);
    let plate = plate.minus_all(blocks::copies("hole", &l.board.poses, &hole));
    let top_z = l.joint_z + thickness;
    let lens = Solid::rod(4.0, [top_z - blocks::INTO_MM, top_z + front]).named("lens");
    let camera = Solid::union([plate, lens]);
    // The corners of an LED's back are one glue line away from the round wall.
    let seat = (l.chamber.powi(2) - 2.6f64.powi(2)).sqrt() - 0.8;
    let led = Pose::translation(seat, 0.0, -WINDOW_MM[0] - 4.0);
    let leds = blocks::ring(p.leds, 0.5, led).into_iter().map(|pose| SENSOR.at(pose));
    let led = Solid::cuboid(1.6, 5.0, 3.0);
    let below = |pose: &Pose| SENSOR.at(*pose).lifted(-60.0);
    let camera = CAMERA.bought("UVC module", camera, [in_sensor().lifted(-20.0)]);
    let led = LED.bought("white LED on 5 mm of strip", led, leds).as_attached();
    [vec![camera, led], l.board.bought(below, below), l.base.bought(below, below)].concat()
}

fn chain(p: &Puck, l: &Layout) -> Vec<Step> {
    let up = Vector3::z();
    let top = vec![free_surface(l.pad, p.gel_thickness.mm(), up)];
    let gel = liquid(&p.gel_material, 0.5).fills(&[WINDOW, RING], GEL, up, top);
    let coat = liquid(&p.coat_material, 5.0).coats(&[GEL], COAT);
    let glued = Cure { hours: 1.0, celsius: 23.0 };
    let steps = [
        make("print and cut all parts"),
        step("pour", MOLD, &[WINDOW, RING], gel)
            .with_instruction("clip the ring to the window, fill it level"),
        demold("open", MOLD, vec![rigid(RING, up)]).with_instruction("lift the ring off"),
        step("coat", SENSOR, &[GEL], coat).with_instruction("brush the coat onto the gel"),
        bond("light", SENSOR, &[HOUSING, LED], glued)
            .with_instruction("glue the LEDs to the wall")
            .fixing(&[LED], &[HOUSING], FixingMeans::Glue),
        bond("glue", SENSOR, &[WINDOW, HOUSING], glued)
            .with_instruction("glue the window to its ledge"),
        assemble("camera", SENSOR, &[CAMERA, BASE])
            .with_instruction("cable down, then the screws")
            .also(l.board.names()),
        assemble("close", SENSOR, &[BASE, HOUSING])
            .with_instruction("screw both together")
            .also(l.base.names()),
    ];
    steps.map(|step| step.source("chosen")).to_vec()
}

/// Registry with the family and one sensor of it.
pub static REGISTRY: Registry =
    Registry::new(&[FamilyEntry::new::<PuckFamily>()], &[("puck", include_str!("puck.yaml"))]);

/// Checks a puck and writes its files, all or none. Returns the number of errors.
pub fn run(folder: &FilePath) -> Result<usize, Box<dyn Error>> {
    let puck = REGISTRY.load("puck.yaml", REGISTRY.builtin_yaml("puck").unwrap_or(""), &[], &[])?;
    let findings = checks::check(&puck.sensor)?.findings;
    findings.iter().for_each(|finding| println!("{finding:?}"));
    let exported = exports::export(&puck, &exports::ExportOptions::default(), &|_| ())?;
    staging::write_all(folder, &exported.files, &|| false)?;
    Ok(findings.iter().filter(|f| f.severity == checks::Severity::Error).count())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or(".".into());
    run(FilePath::new(&folder)).map(|findings| println!("{findings} errors"))
}
