use fabkit_application::{fixtures, ground_truth::Viewpoint};
use fabkit_optics::*;
fn main() {
    for name in std::env::args().skip(1) {
        let yaml = fabkit_application::designs::builtin_yaml(&name).unwrap();
        let project = fixtures::load(&format!("{name}.yaml"), yaml, &[]).unwrap();
        let s = &project.design.sensor;
        let stack = Stack::of(s).unwrap();
        let v = Viewpoint::new(&s.camera, None, None).unwrap();
        let rays = v.rays(1);
        let mut tracer = Tracer::new(&stack);
        let t = std::time::Instant::now();
        let mut n = 0;
        for i in (0..rays.len()).step_by(37) {
            if let Some(ray) = rays.ray(i) {
                tracer.follow(&ray);
                n += 1;
            }
        }
        println!(
            "{name} {:.2} us a ray; counts {:?}",
            t.elapsed().as_secs_f64() * 1e6 / n as f64,
            tracer
                .counts
                .iter()
                .enumerate()
                .map(|(i, c)| (stack.name_of(i), *c as f64 / n as f64))
                .filter(|x| x.1 > 0.0)
                .collect::<Vec<_>>()
        );
    }
}
