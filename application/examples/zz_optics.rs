use fabkit_application::{fixtures, ground_truth::Viewpoint};
use fabkit_geometry::*;
use fabkit_optics::*;
use std::time::Instant;
fn main() {
    for name in std::env::args().skip(1) {
        let yaml = fabkit_application::designs::builtin_yaml(&name).unwrap();
        let project = fixtures::load(&format!("{name}.yaml"), yaml, &[]).unwrap();
        let s = &project.design.sensor;
        let stack = match Stack::of(s) {
            Ok(s) => s,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let v = Viewpoint::new(&s.camera, None, None).unwrap();
        let rays = v.rays(1);
        let (w, h) = (s.camera.width_px, s.camera.height_px);
        let t = Instant::now();
        let bundles = Bundles::new(&stack);
        let made = t.elapsed().as_secs_f64();
        let mut tracer = bundles.tracer();
        let t = Instant::now();
        let mut out: Vec<Option<LightPath>> = vec![None; (w * h) as usize];
        for y in (0..h).step_by(TILE as usize) {
            for x in (0..w).step_by(TILE as usize) {
                tracer.cast(
                    x..(x + TILE).min(w),
                    y..(y + TILE).min(h),
                    &|c, r| rays.ray((r * w + c) as usize),
                    &mut |c, r, p| {
                        assert!(out[(r * w + c) as usize].is_none());
                        out[(r * w + c) as usize] = Some(p)
                    },
                );
            }
        }
        let dt = t.elapsed().as_secs_f64();
        let single = tracer.singles();
        println!(
            "{name}: made {made:.4} s, {:.3} Mray/s, single {:.4}",
            rays.len() as f64 / dt / 1e6,
            single as f64 / rays.len() as f64
        );
        let mut tracer = Tracer::new(&stack);
        let (mut worst, mut wrong) = (0.0f64, 0);
        for i in (0..rays.len()).step_by(if std::env::var("FAST").is_ok() {
            100_003
        } else if rays.len() > 1_000_000 {
            17
        } else {
            3
        }) {
            let Some(ray) = rays.ray(i) else {
                assert!(out[i].is_none());
                continue;
            };
            let a = tracer.follow(&ray);
            let b = out[i].unwrap();
            if a.end != b.end || a.bends != b.bends {
                wrong += 1;
                if wrong < 4 {
                    println!("  {i} {a:?} {b:?}");
                }
            } else if a.end_mm.is_finite() {
                worst = worst
                    .max((a.last.at(a.end_mm) - b.last.at(b.end_mm)).norm())
                    .max((a.lead_mm - b.lead_mm).abs());
            }
        }
        println!("   wrong {wrong}, worst {worst:.2e} mm");
    }
}
