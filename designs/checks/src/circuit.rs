//! Circuits: LEDs have enough voltage and are not overloaded, nets connect at least two pins, boards exist.
//!
//! Etched copper is checked elsewhere. This rule checks what the circuit states, with or without a board.

use std::collections::BTreeMap;

use fabkit_geometry::{
    Circuit, CircuitKind, CircuitPart, CompiledSolid, Land, Net, Point3, Ray, Scratch, Sensor,
    SeriesResistor, Vector3,
};

use crate::declaration::rule;
use crate::finding::Finding;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::scene::InvalidBody;

rule! {
    /// LEDs shine and are not overloaded, nets connect, boards exist.
    Circuit = "circuit",
    examines: "circuits",
    finds: "LEDs that need more voltage than the supply has, that burn or overload their \
             resistors, for which no resistor is calculated, or that are reversed compared with \
             others; more current than the supply delivers; nets with one end, pins that are on \
             no net or on two; circuit boards that are not bodies, and pads outside them",
    limit: "the ratings in the design (`leds.rated_ma`, `leds.supply_ma`) and of the resistor's \
             package",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    examine(case.sensor)
}

/// Largest relative difference of currents that count as equal.
const SAME: f64 = 1e-9;

/// Number of points on the outline of a land that are checked.
const AROUND: usize = 8;

/// Finds errors in circuits. Also returns the number of circuits.
pub(crate) fn examine(sensor: &Sensor) -> Result<(Vec<Finding>, usize), InvalidBody> {
    let mut findings = Vec::new();
    for circuit in &sensor.circuits {
        let mut of_one = nets(circuit);
        of_one.extend(circuit.resistors.iter().flat_map(|one| lamps(circuit, one)));
        of_one.extend(counted(circuit));
        of_one.extend(polarity(circuit));
        of_one.extend(supply(circuit));
        let bodies = circuit.board.as_deref();
        findings.extend(of_one.into_iter().map(|finding| finding.about_bodies(bodies)));
        findings.extend(board(sensor, circuit)?);
    }
    Ok((findings, sensor.circuits.len()))
}

/// Creates an error that starts with the circuit's name.
fn error(circuit: &Circuit, what: &str, fix: &str) -> Finding {
    Finding::error(Rule::Circuit, format!("{}: {what}", circuit.name), fix)
}

/// Returns whether a value is finite and above 0. A comparison alone would let infinity pass.
fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Finds nets with fewer than two pins, pins that do not exist, pins on two nets, and unconnected pins of LEDs and
/// resistors.
fn nets(circuit: &Circuit) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut on: BTreeMap<(&str, &str), Vec<&str>> = BTreeMap::new();
    for Net { name, pins, .. } in &circuit.nets {
        for (part, pin) in pins {
            // Collects the nets of each pin, to find pins on two nets.
            on.entry((part, pin)).or_default().push(name);
        }
        if pins.len() < 2 {
            let end = pins.first().map_or("nothing".into(), |(part, pin)| format!("{part}.{pin}"));
            let what = format!("net {name} has {} of the 2 ends that it needs: {end}", pins.len());
            let fix = "connect its other end, or leave the net out";
            found.push(error(circuit, &what, fix).with_measurement(pins.len() as f64, 2.0, "ends"));
        }
    }
    for ((part, pin), nets) in &on {
        let lands = circuit.part(part).map(|part| &part.lands);
        if !lands.is_some_and(|lands| lands.iter().any(|land| land.pin == *pin)) {
            let what = format!("net {} ends at {part}.{pin}, which is no pin of a part", nets[0]);
            found.push(error(circuit, &what, "name a part of the circuit and one of its pins"));
        }
        if let [first, second, ..] = nets[..] {
            let what = format!("{part}.{pin} is on two nets, {first} and {second}");
            found.push(error(circuit, &what, "put the pin on one net, or join the two nets"));
        }
    }
    // Other parts may have unused pins.
    let has_two_ends =
        |part: &&CircuitPart| matches!(part.kind, CircuitKind::Led | CircuitKind::Resistor);
    for part in circuit.parts.iter().filter(has_two_ends) {
        for land in &part.lands {
            if !on.contains_key(&(&*part.designator, &*land.pin)) {
                let what = format!("{}.{} is connected to nothing", part.designator, land.pin);
                found.push(error(circuit, &what, "put it on a net"));
            }
        }
    }
    found
}

/// Compares voltage, current and power of a resistor and its LEDs with their ratings.
fn lamps(circuit: &Circuit, one: &SeriesResistor) -> Vec<Finding> {
    let names = one.designators.join(", ");
    // The checks below divide by these values or compare with them.
    let is_known = [one.supply_v, one.forward_v, one.ohms, one.rated_w, one.led_rated_a];
    if let Some(value) = is_known.into_iter().find(|value| !is_positive(*value)) {
        let what = format!("{names} is calculated with {value}; this value must be above 0");
        let fix = "state supply, forward voltage, resistance and both ratings as positive numbers";
        return vec![error(circuit, &what, fix)];
    }
    let mut found = Vec::new();
    if one.forward_v >= one.supply_v {
        let what = format!(
            "the LEDs behind {names} need {} V to shine, but the supply has {} V",
            one.forward_v, one.supply_v
        );
        let fix = "take a supply of a higher voltage, or LEDs of a lower forward voltage";
        found.push(error(circuit, &what, fix).with_measurement(one.forward_v, one.supply_v, "V"));
    }
    let (led_a, watts) = (one.led_a(), one.power_w());
    if led_a > one.led_rated_a * (1.0 + SAME) {
        let what = format!(
            "each LED behind {names} takes {:.1} mA, but withstands only {} mA",
            led_a * 1e3,
            one.led_rated_a * 1e3
        );
        let fix = "ask for less current, or take a larger resistor";
        found.push(error(circuit, &what, fix).with_measurement(led_a, one.led_rated_a, "A"));
    }
    if watts > one.rated_w * (1.0 + SAME) {
        let what =
            format!("{names} turns {watts:.3} W to heat, but withstands only {} W", one.rated_w);
        let fix = "ask for less current, or take a larger resistor";
        found.push(error(circuit, &what, fix).with_measurement(watts, one.rated_w, "W"));
    }
    for name in &one.designators {
        if circuit.part(name).is_none_or(|part| part.kind != CircuitKind::Resistor) {
            let what =
                format!("{name} is calculated, but the circuit has no resistor of this name");
            found.push(error(circuit, &what, "name a resistor of the circuit"));
        }
    }
    found
}

/// Compares the number of LEDs with the number for which resistors are calculated.
fn counted(circuit: &Circuit) -> Option<Finding> {
    let there = circuit.parts.iter().filter(|part| part.kind == CircuitKind::Led).count();
    // Each designator is a resistor of its own, which `leds` LEDs share.
    let shared = circuit.resistors.iter().map(|one| one.designators.len() * one.leds as usize);
    let calculated: usize = shared.sum();
    (there != calculated).then(|| {
        let what = format!("the circuit has {there} LEDs, but resistors for {calculated} of them");
        let fix =
            "calculate a resistor for every LED, and none for LEDs that the circuit does not have";
        error(circuit, &what, fix).with_measurement(calculated as f64, there as f64, "LEDs")
    })
}

/// Finds LEDs that are reversed: on a net with more than two pins, all LEDs must connect with the same end. On a net
/// with two pins, two LEDs in series connect with different ends. The minority counts as reversed.
fn polarity(circuit: &Circuit) -> Vec<Finding> {
    let is_led = |part: &str| circuit.part(part).is_some_and(|part| part.kind == CircuitKind::Led);
    let mut found = Vec::new();
    for net in circuit.nets.iter().filter(|net| net.pins.len() > 2) {
        let ends = |wanted: &str| -> Vec<&str> {
            let pins = net.pins.iter().filter(|(part, pin)| pin == wanted && is_led(part));
            pins.map(|(part, _)| part.as_str()).collect()
        };
        let (anodes, cathodes) = (ends("A"), ends("K"));
        if !anodes.is_empty() && !cathodes.is_empty() {
            // The smaller group is taken to be wrong.
            let is_anode = anodes.len() <= cathodes.len();
            let (turned, end) = if is_anode { (anodes, "anode") } else { (cathodes, "cathode") };
            let what = format!(
                "{} meets net {} with its {end}, and other LEDs do not: it is reversed",
                turned.join(", "),
                net.name
            );
            found.push(error(circuit, &what, "connect all LEDs of a net with the same end"));
        }
    }
    found
}

/// Compares the stated current with that of the resistors, and the supply with both.
fn supply(circuit: &Circuit) -> Vec<Finding> {
    let mut found = Vec::new();
    let each = circuit.resistors.iter().map(|one| one.designators.len() as f64 * one.current_a());
    let sum_a: f64 = each.sum();
    if !(circuit.resistors.is_empty() || (circuit.current_a - sum_a).abs() <= SAME * sum_a) {
        let what = format!(
            "it is stated to take {:.1} mA, but its resistors let {:.1} mA through",
            circuit.current_a * 1e3,
            sum_a * 1e3
        );
        let fix = "state the current that the resistors let through";
        found.push(error(circuit, &what, fix).with_measurement(circuit.current_a, sum_a, "A"));
    }
    for one in &circuit.resistors {
        if one.supply_v != circuit.supply_v {
            let names = one.designators.join(", ");
            let what = format!(
                "{names} is calculated for {} V, but the circuit's supply has {} V",
                one.supply_v, circuit.supply_v
            );
            let fix = "calculate it for the circuit's supply";
            found.push(error(circuit, &what, fix).with_measurement(
                one.supply_v,
                circuit.supply_v,
                "V",
            ));
        }
    }
    if let Some(most_a) = circuit
        .supply_a
        // NaN must fail the check.
        .filter(|most| circuit.current_a.is_nan() || circuit.current_a > most * (1.0 + SAME))
    {
        let what = format!(
            "all LEDs take {:.0} mA, but the supply delivers {:.0} mA",
            circuit.current_a * 1e3,
            most_a * 1e3
        );
        let fix = "ask for less current or fewer LEDs, or take a stronger supply";
        found.push(error(circuit, &what, fix).with_measurement(circuit.current_a, most_a, "A"));
    }
    found
}

/// Checks that the board exists and that all placed lands lie on it.
fn board(sensor: &Sensor, circuit: &Circuit) -> Result<Vec<Finding>, InvalidBody> {
    let Some(name) = circuit.board.as_deref() else { return Ok(Vec::new()) };
    let Some(body) = sensor.body(name) else {
        let what = format!("it is on `{name}`, but the sensor has no body of this name");
        return Ok(vec![error(circuit, &what, "name the part that is etched")]);
    };
    let solid = CompiledSolid::new(&body.solid)
        .map_err(|source| InvalidBody { body: name.to_owned(), source })?;
    // The lines start 1 mm below the board.
    // Outside of the board, so that the first crossing is its lower face.
    let bottom = solid.bounds().min.z - 1.0;
    let (mut scratch, mut stretches) = (Scratch::default(), Vec::new());
    let mut is_on = |[x, y]: [f64; 2]| {
        let ray = Ray { origin: Point3::new(x, y, bottom), direction: Vector3::z() };
        solid.stretches_into(&ray, &mut scratch, &mut stretches);
        !stretches.is_empty()
    };
    let mut found = Vec::new();
    for part in &circuit.parts {
        let Some(place) = part.place else { continue };
        for land in &part.lands {
            let beside = around(land).map(|at| place.point(at)).find(|at| !is_on(*at));
            if let Some(at) = beside {
                let what = format!(
                    "the pad {}.{} reaches to ({:.2}, {:.2}) mm, beyond {name}",
                    part.designator, land.pin, at[0], at[1]
                );
                let place = Point3::new(at[0], at[1], solid.bounds().max.z);
                let finding = error(circuit, &what, "move the part, or make the board larger");
                found.push(finding.about_bodies([name]).at_position(Some(place)));
            }
        }
    }
    Ok(found)
}

/// Iterates over points on the outline of a land, in the frame of its part, mm: corners and middles of sides, or points
/// of the circle.
fn around(land: &Land) -> impl Iterator<Item = [f64; 2]> {
    let Land { at_mm: [x, y], size_mm, is_round, .. } = land.clone();
    (0..AROUND).map(move |i| {
        let (sin, cos) = (i as f64 * std::f64::consts::TAU / AROUND as f64).sin_cos();
        // For a rectangle, the circle's points are pushed out to its sides.
        let [a, b] = if is_round {
            [size_mm[0] * cos, size_mm[0] * sin]
        } else {
            // Distance to the side of a unit square in this direction, which pushes the point out to the square.
            let far = cos.abs().max(sin.abs());
            [size_mm[0] * cos / far, size_mm[1] * sin / far]
        };
        [x + a / 2.0, y + b / 2.0]
    })
}
