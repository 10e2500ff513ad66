//! Presses at large strain.

use crate::support::{ball_over, layer, press_down, round_layer, stack, two_layers};
use fabkit_elastic::{ElasticError, FiniteStack, LayeredBody, MeshDensity, StrainTheory};

#[test]
fn a_shallow_press_is_the_linear_one() {
    for body in [two_layers(), round_layer(0.495)] {
        let division = MeshDensity::around_pole(0.02, 1.0, 0);
        let depth_mm = 0.01;
        let linear = press_down(&stack(&body, division), 4.0, depth_mm);
        let finite = FiniteStack::new(&body, &division).unwrap();
        let outcome = &finite.press(&ball_over(0.0, 0.0, 4.0), &[depth_mm]).unwrap()[0];
        assert_eq!(outcome.level, StrainTheory::Finite);
        // Strains are about a / R = 5 %; the theories differ by their square, and by the depth relative to the
        // thickness.
        let of_force = outcome.force_n.z / linear.force_n.z - 1.0;
        println!("{of_force:+.5}");
        assert!(of_force.abs() < 0.02, "{of_force}");
        for &s in linear.columns() {
            let [a, b] = [&linear, outcome].map(|o| o.displacement_mm(0, 0.0, s));
            assert!((a - b).norm() < 0.02 * depth_mm, "{s}: {a} {b}");
        }
    }
}

#[test]
fn work_goes_into_the_layers() {
    let body = LayeredBody::pad(8.0, vec![(layer(0.1, 0.49), 3.0)]);
    let finite = FiniteStack::new(&body, &MeshDensity::around_pole(0.1, 3.5, 0)).unwrap();
    let depths: Vec<f64> = (1..=12).map(|i| 0.1 * f64::from(i)).collect();
    let outcomes = finite.press(&ball_over(0.0, 0.0, 4.0), &depths).unwrap();
    // Force is the derivative of energy. Simpson's rule in steps of 0.1 up to 1.2 mm integrates a force that rises with
    // about the 1.7th power to within 0.3 %.
    for i in (1..depths.len()).step_by(2) {
        let force = |k: usize| -outcomes[k].force_n.z;
        if i >= 3 {
            let work = 0.1 / 3.0 * (force(i - 2) + 4.0 * force(i - 1) + force(i));
            let energy = outcomes[i].energy_nmm.unwrap() - outcomes[i - 2].energy_nmm.unwrap();
            assert!((work / energy - 1.0).abs() < 0.003, "{}: {work} {energy}", depths[i]);
        }
    }
}

#[test]
fn a_deep_press_keeps_volume_and_reaches_its_depth() {
    let body = LayeredBody::pad(8.0, vec![(layer(0.1, 0.4999), 3.0)]);
    let finite = FiniteStack::new(&body, &MeshDensity::around_pole(0.1, 3.5, 0)).unwrap();
    let outcome = &finite.press(&ball_over(0.0, 0.0, 4.0), &[0.5, 1.0, 1.5]).unwrap()[2];
    assert!((outcome.max_indentation_mm - 1.5).abs() < 0.01, "{}", outcome.max_indentation_mm);
    let pushed_in: f64 =
        outcome.nodes.iter().map(|n| (-n.displacement_mm.z).max(0.0) * n.area_mm2).sum();
    assert!(outcome.volume_change_mm3[0].abs() < 0.005 * pushed_in);
    assert!(outcome.bulge_mm > 0.05);
}

#[test]
fn invalid_finite_presses_are_refused() {
    let finite = FiniteStack::new(&two_layers(), &MeshDensity::uniform(0.3, 0)).unwrap();
    let ball = ball_over(0.0, 0.0, 4.0);
    assert!(matches!(finite.press(&ball, &[0.2, 0.1]), Err(ElasticError::Press { .. })));
    assert!(matches!(finite.press(&ball, &[f64::NAN]), Err(ElasticError::Press { .. })));
    assert!(matches!(finite.press(&ball, &[3.5]), Err(ElasticError::TooDeep { .. })));
    let aside = ball_over(1.0, 0.0, 4.0);
    assert!(matches!(finite.press(&aside, &[0.1]), Err(ElasticError::Press { .. })));
}
