//! Forecast of a pin calibration's accuracy, and choice of the next captures.

use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{Contact, FitParameter, Observation};
use fabkit_calibration::planning::{CapturePlan, ExpectedErrors, PinTolerances, PlanInputs};
use fabkit_camera::{Camera, CameraEstimate, Point2};
use fabkit_capture::LightConstants;
use fabkit_files::Error;
use fabkit_fixtures::{PoseForecast, Project};
use serde_json::{Value, json};

use super::CalibrationRunError;
use super::marks::{LandmarkShapes, PinMarkRenderer, RenderingView};
use crate::source::Source;

/// Smallest distance between two pins of one capture, in pin diameters. Marks of closer pins merge.
const MIN_DISTANCE_DIAMETERS: f64 = 3.0;
/// Numbers of captures, and of pins in each, for which the accuracy is tabulated.
const CAPTURE_COUNTS: [usize; 6] = [3, 5, 10, 20, 40, 80];
const PIN_COUNTS: [usize; 3] = [3, 5, 8];

/// Request for a capture plan.
#[derive(Clone, Copy, Debug)]
pub struct PlanRequest<'a> {
    /// Calibrated lens; without it, the design's lens is used and taken as exact.
    pub lens: Option<&'a CameraEstimate>,
    /// Pins of the captures already taken, as indices into the landmarks.
    pub done: &'a [Vec<usize>],
    /// Number of additional captures; without it, the rest of what the design plans.
    pub captures: Option<usize>,
    /// Pins in each capture; without it, as many as the design plans.
    pub pins: Option<usize>,
}

/// Recommended capture.
#[derive(Clone, Debug, PartialEq)]
pub struct NextCapture {
    /// Kind of all its pins.
    pub kind: String,
    /// Hole numbers, ascending.
    pub holes: Vec<u32>,
    /// Expected accuracy after this capture; `None` as long as the pins do not determine the pose.
    pub expected: Option<ExpectedErrors>,
}

/// Expected accuracy of captures, and the recommended next ones.
#[derive(Clone, Debug)]
pub struct PlanReport {
    /// Number of captures, pins in each, and expected accuracy, with all pins used in turn.
    pub efforts: Vec<(usize, usize, Option<ExpectedErrors>)>,
    /// Expected accuracy of the same number of captures with all kinds of pin, and with each kind alone.
    pub kinds: Vec<(String, Option<ExpectedErrors>)>,
    /// Expected accuracy of the captures already taken.
    pub done: Option<ExpectedErrors>,
    /// Recommended captures, in order.
    pub next: Vec<NextCapture>,
    /// Number of pins whose marks were rendered.
    pub marks_rendered: usize,
    /// Reason why no marks were rendered.
    pub unrendered_reason: Option<String>,
    /// Number of visible pins, and of all pins.
    pub visible_pins: [usize; 2],
    /// Tolerances of pins and dome.
    pub looseness: PinTolerances,
    /// Standard deviation of a mark's position along each coordinate, px.
    pub noise_px: f64,
    /// Number of captures, and pins in each, at which kinds are compared.
    pub compared: [usize; 2],
}

/// Builds the forecast for the pins of a sensor's dome or plate.
///
/// # Errors
/// A sensor without such a fixture, dimensions that cannot be built, or an invalid camera.
///
/// ```
/// use fabkit_application::calibration_runs::planning::build_forecast;
/// use fabkit_application::source::Source;
///
/// let source = Source::find("rtac0")?;
/// let forecast = build_forecast(&source, &source.load(&[])?)?;
/// // The pins of the dome, at their places in the camera's image.
/// assert!(forecast.model.camera.width_px() == 640);
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub fn build_forecast(source: &Source, project: &Project) -> Result<PoseForecast, Error> {
    let forecast = project.pin_forecast().map_err(|error| source.convert_fixture_error(error))?;
    forecast.map_err(|why| CalibrationRunError::NoForecast { why }.into())
}

/// Computes the expected accuracy of captures and chooses the next ones.
///
/// # Errors
/// Layers that cannot be pressed, or an invalid camera.
pub fn plan_captures(
    project: &Project,
    forecast: &PoseForecast,
    wanted: &PlanRequest<'_>,
) -> Result<PlanReport, Error> {
    let sensor = &project.design.sensor;
    let nominal = CameraEstimate::from(forecast.model.camera.without_interface());
    let lens = wanted.lens.unwrap_or(&nominal);
    let mut model = forecast.model.clone();
    let camera = |interface| {
        let own = lens.camera();
        Camera::new(own.width_px(), own.height_px(), *own.lens(), interface)
    };
    model.camera = camera(*forecast.model.camera.interface()).map_err(Error::bug)?;
    let tip_mm = forecast.landmarks.tip_radius_mm;
    let shapes = LandmarkShapes::Pins { radius_mm: tip_mm };
    let constants = LightConstants::for_sensor(sensor);
    let rendered = PinMarkRenderer::new(sensor, lens.camera(), &constants, Some(shapes));
    let not_marked = match &rendered {
        Ok(Some(_)) => None,
        Ok(None) => Some("the light constants of these pins' layers are not known".to_owned()),
        Err(error) => Some(error.to_string()),
    };
    let mut is_seen = forecast.is_seen.clone();
    if let Ok(Some(rendered)) = &rendered {
        let contacts: Vec<Observation> =
            forecast.landmarks.pins.iter().map(placeholder_observation).collect();
        let offsets = rendered.compute_offsets(
            &RenderingView::in_assumed_light(model.camera_from_sensor),
            &contacts,
            None,
        );
        for (pin, is_seen) in forecast.landmarks.pins.iter().zip(&mut is_seen) {
            // A pin whose mark cannot be detected gives no information.
            *is_seen &= offsets.offset_at(&pin.contact_in_sensor_mm).is_some();
        }
        model.mark_offsets = offsets;
    }
    let mut parameters = forecast.parameters.clone();
    let marks_rendered = if model.mark_offsets.is_empty() {
        0
    } else {
        // Rendered offsets depend on the light, so its parameters become unknowns of the fit.
        parameters.extend(FitParameter::LIGHT);
        is_seen.iter().filter(|is_seen| **is_seen).count()
    };
    let forecast = PoseForecast { model, parameters, is_seen, ..forecast.clone() };
    let setup = forecast.setup(lens);
    let plan = CapturePlan::new(&setup);
    let effort = forecast.effort;
    let per_capture = wanted.pins.unwrap_or(effort.pins_per_capture);
    let more = wanted.captures.unwrap_or_else(|| effort.captures.saturating_sub(wanted.done.len()));
    let of = |captures: usize, pins: usize| {
        (captures, pins, plan.predict(&forecast.plan_in_turn(captures, pins)))
    };
    let efforts =
        CAPTURE_COUNTS.iter().flat_map(|captures| PIN_COUNTS.map(|pins| of(*captures, pins)));
    let total = wanted.done.len() + more;
    Ok(PlanReport {
        efforts: efforts.collect(),
        kinds: compare_kinds(&forecast, setup, [total, per_capture]),
        done: plan.predict(wanted.done),
        next: choose_captures(&forecast, &plan, wanted.done, more, per_capture, 2.0 * tip_mm),
        marks_rendered,
        unrendered_reason: not_marked,
        visible_pins: [
            forecast.is_seen.iter().filter(|is_seen| **is_seen).count(),
            forecast.landmarks.pins.len(),
        ],
        looseness: forecast.looseness,
        noise_px: effort.sigma_px,
        compared: [total, per_capture],
    })
}

/// Makes a placeholder observation of a pin, for rendering its mark.
fn placeholder_observation(pin: &PinLandmark) -> Observation {
    Observation {
        contact: Contact {
            capture: 0,
            hole: pin.hole,
            contact_in_sensor_mm: pin.contact_in_sensor_mm,
            axis_in_sensor: pin.axis_in_sensor,
        },
        pixel: Point2::origin(),
        sigma_px: 1.0,
    }
}

/// Returns the kinds of pin in the order of the landmarks.
fn list_kinds(forecast: &PoseForecast) -> Vec<&str> {
    let mut kinds: Vec<&str> = Vec::new();
    for pin in &forecast.landmarks.pins {
        if !kinds.contains(&pin.kind.as_str()) {
            kinds.push(&pin.kind);
        }
    }
    kinds
}

/// Computes the expected accuracy with all kinds together, and with each kind alone.
fn compare_kinds(
    forecast: &PoseForecast,
    setup: PlanInputs<'_>,
    [captures, pins]: [usize; 2],
) -> Vec<(String, Option<ExpectedErrors>)> {
    let kinds = list_kinds(forecast);
    let alone = |kind: Option<&str>| {
        let is_seen: Vec<bool> = forecast
            .landmarks
            .pins
            .iter()
            .zip(&forecast.is_seen)
            .map(|(pin, is_seen)| *is_seen && kind.is_none_or(|kind| pin.kind == kind))
            .collect();
        let forecast = PoseForecast { is_seen, ..forecast.clone() };
        // Pins of other kinds count as invisible.
        CapturePlan::new(&PlanInputs { is_seen: &forecast.is_seen, ..setup })
            .predict(&forecast.plan_in_turn(captures, pins))
    };
    let all = std::iter::once(("all".to_owned(), alone(None)));
    all.chain(kinds.iter().map(|kind| ((*kind).to_owned(), alone(Some(kind))))).collect()
}

/// Chooses captures greedily, one after the other. Each uses pins of one kind whose marks do not merge.
fn choose_captures(
    forecast: &PoseForecast,
    plan: &CapturePlan,
    done: &[Vec<usize>],
    count: usize,
    pins: usize,
    diameter_mm: f64,
) -> Vec<NextCapture> {
    let all = &forecast.landmarks.pins;
    let mut captures = done.to_vec();
    let mut next = Vec::new();
    for _ in 0..count {
        let of_kind = |kind: &&str| {
            let may = |pin: usize, chosen: &[usize]| {
                let apart = |other: &usize| {
                    let [here, there] = [pin, *other].map(|pin| all[pin].contact_in_sensor_mm);
                    (here - there).norm() > MIN_DISTANCE_DIAMETERS * diameter_mm
                };
                all[pin].kind == **kind && chosen.iter().all(apart)
            };
            plan.choose_next_capture(&captures, pins, may)
        };
        let best = list_kinds(forecast).iter().map(of_kind).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((chosen, _)) = best.filter(|(chosen, _)| !chosen.is_empty()) else { break };
        let mut holes: Vec<u32> = chosen.iter().map(|pin| all[*pin].hole).collect();
        holes.sort_unstable();
        let kind = all[chosen[0]].kind.clone();
        captures.push(chosen);
        next.push(NextCapture { kind, holes, expected: plan.predict(&captures) });
    }
    next
}

impl PlanReport {
    /// Returns the plan as JSON (`fabkit-capture-plan` version 1).
    pub fn to_json(&self, sensor: &str, camera: Option<&str>) -> Value {
        let PinTolerances { across_mm, along_mm, seating_mm, dome_mm, dome_rad } = self.looseness;
        let expected = |expected: &Option<ExpectedErrors>| {
            expected.as_ref().map(|e| {
                json!({
                    "surface_mm": e.surface_mm,
                    "worst_mm": e.worst_mm,
                    "position_mm": e.position_mm,
                    "scatter_px": e.scatter_px,
                    "seating_solved": e.seating_solved,
                })
            })
        };
        let efforts = self.efforts.iter().map(|(captures, pins, e)| {
            json!({ "captures": captures, "pins": pins, "expected": expected(e) })
        });
        let kinds =
            self.kinds.iter().map(|(kind, e)| json!({ "kind": kind, "expected": expected(e) }));
        let next = self.next.iter().map(|next| {
            json!({ "kind": next.kind, "holes": next.holes, "expected": expected(&next.expected) })
        });
        json!({
            "format": "fabkit-capture-plan",
            "version": 1,
            "simulated": true,
            "sensor": sensor,
            "camera": camera,
            "noise_px": self.noise_px,
            "looseness": {
                "tip_across_mm": across_mm,
                "tip_along_mm": along_mm,
                "seating_mm": seating_mm,
                "dome_mm": dome_mm,
                "dome_deg": dome_rad.map(f64::to_degrees),
            },
            "pins": self.visible_pins[1],
            "pins_seen": self.visible_pins[0],
            "marks_rendered": self.marks_rendered,
            "not_marked": self.unrendered_reason,
            "compared": { "captures": self.compared[0], "pins": self.compared[1] },
            "efforts": efforts.collect::<Vec<_>>(),
            "kinds": kinds.collect::<Vec<_>>(),
            "done": expected(&self.done),
            "next": next.collect::<Vec<_>>(),
        })
    }
}
