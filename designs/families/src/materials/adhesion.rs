//! Adhesion between bodies and its strength, from the words of the chain, the bodies' materials, and a table of
//! conservative strengths.

use fabkit_geometry::{
    Action, Adhesion, Assembly, Body, MaterialClass, MaterialProperties, MechanicalRole, Sensor,
    Step,
};

use super::catalogue::Catalogue;
use super::{StockCatalogue, castable_properties};

/// Agent between two faces that join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BondAgent {
    /// Nothing: one body was cast on the other.
    Cast,
    /// Nothing but a primer on the face that the other body was cast on.
    Primed,
    /// Silicone that cures between the faces.
    WetSilicone,
    /// Glue or sealant of silicone.
    SiliconeGlue,
    /// Instant adhesive.
    Cyanoacrylate,
    /// Solvent that welds plastics.
    Solvent,
    /// Unspecified glue.
    Glue,
}

/// Words of an instruction that name the agent; the first match counts.
const AGENTS: [(&str, BondAgent); 9] = [
    ("sil-poxy", BondAgent::SiliconeGlue),
    ("sealant", BondAgent::SiliconeGlue),
    ("cyanoacrylate", BondAgent::Cyanoacrylate),
    ("instant adhesive", BondAgent::Cyanoacrylate),
    ("solvent cement", BondAgent::Solvent),
    ("same silicone", BondAgent::WetSilicone),
    ("clear gel as glue", BondAgent::WetSilicone),
    ("wet gel", BondAgent::WetSilicone),
    ("glue", BondAgent::Glue),
];

/// Largest distance of glued faces, mm: a film of glue fills it.
const GLUE_REACH_MM: f64 = 0.35;

/// Largest distance of a cast layer from its wall, mm; only rounding separates them.
const CAST_REACH_MM: f64 = 1e-3;

/// Shear and tensile strength of bare silicone on a smooth face, MPa.
///
/// Polydimethylsiloxane that only touches glass adheres up to about 34 kPa (McDonald and Whitesides, Acc. Chem. Res.
/// 35, 2002: 5 psi); a third of it, because a mold's release agent and a finger's grease are not clean glass.
const BARE_MPA: [f64; 2] = [0.01; 2];

impl BondAgent {
    /// Finds the agent that a step's instruction names.
    fn find_in_step(step: &Step) -> Option<Self> {
        let text = step.instruction.to_lowercase();
        AGENTS.iter().find(|(word, _)| text.contains(word)).map(|(_, agent)| *agent)
    }

    /// Returns the word for the agent in joints.
    fn word(self) -> &'static str {
        match self {
            Self::Cast => "cast on",
            Self::Primed => "cast on primer",
            Self::WetSilicone => "wet silicone",
            Self::SiliconeGlue => "silicone glue",
            Self::Cyanoacrylate => "cyanoacrylate",
            Self::Solvent => "solvent cement",
            Self::Glue => "glue",
        }
    }

    /// Returns lower bounds of the shear and tensile strength between two sorts of material, MPa; `None` if the joint
    /// does not hold.
    fn strength_mpa(self, sorts: [Option<MaterialClass>; 2]) -> Option<[f64; 2]> {
        let is = |sort| sorts.contains(&Some(sort));
        let both = |sort| sorts == [Some(sort); 2];
        if is(MaterialClass::Liquid) {
            return None;
        }
        let holds = match self {
            // Chosen: an eighth of the strength of the softest gel (Ecoflex 00-10: 0.83 MPa); fresh silicone binds to
            // clean, cured silicone of the same cure until one of them tears.
            Self::Cast | Self::WetSilicone | Self::Primed | Self::SiliconeGlue
                if both(MaterialClass::Silicone) =>
            {
                [0.1; 2]
            }
            // Chosen: primed joints fail in the silicone (Dow's guides of 1200 OS and PR-1200), which tears at 1 MPa or
            // more; a soft joint under tension peels, which takes a fraction.
            Self::Primed => [0.2, 0.1],
            // Chosen: sealants and Sil-Poxy are sold with 1 to 2 MPa of lap shear on clean plastics; a tenth.
            Self::SiliconeGlue => [0.2, 0.1],
            // Wet silicone wets better than a poured mold does, but holds no better for that.
            Self::Cast | Self::WetSilicone => BARE_MPA,
            // Loctite's data sheets of 401 and 406: on silicone rubber only with the primer SF 770.
            Self::Cyanoacrylate | Self::Glue | Self::Solvent if is(MaterialClass::Silicone) => {
                BARE_MPA
            }
            // Loctite's data sheets of 401: lap shear 3 MPa and more on ABS and acrylic; a third for print layers and
            // imperfect cleaning, and half of that under peel.
            Self::Cyanoacrylate | Self::Glue => [1.0, 0.5],
            // Welded acrylic bears more than 10 MPa; solvent films have bubbles.
            Self::Solvent if both(MaterialClass::Acrylic) => [5.0, 2.5],
            Self::Solvent => BARE_MPA,
        };
        Some(holds)
    }

    /// Returns the largest distance of joined faces, mm.
    fn reach_mm(self) -> f64 {
        if matches!(self, Self::Cast | Self::Primed) { CAST_REACH_MM } else { GLUE_REACH_MM }
    }
}

/// Sets the substance of every body.
pub(crate) fn assign_substances(
    sensor: &mut Sensor,
    materials: &Catalogue,
    stock: &StockCatalogue,
) {
    let diffusers: Vec<&String> =
        sensor.lightings.iter().filter_map(|lighting| lighting.diffuser.as_ref()).collect();
    for body in &mut sensor.bodies {
        let known = materials.find(&body.material).map(castable_properties);
        // A family's own statement overrides what the material's name suggests.
        let told = body.substance.is_dark;
        if body.is_window || body.has_unknown_transparency() {
            // What a file states of the material of a window, or of a liquid that is no material for casting.
            let cast = materials.find(&body.material).and_then(|cast| cast.clarity());
            let clarity = cast.or_else(|| stock.window_transparency(&body.material));
            clarity.into_iter().for_each(|clarity| body.set_clarity(clarity));
        }
        if diffusers.contains(&&body.name) {
            let clarity = stock.diffuser_transparency(body);
            clarity.into_iter().for_each(|clarity| body.set_clarity(clarity));
        }
        let mut substance = known.unwrap_or_else(|| stock.properties(body));
        substance.is_dark = told.or(substance.is_dark);
        body.substance = substance;
        // Only for made parts whose transparency nobody has stated.
        if body.is_made() && in_use(body) && body.optics.is_none() && body.opacity == 1.0 {
            stock.print_transparency(body).into_iter().for_each(|light| body.set_clarity(light));
        }
        // A user who calls the material bare means it, even if a step seals it.
        if stock.is_bare(body) {
            body.sealed_by = None;
        }
    }
}

/// Walks through the chain and records which bodies adhere in the finished sensor.
pub(crate) fn find_adhesions(sensor: &mut Sensor) {
    let mut adhering = AdhesionFinder { sensor, found: Vec::new() };
    for (index, step) in sensor.chain.iter().enumerate() {
        adhering.step(index, step);
    }
    sensor.adhesions = adhering.found;
}

/// Collector of the joints of a chain.
struct AdhesionFinder<'a> {
    sensor: &'a Sensor,
    found: Vec<Adhesion>,
}

impl<'a> AdhesionFinder<'a> {
    /// Adds the joints of a step.
    fn step(&mut self, index: usize, step: &'a Step) {
        match &step.action {
            Action::Pour(pour) => self.cast(index, &pour.layer, &pour.walls),
            Action::Spray(spray) => self.cast(index, &spray.layer, &spray.onto),
            Action::Bond(_) => {
                self.add_glued(step, BondAgent::find_in_step(step).unwrap_or(BondAgent::Glue));
                self.add_on_wet_layer(index, step);
            }
            Action::Assemble => {
                if let Some(agent) = BondAgent::find_in_step(step) {
                    self.add_glued(step, agent);
                }
            }
            Action::Make | Action::Prepare | Action::Demold(_) => {}
        }
    }

    /// Adds the joints of a cast layer with its walls.
    fn cast(&mut self, index: usize, layer: &str, walls: &[String]) {
        for wall in walls {
            let agent =
                if self.is_primed(index, wall) { BondAgent::Primed } else { BondAgent::Cast };
            self.add([layer, wall], agent);
        }
    }

    /// Returns whether a step up to this one primes the wall: one that names it, or the pour itself.
    fn is_primed(&self, index: usize, wall: &str) -> bool {
        let chain = &self.sensor.chain[..=index];
        chain.iter().enumerate().any(|(at, step)| {
            let text = step.instruction.to_lowercase();
            let is_meant = step.bodies.iter().any(|body| body == wall);
            (at == index || is_meant) && text.contains("prime")
        })
    }

    /// Adds the joints of a step with glue: between all bodies that it lists or mentions in its instruction.
    fn add_glued(&mut self, step: &Step, agent: BondAgent) {
        let text = step.instruction.to_lowercase();
        // Wet silicone between primed faces bonds like a casting on primer.
        let is_primed = agent == BondAgent::WetSilicone && text.contains("prime");
        let agent = if is_primed { BondAgent::Primed } else { agent };
        let speaks = |name: &str| text.contains(name);
        // Fasteners and threaded bodies hold by their thread.
        let is_glued =
            |body: &Body| !matches!(body.duty, MechanicalRole::Fastener | MechanicalRole::Threaded);
        let named = |body: &&Body| {
            is_glued(body) && (step.bodies.contains(&body.name) || speaks(&body.name))
        };
        let bodies: Vec<&str> =
            self.sensor.bodies.iter().filter(named).map(|body| body.name.as_str()).collect();
        for (at, a) in bodies.iter().enumerate() {
            for b in &bodies[at + 1..] {
                self.add([a, b], agent);
            }
        }
    }

    /// Adds the joints of bodies that are laid onto a layer poured in the previous step, before it has cured.
    fn add_on_wet_layer(&mut self, index: usize, step: &Step) {
        let before = index.checked_sub(1).and_then(|at| self.sensor.chain.get(at));
        let Some(Step { action: Action::Pour(pour), .. }) = before else { return };
        for body in &step.bodies {
            let agent = if self.is_primed(index, body) {
                BondAgent::Primed
            } else {
                BondAgent::WetSilicone
            };
            self.add([&pour.layer, body], agent);
        }
    }

    /// Adds a joint, if both bodies stay in the sensor and the agent holds between them.
    fn add(&mut self, names: [&str; 2], agent: BondAgent) {
        let [Some(a), Some(b)] = names.map(|name| self.sensor.body(name)) else { return };
        // A material that states that it does not stick is believed.
        let is_loose = self.sensor.loose.iter().any(|loose| {
            [[&loose.layer, &loose.substrate], [&loose.substrate, &loose.layer]]
                .contains(&[&a.name, &b.name])
        });
        if a.name == b.name || !in_use(a) || !in_use(b) || is_loose {
            return;
        }
        let sorts = [a, b].map(|body| body.substance.class);
        let Some([shear, pull]) = agent.strength_mpa(sorts) else { return };
        // A joint bears no more than the weaker of the two bodies.
        let tears = [a, b].map(|body| tears_mpa(&body.substance));
        let most = tears[0].min(tears[1]);
        self.found.push(Adhesion {
            bodies: [a.name.clone(), b.name.clone()],
            by: agent.word().to_owned(),
            reach_mm: agent.reach_mm(),
            shear_mpa: shear.min(most),
            pull_mpa: pull.min(most),
        });
    }
}

/// Returns the tear strength of a substance, MPa; infinite if not known.
fn tears_mpa(substance: &MaterialProperties) -> f64 {
    substance.tear_strength_mpa.unwrap_or(f64::INFINITY)
}

/// Returns whether a body is part of the assembled sensor.
fn in_use(body: &Body) -> bool {
    body.placements.iter().any(|placement| placement.assembly == Assembly::sensor())
}
