use fabkit_application::{fixtures, ground_truth::Viewpoint};
use fabkit_optics::*;
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let yaml = fabkit_application::designs::builtin_yaml(&name).unwrap();
    let project = fixtures::load(&format!("{name}.yaml"), yaml, &[]).unwrap();
    let s = &project.design.sensor;
    let stack = Stack::of(s).unwrap();
    let v = Viewpoint::new(&s.camera, None, None).unwrap();
    let rays = v.rays(1);
    let (w, h) = (s.camera.width_px, s.camera.height_px);
    let bundles = Bundles::new(&stack);
    for k in 0..4 {
        let mut tracer = bundles.tracer();
        let (x, y) = (w / 2 + k * 64, h / 2 + k * 32);
        let mut n = 0;
        tracer.cast(
            x..x + TILE,
            y..y + TILE,
            &|c, r| rays.ray((r * w + c) as usize),
            &mut |_, _, _| n += 1,
        );
        println!("{k}: {} of {n} alone", tracer.singles());
    }
}
