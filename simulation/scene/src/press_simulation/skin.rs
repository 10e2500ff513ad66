//! Presses on a skin with liquid channels: forces, and the displacement of each channel's liquid column.

use fabkit_elastic::{
    AMBIENT_AIR_MPA, ChannelOutcome, LiquidOutcome, LiquidSolver, LiquidStack, SkinNode, SoftError,
    SolidIndenter, StrainTheory,
};
use fabkit_export::{NpyArray, NpyValues};
use fabkit_fixtures::{Press, PressBody, Project};
use fabkit_geometry::csv::{CsvCell, CsvTable};
use fabkit_geometry::{CompiledSolid, Sensor, Vector3};
use serde_json::{Value, json};

use super::document::soft_layers;
use super::files::force_svg;
use super::markers::{marks_arrays, marks_document};
use super::{MarkerDisplacement, PressRequest, PressingError};

/// Default distance of nodes, mm.
const SPACING_MM: f64 = 1.0;
/// Largest closing of a channel, as a share of its height, up to which small strain approximately holds.
const MOST_CLOSED: f64 = 0.25;
/// Largest sag of the skin, as a share of its thickness, up to which plates mainly bend. Beyond, they also stretch.
const MOST_SAG: f64 = 0.5;

/// State of a press on a skin at one depth.
#[derive(Clone, Debug)]
pub struct SkinStep {
    /// Depth of the indenter, mm.
    pub depth_mm: f64,
    /// Solution at this depth.
    pub outcome: LiquidOutcome,
}

/// A press on a skin, solved at increasing depths.
#[derive(Debug)]
pub struct SkinPressResult {
    /// Identifier of the press at its full depth.
    pub id: String,
    /// Distance of nodes, mm.
    pub spacing_mm: f64,
    /// States at increasing depth.
    pub steps: Vec<SkinStep>,
    /// Markers at full depth.
    pub marks: Vec<MarkerDisplacement>,
    /// The skin's layers and channels.
    pub stack: LiquidStack,
}

impl PressRequest<'_> {
    /// Returns whether the sensor's only surface is a skin with liquid channels.
    ///
    /// ```
    /// use fabkit_scene::press_simulation::PressRequest;
    ///
    /// let is_on_skin = |name: &str| -> Result<bool, Box<dyn std::error::Error>> {
    ///     let yaml = fabkit_designs::builtin_yaml(name).ok_or("no such sensor")?;
    ///     Ok(PressRequest::is_on_skin(&fabkit_fixtures::load(name, yaml, &[])?.design.sensor))
    /// };
    /// assert!(is_on_skin("fluidic")?);
    /// assert!(!is_on_skin("rtac0")?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_on_skin(sensor: &Sensor) -> bool {
        sensor.touch.is_none() && sensor.liquid.is_some()
    }

    /// Solves a press on a skin with liquid channels at increasing depths.
    ///
    /// # Errors
    /// [`PressingError`]: an unknown press, a displacement along the skin or friction, large strain, a channel that is
    /// pressed shut, contact that does not converge.
    pub fn run_on_skin(&self, project: &Project) -> Result<SkinPressResult, PressingError> {
        self.check()?;
        // The skin's solver has no tangential tractions.
        if self.shear_mm != [0.0; 2] || self.friction.is_some() {
            let problem =
                "a skin with channels of liquid is pressed straight down, without friction";
            return Err(PressingError::Contact { problem: problem.to_owned() });
        }
        if self.level == StrainTheory::Finite {
            return Err(PressingError::Finite { what: "has layers alone, no channels of liquid" });
        }
        let finder = project.skin_press_finder();
        let last = finder.press(&self.id(self.depth_mm))?;
        let spacing_mm = self.spacing_mm.unwrap_or(SPACING_MM);
        let stack = LiquidStack::from_sensor(&project.design.sensor, spacing_mm)?;
        // The setup for the full depth covers all smaller depths as well.
        let ready = with_indenters(&last.bodies, |indenters| Ok(stack.prepare(indenters)?))?;
        let mut steps = Vec::new();
        for i in 1..=self.steps {
            let depth_mm = self.depth_at(i);
            let press = finder.press(&self.id(depth_mm))?;
            steps.push(SkinStep { depth_mm, outcome: press_skin(&ready, &press)? });
        }
        // The solver borrows `stack`, which moves into the result.
        drop(ready);
        let Some(deepest) = steps.last() else { return Err(self.no_steps()) };
        let marks = project.design.sensor.marks.iter().map(|mark| MarkerDisplacement {
            displacement_mm: Some(deepest.outcome.displacement_mm(&stack, &mark.point)),
            axis: mark.axis,
            mark: mark.clone(),
        });
        Ok(SkinPressResult { id: last.id, spacing_mm, marks: marks.collect(), steps, stack })
    }
}

/// Solves a press on a skin that is set up.
///
/// # Errors
/// Returns the errors of [`PressRequest::run_on_skin`].
pub fn press_skin(ready: &LiquidSolver<'_>, press: &Press) -> Result<LiquidOutcome, PressingError> {
    with_indenters(&press.bodies, |indenters| Ok(ready.press(indenters)?))
}

/// Compiles bodies to solids at their poses and passes them to `call`, since indenters borrow their solids.
pub fn with_indenters<T>(
    bodies: &[PressBody],
    call: impl FnOnce(&[SolidIndenter<'_>]) -> Result<T, PressingError>,
) -> Result<T, PressingError> {
    let compiled = |body: &PressBody| CompiledSolid::new(&body.solid);
    let solids = bodies.iter().map(compiled).collect::<Result<Vec<_>, _>>();
    let solids = solids.map_err(SoftError::Solid)?;
    let indenters: Vec<SolidIndenter<'_>> = solids
        .iter()
        .zip(bodies)
        .map(|(solid, body)| SolidIndenter::new(solid, &body.sensor_from_body))
        .collect();
    call(&indenters)
}

impl SkinPressResult {
    /// Returns the last state.
    pub fn last(&self) -> Option<&SkinStep> {
        self.steps.last()
    }

    /// Returns the slope of force over depth at full depth, N/mm: the difference quotient of the last two states.
    pub fn stiffness_n_mm(&self) -> f64 {
        let at =
            |i: usize| self.steps.get(i).map(|step| (step.depth_mm, step.outcome.force_n.norm()));
        let [before, last] = [2, 1].map(|back| self.steps.len().checked_sub(back).and_then(at));
        let (depth_mm, force_n) = before.unwrap_or((0.0, 0.0));
        last.map_or(f64::NAN, |(last_mm, last_n)| (last_n - force_n) / (last_mm - depth_mm))
    }

    /// Returns the thickness of the skin, mm.
    pub fn thickness_mm(&self) -> f64 {
        let levels = &self.stack.skin().levels_mm;
        levels.last().unwrap_or(&0.0) - levels.first().unwrap_or(&0.0)
    }

    /// Returns the largest closing of a channel, as a share of its height.
    pub fn max_closing(&self) -> f64 {
        let share = |channel: &ChannelOutcome| channel.closure_mm / channel.height_mm;
        let last = self.last().into_iter().flat_map(|step| &step.outcome.channels);
        last.map(share).fold(0.0, f64::max)
    }

    /// Returns the largest sag of the skin, as a share of its thickness.
    pub fn relative_sag(&self) -> f64 {
        self.last().map_or(0.0, |step| step.outcome.sag_mm / self.thickness_mm())
    }

    /// Returns the largest ratio of cover thickness to width over all channels. Where it is small, covers are thin
    /// plates.
    pub fn cover_over_width(&self) -> f64 {
        let ratios =
            self.stack.skin().channels.iter().map(|channel| channel.cover_mm / channel.width_mm);
        ratios.fold(0.0, f64::max)
    }

    /// Returns a warning for each limit of the theory that the press exceeds.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let closed = self.max_closing();
        if closed > MOST_CLOSED {
            warnings.push(format!(
                "a channel closes by {:.0} % of its height: above {:.0} %, small strain gives only an estimate",
                100.0 * closed,
                100.0 * MOST_CLOSED
            ));
        }
        let sags = self.relative_sag();
        if sags > MOST_SAG {
            warnings.push(format!(
                "the skin sags by {:.0} % of its thickness: above {:.0} % it also stretches, and is stiffer than this",
                100.0 * sags,
                100.0 * MOST_SAG
            ));
        }
        warnings
    }
}

fn channel(channel: &ChannelOutcome) -> Value {
    json!({
        "name": channel.name,
        "volume_mm3": channel.volume_mm3,
        "column_moves_mm": channel.column_displacement_mm,
        "pressure_kpa": 1e3 * channel.pressure_mpa,
        "closes_mm": channel.closure_mm,
        "height_mm": channel.height_mm,
    })
}

fn step_document(SkinStep { depth_mm, outcome }: &SkinStep) -> Value {
    json!({
        "depth_mm": depth_mm,
        "shear_mm": 0.0,
        "force_n": <[f64; 3]>::from(outcome.force_n),
        "moment_nmm": <[f64; 3]>::from(outcome.moment_nmm),
        "contact_radius_mm": outcome.contact_radius_mm,
        "contact_area_mm2": outcome.contact_area_mm2,
        "max_indentation_mm": outcome.max_indentation_mm,
        "bulge_mm": outcome.bulge_mm,
        "sags_mm": outcome.sag_mm,
        "channels": outcome.channels.iter().map(channel).collect::<Vec<_>>(),
    })
}

/// Returns a press on a skin as `fabkit press --json` prints it: as other presses, with `channels`.
pub fn skin_document(pressed: &SkinPressResult) -> Value {
    let layers = &pressed.stack.layers;
    let force_n = pressed.last().map_or(f64::NAN, |step| step.outcome.force_n.norm());
    // The air in the channels does not scale with the moduli of the silicone. The range therefore starts from 1, so
    // that it contains the nominal force however the stiffness is divided.
    let shares = layers.iter().map(|layer| {
        layer.elasticity.young_range_mpa.map(|young_mpa| young_mpa / layer.elasticity.young_mpa)
    });
    let [low, high] = shares.fold([1.0, 1.0], |[low, high], [least, most]| {
        [f64::min(low, least), f64::max(high, most)]
    });
    let drawn = pressed.stack.skin().channels.first();
    let mut document = json!({
        "format": "fabkit-press",
        "version": 1,
        "press": pressed.id,
        "contact_level": StrainTheory::Linear.name(),
        "is_simulated": true,
        "layers": soft_layers(layers),
        "left_out": pressed.stack.simplifications,
        "nodes": pressed.stack.surface_nodes(),
        "spacing_mm": pressed.spacing_mm,
        "friction": null,
        "stiffness_n_mm": pressed.stiffness_n_mm(),
        "force_range_n": [low * force_n, high * force_n],
        "column_mm2": drawn.map(|channel| channel.column_mm2),
        "shut_in_air_mm3": drawn.map(|channel| channel.air_mm3),
        "air_kpa": 1e3 * AMBIENT_AIR_MPA,
        "validity": {
            "cover_thickness_to_width": pressed.cover_over_width(),
            "most_closed": pressed.max_closing(),
            "most_closed_limit": MOST_CLOSED,
            "sags": pressed.relative_sag(),
            "sags_limit": MOST_SAG,
        },
        "warnings": pressed.warnings(),
        "marks": marks_document(&pressed.marks),
        "curve": pressed.steps.iter().map(step_document).collect::<Vec<_>>(),
    });
    if let (Some(Value::Object(last)), Some(document)) =
        (pressed.last().map(step_document), document.as_object_mut())
    {
        document.extend(last);
    }
    document
}

/// Formats the curve as CSV: force, and the displaced volume of each channel, mm3.
pub fn skin_csv(pressed: &SkinPressResult) -> String {
    let channels = &pressed.stack.skin().channels;
    let volumes = channels.iter().map(|channel| format!("{}_mm3", channel.name.replace(' ', "_")));
    let volumes: Vec<String> = volumes.collect();
    let heads = [
        "depth_mm",
        "force_n",
        "force_x_n",
        "force_y_n",
        "force_z_n",
        "moment_x_nmm",
        "moment_y_nmm",
        "moment_z_nmm",
        "contact_radius_mm",
        "contact_area_mm2",
        "max_indentation_mm",
        "bulge_mm",
        "sags_mm",
    ];
    let mut table =
        CsvTable::with_heads(heads.into_iter().chain(volumes.iter().map(|name| &**name)));
    for SkinStep { depth_mm, outcome } in &pressed.steps {
        let (force, moment) = (outcome.force_n, outcome.moment_nmm);
        let numbers = [
            *depth_mm,
            force.norm(),
            force.x,
            force.y,
            force.z,
            moment.x,
            moment.y,
            moment.z,
            outcome.contact_radius_mm,
            outcome.contact_area_mm2,
            outcome.max_indentation_mm,
            outcome.bulge_mm,
            outcome.sag_mm,
        ];
        let volumes = outcome.channels.iter().map(|channel| channel.volume_mm3);
        table.row(numbers.into_iter().chain(volumes).map(|number| CsvCell::fixed(number, 6)));
    }
    table.finish()
}

/// Plots force over depth as SVG.
pub fn skin_svg(pressed: &SkinPressResult) -> String {
    let steps = pressed.steps.iter().map(|step| [step.depth_mm, step.outcome.force_n.norm()]);
    force_svg(&pressed.id, StrainTheory::Linear, steps)
}

/// Returns the skin's faces at full depth as arrays: nodes of the touched face, then of the underside below it. For N
/// nodes: `place_mm`, `outward`, `displacement_mm` and `shear_mpa` (N x 3, sensor frame), `pressure_mpa` and `area_mm2`
/// (N). For each channel `volume_mm3` and `column_moves_mm`. For M markers: `mark_place_mm`, `mark_displacement_mm` and
/// `mark_axis` (M x 3).
pub fn skin_arrays(pressed: &SkinPressResult) -> Vec<NpyArray> {
    let nodes = pressed.last().map(|step| step.outcome.nodes(&pressed.stack)).unwrap_or_default();
    let channels = pressed.last().map(|step| &step.outcome.channels[..]).unwrap_or_default();
    let array = |name: &str, shape: Vec<usize>, values: Vec<f64>| NpyArray {
        name: name.into(),
        shape,
        values: NpyValues::F64(values),
    };
    let vectors = |name: &str, value: fn(&SkinNode) -> Vector3<f64>| {
        let values = nodes.iter().flat_map(|node| <[f64; 3]>::from(value(node)));
        array(name, vec![nodes.len(), 3], values.collect())
    };
    let numbers = |name: &str, value: fn(&SkinNode) -> f64| {
        array(name, vec![nodes.len()], nodes.iter().map(value).collect())
    };
    let by_channel = |name: &str, value: fn(&ChannelOutcome) -> f64| {
        array(name, vec![channels.len()], channels.iter().map(value).collect())
    };
    let [place, moved, axis] = marks_arrays(&pressed.marks);
    vec![
        vectors("place_mm", |node| node.place_mm),
        vectors("outward", |node| node.outward),
        vectors("displacement_mm", |node| node.displacement_mm),
        vectors("shear_mpa", |_| Vector3::zeros()),
        numbers("pressure_mpa", |node| node.pressure_mpa),
        numbers("area_mm2", |node| node.area_mm2),
        by_channel("volume_mm3", |channel| channel.volume_mm3),
        by_channel("column_moves_mm", |channel| channel.column_displacement_mm),
        place,
        moved,
        axis,
    ]
}
