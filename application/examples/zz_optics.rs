use fabkit_application::{fixtures, ground_truth::Viewpoint};
use fabkit_geometry::*;
use fabkit_optics::*;
use std::time::Instant;
fn main() {
    for name in std::env::args().skip(1) {
        let yaml = fabkit_application::designs::builtin_yaml(&name).unwrap();
        let project = fixtures::load(&format!("{name}.yaml"), yaml, &[]).unwrap();
        let s = &project.design.sensor;
        let t = Instant::now();
        let stack = match Stack::of(s) { Ok(s) => s, Err(e) => { println!("{name}: {e}"); continue } };
        let made = t.elapsed().as_secs_f64();
        let v = Viewpoint::new(&s.camera, None, None).unwrap();
        let rays = v.rays(1);
        let mut tracer = Tracer::new(&stack);
        let mut count = std::collections::BTreeMap::new();
        let t = Instant::now();
        let (mut n, mut bends) = (0, 0);
        for i in 0..rays.len() {
            let Some(ray) = rays.ray(i) else { continue };
            let p = tracer.follow(&ray);
            n += 1; bends += p.bends;
            let w = match p.end { End::Surface => "surface".to_string(), End::Body(b) => stack.names()[b as usize].clone(), End::Mirror(b) => format!("mirror at {}", stack.names()[b as usize]), End::Nothing => "nothing".into() };
            *count.entry(w).or_insert(0) += 1;
        }
        let dt = t.elapsed().as_secs_f64();
        println!("{name}: made {made:.3} s, {:.3} Mray/s, bends {:.2}", n as f64/dt/1e6, bends as f64/n as f64);
        for (w, c) in count { println!("   {w:30} {:.4}", c as f64 / rays.len() as f64); }
        if name == "rtac0" { let ray = rays.ray(1*640+240).unwrap(); println!("{:?} {:?}", tracer.follow(&ray), tracer.corners()); 
        let ray = rays.ray(240*640+1).unwrap(); println!("{:?} {:?}", tracer.follow(&ray), tracer.corners()); }
    }
}
